// The screen without a flight: first the user's own log, then the flights that come with Pylon.

import { batch, signal } from "@preact/signals";
import type { JSX } from "preact";
import { useEffect } from "preact/hooks";

import { ask } from "../ask";
import type { Sample } from "../protocol";
import { chooseFiles } from "../state/files";
import { notice, openSample } from "../state/flights";
import { offered, openOffered } from "../state/offered";
import type { Offered } from "../state/offered";
import { messageOf } from "../state/resource";
import { beginTour } from "./tour";
import { capital, plain } from "./words";

const samples = signal<ReadonlyArray<Sample> | null>(null);
/** Embedded after the page's script, like the engine: when the engine answers, both are there. */
const real = signal<ReadonlyArray<Offered>>([]);

export function FirstScreen(): JSX.Element {
  useEffect(() => {
    if (samples.value !== null) return;
    ask("samples", {}).then((answer) => batch(() => { samples.value = answer; real.value = offered(); }), (error: unknown) => { notice.value = messageOf(error); });
  }, []);
  return (
    <main class="first" aria-label="Open a flight">
      <section class="drop-zone">
        <DropPicture />
        <h2>Open a flight log</h2>
        <p>Drop it anywhere on this page, or</p>
        <button type="button" class="main" onClick={chooseFiles}>Choose a log…</button>
        <p class="faint">PX4 ULog, ArduPilot DataFlash, MAVLink tlog, IGC, AltusMetrum CSV, MCAP, Pylon's own CSV.</p>
        <p class="faint">Everything is computed in this page. No byte leaves this machine.</p>
      </section>
      <section class="samples" aria-label="Flights that come with Pylon">
        {real.value.length > 0 ? (
          <>
            <h2>Or look at a real one</h2>
            <ul>
              {real.value.map((flight) => (
                <li key={flight.file}>
                  <button type="button" class="sample" data-offered={flight.file} onClick={() => void openOffered(flight)}>
                    <b>{flight.title}</b>
                    <span>{flight.about} Log: {flight.from}.</span>
                  </button>
                </li>
              ))}
            </ul>
          </>
        ) : null}
        <h2>Or {real.value.length > 0 ? "at" : "look at"} a simulated one</h2>
        <ul>
          {(samples.value ?? []).map(({ name, about }) => (
            <li key={name}>
              <button type="button" class="sample" data-sample={name} onClick={() => void openSample(name)}>
                <b>{capital(plain(name.replaceAll("-", " ")))}</b>
                <span>{about}</span>
              </button>
            </li>
          ))}
          {samples.value === null ? <li class="faint">The engine is loading…</li> : null}
        </ul>
        <button type="button" onClick={beginTour}>Show me around: five steps</button>
      </section>
    </main>
  );
}

// Two curves that part, and meet again.
function DropPicture(): JSX.Element {
  return (
    <svg class="drop-picture" viewBox="0 0 220 80" aria-hidden="true">
      <path d="M4 62 C40 60 48 52 70 40 S120 14 150 14 S196 22 216 20" class="measured" />
      <path d="M4 62 C40 60 48 52 70 46 S120 40 150 36 S190 24 216 21" class="modelled" />
    </svg>
  );
}
