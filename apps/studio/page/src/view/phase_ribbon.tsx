// The flight's own clock: where it is calibrated (to be dragged), take-off, launch and landing.

import { useSignal } from "@preact/signals";
import type { JSX } from "preact";

import { clock } from "../charts/number";
import { useWidth } from "../charts/use_width";
import { setWindow, shown } from "../state/flights";
import { calibration } from "../state/pictures";
import { ribbons } from "../state/studio";
import { view } from "../state/view";
import type { Span } from "../state/view";

/** A window shorter than this can't be calibrated on. */
const SHORTEST_S = 5;

type End = "from" | "to" | "both";

export function PhaseRibbon(): JSX.Element | null {
  const [place, width] = useWidth<HTMLDivElement>();
  const draft = useSignal<Span | null>(null);
  const held = useSignal<{ end: End; at: number; was: Span } | null>(null);
  const flight = shown.value;
  if (!flight) return null;
  const { overview, first_s: first, last_s: last } = flight.opened;
  const { from, to } = view.value;
  const window = draft.value ?? calibration.value;
  const percent = (at: number): string => `${((at - from) / (to - from)) * 100}%`;
  const isSeen = (at: number | null): at is number => at !== null && at >= from && at <= to;

  const moved = (was: Span, end: End, by: number): Span => {
    if (end === "from") return { from: Math.min(Math.max(was.from + by, first), was.to - SHORTEST_S), to: was.to };
    if (end === "to") return { from: was.from, to: Math.max(Math.min(was.to + by, last), was.from + SHORTEST_S) };
    const step = Math.min(Math.max(by, first - was.from), last - was.to);
    return { from: was.from + step, to: was.to + step };
  };
  const commit = (span: Span): void => {
    const round = (value: number): number => Math.round(value * 100) / 100;
    draft.value = null;
    void setWindow(flight.id, { start_s: round(span.from), end_s: round(span.to) });
  };
  const grab = (end: End) => (event: PointerEvent): void => {
    if (!window || !(event.currentTarget instanceof HTMLElement)) return;
    event.currentTarget.setPointerCapture(event.pointerId);
    held.value = { end, at: event.clientX, was: window };
    event.stopPropagation();
  };
  const pull = (event: PointerEvent): void => {
    const grip = held.value;
    if (!grip) return;
    draft.value = moved(grip.was, grip.end, ((event.clientX - grip.at) / Math.max(width, 1)) * (to - from));
  };
  const release = (): void => {
    held.value = null;
    if (draft.value) commit(draft.value);
  };
  const keys = (end: End) => (event: KeyboardEvent): void => {
    const sign = event.key === "ArrowLeft" ? -1 : event.key === "ArrowRight" ? 1 : 0;
    if (sign !== 0 && window) {
      draft.value = moved(window, end, sign * (event.shiftKey ? 10 : 1));
      event.preventDefault();
    }
    if (event.key === "Enter" && draft.value) commit(draft.value);
    if (event.key === "Escape") draft.value = null;
  };
  const handle = (end: "from" | "to", at: number): JSX.Element => (
    <span
      class={`grip ${end}`}
      role="slider"
      tabIndex={0}
      aria-label={end === "from" ? "Calibration begins. Arrow keys move it, Enter recalibrates" : "Calibration ends. Arrow keys move it, Enter recalibrates"}
      aria-valuemin={Math.round(first)}
      aria-valuemax={Math.round(last)}
      aria-valuenow={Math.round(at * 10) / 10}
      aria-valuetext={clock(at)}
      style={{ left: percent(at) }}
      onPointerDown={grab(end)}
      onPointerMove={pull}
      onPointerUp={release}
      onKeyDown={keys(end)}
      onBlur={release}
    />
  );
  const events = [
    { text: "take-off", at: overview.take_off_s, sign: "↗" },
    { text: "launch", at: overview.has_launch ? (ribbons.answer.value?.launch_s ?? null) : null, sign: "⇣" },
    { text: "landing", at: overview.landing_s, sign: "↘" },
  ];
  return (
    <div class="ribbon phases" data-tour="window">
      <span class="ribbon-name" aria-hidden="true">calibration</span>
      <div class="ribbon-track" ref={place}>
        {window && window.to > from && window.from < to ? (
          <>
            <span
              class="calibration"
              style={{ left: percent(Math.max(window.from, from)), width: `${((Math.min(window.to, to) - Math.max(window.from, from)) / (to - from)) * 100}%` }}
              title="Calibrated here: drag it, or its ends"
              onPointerDown={grab("both")}
              onPointerMove={pull}
              onPointerUp={release}
            />
            {isSeen(window.from) ? handle("from", window.from) : null}
            {isSeen(window.to) ? handle("to", window.to) : null}
          </>
        ) : null}
        {events.map(({ text, at, sign }) => (isSeen(at) ? (
          <span key={text} class={`moment ${at > from + 0.85 * (to - from) ? "end" : ""}`} style={{ left: percent(at) }} title={`${text} at ${clock(at)}`}>
            <span aria-hidden="true">{sign}</span> {text}
          </span>
        ) : null))}
        {flight.window ? (
          <button type="button" class="plain small reset-window" onClick={() => void setWindow(flight.id, null)} title="Calibrate where Pylon would">reset</button>
        ) : null}
      </div>
    </div>
  );
}
