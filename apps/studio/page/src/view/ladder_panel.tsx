// At the bottom: the error of each revision of the model, on the flights learned from and on those held out.

import type { JSX } from "preact";

import { metres } from "../charts/number";
import { holdOuts, learners, sensor } from "../state/flights";
import { guides, ladder } from "../state/studio";
import type { Judged } from "../state/studio";
import { capital, sensorName } from "./words";

interface LadderRevision {
  readonly number: number;
  readonly title: string;
  readonly learned: number | null;
  readonly heldOut: number | null;
}

export function LadderPanel(): JSX.Element {
  const revisions = ladder.answer.value && sensor.value !== null ? revisionsOf(ladder.answer.value, sensor.value) : [];
  const most = Math.max(...revisions.flatMap(({ learned, heldOut }) => [learned ?? 0, heldOut ?? 0]), 1e-9);
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
      <ol class="revisions">
        {revisions.map((revision, at) => (
          <li key={revision.number} class={at === revisions.length - 1 ? "revision newest" : "revision"}>
            <p class="revision-title" title={revision.title}><b>{revision.number}</b> {revision.title}</p>
            <Bar kind="learned" value={revision.learned} most={most} />
            {hasHeldOut ? <Bar kind="held-out" value={revision.heldOut} most={most} /> : null}
          </li>
        ))}
        {revisions.length === 1 ? <li class="revision-hint faint">Add an effect: the next revision stands here, with its error.</li> : null}
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
    <p class="revision-bar">
      <span class="hidden-text">{kind === "learned" ? "learned: " : "held out: "}</span>
      <span class="revision-track" aria-hidden="true"><span class={kind} style={{ width: `${(100 * value) / most}%` }} /></span>
      <span class="number">{metres(value)}</span>
    </p>
  );
}

function revisionsOf({ ladder: { revisions }, learned }: Judged, name: string): LadderRevision[] {
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
