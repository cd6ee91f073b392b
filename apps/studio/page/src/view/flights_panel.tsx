// Left: the flights, by vehicle; what each is for, how much of it is used, and what to know about it.

import type { JSX } from "preact";

import { clock, percent } from "../charts/number";
import { chooseFiles } from "../state/files";
import { close, setUse, show, shownId, vehicles } from "../state/flights";
import { Coefficients } from "./coefficients";
import type { Flight, Use } from "../state/flights";

const USES: ReadonlyArray<{ use: Use; text: string }> = [
  { use: "learn", text: "learn from" },
  { use: "hold_out", text: "judge by" },
  { use: "off", text: "look only" },
];

export function FlightsPanel(): JSX.Element {
  return (
    <nav class="side flights" aria-label="Flights" data-tour="flights">
      <div class="side-head">
        <h2>Flights</h2>
        <button type="button" onClick={chooseFiles}>Open…</button>
      </div>
      {vehicles.value.map(({ name, flights }) => (
        <section key={name} class="vehicle">
          <h3 title={name}>{name}</h3>
          <Coefficients vehicle={name} />
          <ul>{flights.map((flight) => <Row key={flight.id} flight={flight} />)}</ul>
        </section>
      ))}
      <p class="faint pad drop-hint">Drop logs anywhere on this page. They stay on this machine.</p>
    </nav>
  );
}

function Row({ flight }: { readonly flight: Flight }): JSX.Element {
  const { id, file, opened, problem } = flight;
  const isShown = shownId.value === id;
  return (
    <li class={`flight ${isShown ? "shown" : ""} ${problem === null ? "" : "failed"}`}>
      <div class="flight-head">
        {opened ? (
          <button type="button" class="plain flight-name" aria-pressed={isShown} title={file} onClick={() => show(id)}>{file}</button>
        ) : <span class="flight-name" title={file}>{file}</span>}
        <button type="button" class="plain close" aria-label={`Close ${file}`} title="Close" onClick={() => close(id)}>×</button>
      </div>
      {problem !== null ? <p class="flight-problem" role="alert">{problem}</p> : null}
      {opened ? <Facts flight={flight} /> : problem === null ? <p class="faint">reading…</p> : null}
    </li>
  );
}

function Facts({ flight }: { readonly flight: Flight }): JSX.Element | null {
  const { id, file, opened, use } = flight;
  if (!opened) return null;
  const { overview } = opened;
  const notes = [...(overview.refused === null ? [] : [overview.refused]), ...overview.remarks, ...overview.notes.map(String)];
  const unused = overview.unused.map(({ from_s, to_s, reason }) => `${clock(from_s)} to ${clock(to_s)} not used: ${reason}`);
  const all = [...notes, ...unused];
  return (
    <>
      <div class="flight-facts">
        <span class="number faint">{clock(overview.duration_s)}</span>
        <span class="used" title={`${percent(overview.used_share)} of the record is used`}>
          <span class="used-bar" aria-hidden="true"><span style={{ width: `${100 * overview.used_share}%` }} /></span>
          <span class="number faint">{percent(overview.used_share)} used</span>
        </span>
        <select aria-label={`What ${file} is for`} value={use} onChange={(event) => {
          const found = USES.find((one) => one.use === event.currentTarget.value);
          if (found) setUse(id, found.use);
        }}>
          {USES.map((one) => <option key={one.use} value={one.use} selected={one.use === use}>{one.text}</option>)}
        </select>
      </div>
      {all.length > 0 ? (
        <details class="notes">
          <summary>{overview.refused === null ? `${all.length} ${all.length === 1 ? "note" : "notes"}` : "can't be analysed"}</summary>
          <ul>
            {overview.calibration === null ? null : <li>{overview.calibration}</li>}
            {all.map((text) => <li key={text}>{text}</li>)}
          </ul>
        </details>
      ) : null}
    </>
  );
}
