// A tour of five steps over a simulated flight.

import { signal } from "@preact/signals";
import type { JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";

import { flights, openSample } from "../state/flights";

interface Step {
  readonly at: string;
  readonly title: string;
  readonly text: string;
}

const STEPS: ReadonlyArray<Step> = [
  { at: "sentence", title: "The finding", text: "One sentence says what was found, with the number that matters. Here a simulated UAV's barometer reads wrong the faster it flies." },
  { at: "error", title: "The error", text: "What the barometer reads beyond the reference, over time, with the uncertainty as a band. Drag to brush a stretch, turn the wheel to zoom, double-click to see all." },
  { at: "panels", title: "What it depends on", text: "The same error over any signal. The stretch that you brush is highlighted here: dives and climbs stand out." },
  { at: "effects", title: "The cause", text: "Physical effects, ranked by the metres they explain. The switch draws an effect's prediction over the error; Add learns it into the model." },
  { at: "ladder", title: "The proof", text: "Every revision of the model with its error. Undo takes the newest one back; Save writes the model for the flight computer." },
];

const SAMPLE = "hidden-static-port";
const step = signal<number | null>(null);

export function beginTour(): void {
  if (flights.value.length === 0) void openSample(SAMPLE);
  step.value = 0;
}

export function Tour(): JSX.Element | null {
  const place = useRef<HTMLDivElement>(null);
  const at = step.value;
  const now = at === null ? undefined : STEPS[at];

  useEffect(() => {
    if (!now) return undefined;
    const marked = document.querySelector(`[data-tour="${now.at}"]`);
    marked?.classList.add("toured");
    marked?.scrollIntoView({ block: "nearest" });
    place.current?.focus();
    return () => marked?.classList.remove("toured");
  }, [now, flights.value.length]);

  if (!now || at === null) return null;
  const end = (): void => { step.value = null; };
  const isLast = at === STEPS.length - 1;
  return (
    <div
      class={`tour tour-${now.at}`}
      role="dialog"
      aria-label={`Tour, step ${at + 1} of ${STEPS.length}: ${now.title}`}
      tabIndex={-1}
      ref={place}
      onKeyDown={(event) => { if (event.key === "Escape") end(); }}
    >
      <p class="faint">{at + 1} of {STEPS.length}</p>
      <h2>{now.title}</h2>
      <p>{now.text}</p>
      <p class="acts">
        <button type="button" class="plain" onClick={end}>End the tour</button>
        <span class="spring" />
        {at > 0 ? <button type="button" onClick={() => { step.value = at - 1; }}>Back</button> : null}
        <button type="button" class="main" onClick={() => { step.value = isLast ? null : at + 1; }}>{isLast ? "Done" : "Next"}</button>
      </p>
    </div>
  );
}
