// A log that was read but can't be analysed: why, and what is in it.

import type { JSX } from "preact";

import { short } from "../charts/number";
import type { Opened } from "../protocol";
import { capital, plain } from "./words";

export function Refused({ opened }: { readonly opened: Opened }): JSX.Element {
  const { overview } = opened;
  return (
    <section class="refused" aria-label="Why this log can't be analysed">
      <h2>{overview.file} was read, but can't be analysed</h2>
      <p>{capital(overview.refused ?? "")}.</p>
      <table>
        <thead><tr><th scope="col">{overview.format} has</th><th scope="col" /><th scope="col">samples</th><th scope="col">a second</th></tr></thead>
        <tbody>
          {overview.sensors.map(({ sensor, state, samples, rate_hz }) => (
            <tr key={sensor}>
              <th scope="row">{sensor}</th>
              <td>{plain(String(state))}</td>
              <td class="number">{samples}</td>
              <td class="number">{rate_hz === null ? "" : short(rate_hz)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {overview.notes.map((note) => <p key={note} class="faint">{note}</p>)}
    </section>
  );
}
