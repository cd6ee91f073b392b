// On the flight's own clock: calibration, take-off and landing, which can be dragged or moved by keys; and
// the launch.

import { useSignal } from "@preact/signals";
import type { HTMLAttributes, JSX } from "preact";

import { clock } from "../charts/number";
import { useWidth } from "../charts/use_width";
import type { Airborne, Times } from "../protocol";
import { FOUND, setTimes, shown } from "../state/flights";
import { calibration } from "../state/pictures";
import { ribbons } from "../state/studio";
import { view } from "../state/view";
import type { Span } from "../state/view";

/** Shortest window that can be calibrated on, and shortest time in the air, seconds. */
const SHORTEST_S = 5;

/** What is dragged: an end of the calibration or all of it, or an end of the time in the air. */
type Grip = "from" | "to" | "both" | "take-off" | "landing";

interface Spans {
  readonly calibration: Span | null;
  readonly air: Span;
}

const LABELS: Readonly<Record<Exclude<Grip, "both">, string>> = {
  from: "Calibration begins. Arrow keys move it, Enter recalibrates",
  to: "Calibration ends. Arrow keys move it, Enter recalibrates",
  "take-off": "Take-off. Arrow keys move it, Enter recomputes",
  landing: "Landing. Arrow keys move it, Enter recomputes",
};

export function PhaseRibbon(): JSX.Element | null {
  const [place, width] = useWidth<HTMLDivElement>();
  const draft = useSignal<Spans | null>(null);
  const held = useSignal<{ grip: Grip; at: number; was: Spans } | null>(null);
  const flight = shown.value;
  if (!flight) return null;
  const { overview, first_s: first, last_s: last } = flight.opened;
  const { from, to } = view.value;
  const now: Spans = draft.value ?? {
    calibration: calibration.value,
    air: { from: overview.take_off_s ?? first, to: overview.landing_s ?? last },
  };
  const percent = (at: number): string => `${((at - from) / (to - from)) * 100}%`;
  const isSeen = (at: number | null): at is number => at !== null && at >= from && at <= to;

  const commit = (spans: Spans, grip: Grip): void => {
    draft.value = null;
    void setTimes(flight.id, said(spans, grip, { from: first, to: last }));
  };
  const grab = (grip: Grip) => (event: PointerEvent): void => {
    if (!(event.currentTarget instanceof HTMLElement)) return;
    event.currentTarget.setPointerCapture(event.pointerId);
    held.value = { grip, at: event.clientX, was: now };
    event.stopPropagation();
  };
  const pull = (event: PointerEvent): void => {
    const hand = held.value;
    if (!hand) return;
    const by = ((event.clientX - hand.at) / Math.max(width, 1)) * (to - from);
    draft.value = moved(hand.was, hand.grip, by, { from: first, to: last });
  };
  const release = (grip: Grip) => (): void => {
    held.value = null;
    if (draft.value) commit(draft.value, grip);
  };
  const keys = (grip: Grip) => (event: KeyboardEvent): void => {
    const sign = event.key === "ArrowLeft" ? -1 : event.key === "ArrowRight" ? 1 : 0;
    if (sign !== 0) {
      draft.value = moved(now, grip, sign * (event.shiftKey ? 10 : 1), { from: first, to: last });
      event.preventDefault();
    }
    if (event.key === "Enter" && draft.value) commit(draft.value, grip);
    if (event.key === "Escape") draft.value = null;
  };
  const slider = (grip: Exclude<Grip, "both">, at: number): HTMLAttributes<HTMLSpanElement> => ({
    role: "slider",
    tabIndex: 0,
    "aria-label": LABELS[grip],
    "aria-valuemin": Math.round(first),
    "aria-valuemax": Math.round(last),
    "aria-valuenow": Math.round(at * 10) / 10,
    "aria-valuetext": clock(at),
    style: { left: percent(at) },
    onPointerDown: grab(grip),
    onPointerMove: pull,
    onPointerUp: release(grip),
    onKeyDown: keys(grip),
    onBlur: release(grip),
  });
  /** A handle for take-off or landing. One that the log does not have is drawn at that end of the log. */
  const airborneEnd = (grip: "take-off" | "landing"): JSX.Element | null => {
    const at = grip === "take-off" ? now.air.from : now.air.to;
    const isInLog = grip === "take-off" ? at > first : at < last;
    if (overview.has_launch || !isSeen(at)) return null;
    const sign = grip === "take-off" ? "↗" : "↘";
    const text = isInLog ? `${grip} at ${clock(at)}` : `no ${grip} in the log`;
    return (
      <span key={grip} class={`moment airborne-end ${grip} ${isInLog ? "" : "outside"} ${isEnd(at, from, to) ? "end" : ""}`} title={`${text}: drag it`} {...slider(grip, at)}>
        <span aria-hidden="true">{sign} {isInLog ? grip : ""}</span>
      </span>
    );
  };
  const launch = overview.has_launch ? (ribbons.answer.value?.launch_s ?? null) : null;
  const window = now.calibration;
  const isOwn = flight.times.window !== null || flight.times.airborne !== null;
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
              onPointerUp={release("both")}
            />
            {isSeen(window.from) ? <span class="grip from" {...slider("from", window.from)} /> : null}
            {isSeen(window.to) ? <span class="grip to" {...slider("to", window.to)} /> : null}
          </>
        ) : null}
        {airborneEnd("take-off")}
        {isSeen(launch) ? (
          <span class={`moment ${isEnd(launch, from, to) ? "end" : ""}`} style={{ left: percent(launch) }} title={`launch at ${clock(launch)}`}>
            <span aria-hidden="true">⇣</span> launch
          </span>
        ) : null}
        {airborneEnd("landing")}
        {isOwn ? (
          <button type="button" class="plain small reset-window" onClick={() => void setTimes(flight.id, FOUND)} title="Calibration, take-off and landing as Pylon finds them">reset</button>
        ) : null}
      </div>
    </div>
  );
}

/** Whether a label on the right of its moment would lack room. */
function isEnd(at: number, from: number, to: number): boolean {
  return at > from + 0.85 * (to - from);
}

function moved({ calibration: window, air }: Spans, grip: Grip, by: number, log: Span): Spans {
  const within = (value: number, least: number, most: number): number => Math.max(Math.min(value, most), least);
  switch (grip) {
    case "take-off": return { calibration: window, air: { from: within(air.from + by, log.from, air.to - SHORTEST_S), to: air.to } };
    case "landing": return { calibration: window, air: { from: air.from, to: within(air.to + by, air.from + SHORTEST_S, log.to) } };
    case "from": return { calibration: window && { from: within(window.from + by, log.from, window.to - SHORTEST_S), to: window.to }, air };
    case "to": return { calibration: window && { from: window.from, to: within(window.to + by, window.from + SHORTEST_S, log.to) }, air };
    case "both": {
      if (!window) return { calibration: window, air };
      const step = within(by, log.from - window.from, log.to - window.to);
      return { calibration: { from: window.from + step, to: window.to + step }, air };
    }
  }
}

/** Times that the user has set by moving the grip. */
function said({ calibration: window, air }: Spans, grip: Grip, log: Span): Partial<Times> {
  const round = (value: number): number => Math.round(value * 100) / 100;
  if (grip === "take-off" || grip === "landing") {
    const airborne: Airborne = {
      take_off_s: air.from > log.from ? round(air.from) : null,
      landing_s: air.to < log.to ? round(air.to) : null,
    };
    // In the air from end to end sets nothing: a log without take-off and landing shows the same.
    return { airborne: airborne.take_off_s === null && airborne.landing_s === null ? null : airborne };
  }
  return { window: window && { start_s: round(window.from), end_s: round(window.to) } };
}
