// The middle of the screen: everything over one time axis, and below it everything that is not over time.

import type { JSX } from "preact";
import { useEffect } from "preact/hooks";

import { press } from "../charts/gestures";
import { Lane } from "../charts/lane";
import { clock, moment } from "../charts/number";
import { Ribbon } from "../charts/ribbon";
import type { Stretch } from "../charts/ribbon";
import { TimeChart } from "../charts/time_chart";
import { useWidth } from "../charts/use_width";
import type { Span as EngineSpan } from "../protocol";
import { sensor, shown } from "../state/flights";
import { altitudeSpec, chartWidth, errorSpec, isBeyondReference } from "../state/pictures";
import { before, standing } from "../state/model";
import { compared, ribbons, ribbonsBefore } from "../state/studio";
import { brush, drag, isWhole, show, showWhole, zoom } from "../state/view";
import type { Drag } from "../state/view";
import { Help } from "./help";
import { Layouts } from "./layouts";
import { Legend } from "./legend";
import { Panels } from "./panels";
import { isNarrow } from "./screen";
import { PhaseRibbon } from "./phase_ribbon";
import { Refused } from "./refused";
import { capital, plain, sensorName, shortSensorName } from "./words";

/** Width of the gutter and of what is right of the curves, pixels. */
const BESIDE = 78;

export function Middle(): JSX.Element {
  const [place, width] = useWidth<HTMLDivElement>();
  useEffect(() => {
    if (width > BESIDE) chartWidth.value = width - BESIDE;
  }, [width]);
  const altitude = altitudeSpec.value;
  const error = errorSpec.value;
  const flight = shown.value;
  if (flight && flight.opened.overview.refused !== null) {
    return <main class="middle" aria-label="Curves"><Refused opened={flight.opened} /></main>;
  }
  const name = sensor.value === null ? "Sensor" : sensorName(sensor.value);
  return (
    <main class="middle" aria-label="Curves">
      <Toolbar />
      <div class="curves" ref={place} data-tour="curves">
        <figure class="chart altitude">
          <Legend title="Altitude" unit="m" spec={altitude} />
          {altitude ? <TimeChart label={`Altitude of ${name}, measured and modelled, over time`} spec={altitude} axis={false} /> : <div class="plot waiting" />}
        </figure>
        <figure class="chart error" data-tour="error">
          <Legend title={isBeyondReference.value ? "Error beyond the reference" : "Error against the reference"} unit="m" spec={error} />
          {error ? <TimeChart label={`Error of ${name} over time`} spec={error} axis /> : <div class="plot waiting" />}
        </figure>
        <Ribbons />
      </div>
      {isNarrow.value ? null : <Panels />}
    </main>
  );
}

function Toolbar(): JSX.Element {
  return (
    <div class="toolbar" role="toolbar" aria-label="View" onKeyDown={(event) => {
      if ((event.key === "+" || event.key === "-" || event.key === "0") && press(event)) event.preventDefault();
    }}>
      <SensorChoice />
      <span class="spring" />
      <fieldset class="segments">
        <legend class="hidden-text">A drag over the curves</legend>
        {(["select", "pan", "zoom"] satisfies Drag[]).map((kind) => (
          <label key={kind} class={drag.value === kind ? "on" : ""}>
            <input type="radio" name="drag" checked={drag.value === kind} onChange={() => { drag.value = kind; }} />
            {capital(kind)}
          </label>
        ))}
      </fieldset>
      <span class="segments">
        <button type="button" onClick={() => zoom(2)} aria-label="Zoom out" title="Zoom out (−)">−</button>
        <button type="button" onClick={() => zoom(0.5)} aria-label="Zoom in" title="Zoom in (+)">+</button>
        <button type="button" onClick={showWhole} disabled={isWhole()} title="Show all of the flight (0)">All</button>
      </span>
      <Layouts />
      <Help />
      <Brushed />
    </div>
  );
}

function Brushed(): JSX.Element | null {
  const span = brush.value;
  if (!span) return null;
  return (
    <span class="brushed">
      <span class="number brushed-span" title={`Brushed: ${clock(span.from)} to ${clock(span.to)}`}>{moment(span.from)}–{moment(span.to)}</span>
      <button type="button" onClick={() => show(span)} aria-label="Zoom to the brushed stretch" title="Zoom to the brushed stretch">⤢</button>
      <button type="button" class="plain" aria-label="End the brush" title="End the brush (Esc)" onClick={() => { brush.value = null; }}>×</button>
    </span>
  );
}

function SensorChoice(): JSX.Element | null {
  const sensors = shown.value?.opened.sensors ?? [];
  if (sensors.length === 0) return null;
  const found = compared.answer.value?.comparison.sensors;
  return (
    <fieldset class="segments sensors">
      <legend class="hidden-text">Sensor</legend>
      {sensors.map((name) => {
        const trust = found?.[name]?.trust;
        return (
          <label key={name} class={sensor.value === name ? "on" : ""}>
            <input type="radio" name="sensor" checked={sensor.value === name} onChange={() => { sensor.value = name; }} />
            {trust === undefined ? null : <span class={`dot ${trust}`} title={trust} />}
            <span title={sensorName(name)}>{shortSensorName(name)}</span>
            {trust === undefined ? null : <span class="hidden-text">, {trust}</span>}
          </label>
        );
      })}
    </fieldset>
  );
}

function Ribbons(): JSX.Element | null {
  const found = ribbons.answer.value;
  const name = sensor.value;
  if (!found || name === null) return null;
  const { trust, manoeuvres, motion } = found;
  const isAfter = before.value !== null && standing(found.asked) === "after";
  // The newest revision is still being compared.
  const isOld = before.value !== null && !isAfter;
  const past = ribbonsBefore.answer.value;
  const then = isAfter && past && standing(past.asked) === "before" ? past.trust[name] : undefined;
  const time = motion.time_s;
  const speed = found.sources.speed;
  return (
    <div class="ribbons">
      <PhaseRibbon />
      {then ? <Ribbon label="Trust before the newest revision" name="before" stretches={stretches(then)} look="trust" /> : null}
      <Ribbon label={then ? "Trust after the newest revision" : isOld ? "Trust before the newest revision" : "Trust"} name={then ? "after" : isOld ? "before" : "trust"} stretches={stretches(trust[name] ?? [])} look="trust" />
      <Ribbon label="Manoeuvres" name="manoeuvre" stretches={stretches(manoeuvres)} look="manoeuvre" />
      <div class="lanes">
        <Lane name="speed" unit="m/s" time={time} values={motion.speed_mps} />
        <Lane name="climb" unit="m/s" time={time} values={motion.climb_rate_mps} />
        <Lane name="load" unit="g" time={time} values={motion.load_factor} />
      </div>
      {speed === null ? null : <p class="hidden-text">Speed from {plain(String(speed))}.</p>}
    </div>
  );
}

function stretches(spans: ReadonlyArray<EngineSpan>): Stretch[] {
  return spans.map(({ from_s, to_s, what }) => ({ from: from_s, to: to_s, kind: what.replace(/[ -]/g, "_"), text: capital(plain(what)) }));
}

