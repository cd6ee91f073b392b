// At the bottom: the error of every revision of the model, on the flights that it was learned from and on those held out.

import type { JSX } from "preact";

import { metres } from "../charts/number";
import { holdOuts, learners, sensor } from "../state/flights";
import { guides, ladder } from "../state/studio";
import type { Judged } from "../state/studio";
import { capital, sensorName } from "./words";

interface Rung {
  readonly number: number;
  readonly title: string;
  readonly learned: number | null;
  readonly heldOut: number | null;
}

export function LadderPanel(): JSX.Element {
  const rungs = ladder.answer.value && sensor.value !== null ? rungsOf(ladder.answer.value, sensor.value) : [];
  const most = Math.max(...rungs.flatMap(({ learned, heldOut }) => [learned ?? 0, heldOut ?? 0]), 1e-9);
  const hasHeldOut = holdOuts.value.length > 0;
  return (
    <section class="ladder" aria-label="Revisions of the model" data-tour="ladder">
      <div class="ladder-head">
        <h2>Revisions</h2>
        <p class="faint">
          {sensor.value === null ? "" : `${sensorName(sensor.value)}, `}rms error{learnersFly() ? " in free flight" : ""}, m
        </p>
        <p class="legend-entry"><span class="swatch area learned" aria-hidden="true" />learned</p>
        {hasHeldOut ? <p class="legend-entry"><span class="swatch area held-out" aria-hidden="true" />held out</p> : null}
      </div>
      <ol class="rungs">
        {rungs.map((rung, at) => (
          <li key={rung.number} class={at === rungs.length - 1 ? "rung newest" : "rung"}>
            <p class="rung-title" title={rung.title}><b>{rung.number}</b> {rung.title}</p>
            <Bar kind="learned" value={rung.learned} most={most} />
            {hasHeldOut ? <Bar kind="held-out" value={rung.heldOut} most={most} /> : null}
          </li>
        ))}
        {rungs.length === 1 ? <li class="rung-hint faint">Add an effect: the next revision stands here, with its error.</li> : null}
      </ol>
    </section>
  );
}

function learnersFly(): boolean {
  return learners.value.some(({ opened }) => opened?.overview.has_launch === true);
}

function Bar({ kind, value, most }: { readonly kind: "learned" | "held-out"; readonly value: number | null; readonly most: number }): JSX.Element | null {
  if (value === null) return null;
  return (
    <p class="rung-bar">
      <span class="hidden-text">{kind === "learned" ? "learned: " : "held out: "}</span>
      <span class="rung-track" aria-hidden="true"><span class={kind} style={{ width: `${(100 * value) / most}%` }} /></span>
      <span class="number">{metres(value)}</span>
    </p>
  );
}

function rungsOf({ ladder: { revisions }, learned }: Judged, name: string): Rung[] {
  return revisions.map(({ number, effect, flights }) => {
    const errors = (heldOut: boolean): number[] => flights
      .filter((_, place) => (place >= learned) === heldOut)
      .map(({ sensors }) => sensors[name]?.free_flight_rms_m ?? sensors[name]?.captive_rms_m ?? null)
      .filter((value) => value !== null);
    return {
      number,
      title: effect === null ? "the model as it began" : capital(guides.value.get(effect)?.title ?? effect),
      learned: rms(errors(false)),
      heldOut: rms(errors(true)),
    };
  });
}

function rms(errors: ReadonlyArray<number>): number | null {
  if (errors.length === 0) return null;
  return Math.sqrt(errors.reduce((sum, error) => sum + error * error, 0) / errors.length);
}
