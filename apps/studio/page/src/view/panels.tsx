// Below the curves: the error over any signal, any signal over another, autocorrelation, and the map.

import type { JSX } from "preact";
import { useEffect } from "preact/hooks";

import { PointsChart } from "../charts/points_chart";
import type { PointsSpec } from "../charts/points_chart";
import { Track } from "../charts/track";
import { short, unit } from "../charts/number";
import { sensor, shown } from "../state/flights";
import { across, crossWith, places, xyAcross, xyUp } from "../state/layout";
import type { PanelKind } from "../state/layout";
import { correlations, crossCorrelations, isBeyondReference, isCrossShown, points } from "../state/pictures";
import type { Correlations, Points } from "../state/pictures";
import { trackPoints } from "../state/track";
import { standing } from "../state/model";
import { brush } from "../state/view";
import type { Role } from "../charts/colours";
import { HeatMap } from "./heat_map";
import { isNarrow, isWide } from "./screen";
import { columnName, sensorName } from "./words";

const TITLES: Readonly<Record<PanelKind, string>> = {
  scatter: "Error over a signal",
  xy: "One signal over another",
  correlation: "Autocorrelation",
  cross: "Correlation with a signal",
  track: "Track",
  heat: "Error by manoeuvre and speed",
};
const KINDS: ReadonlyArray<PanelKind> = ["scatter", "correlation", "cross", "xy", "track", "heat"];

const scatter = points(() => across.value, () => "error");
const pairs = points(() => xyAcross.value, () => xyUp.value);

export function Panels(): JSX.Element {
  const all = isWide.value || isNarrow.value;
  const kinds = all ? KINDS : places.value;
  return (
    <section class={`panels ${all ? "all" : ""}`} aria-label="Signals against each other" data-tour="panels">
      {kinds.map((kind, place) => (
        <figure key={all ? kind : place} class="panel">
          <figcaption>
            {all ? <span class="legend-title">{TITLES[kind]}</span> : <KindChoice kind={kind} place={place} />}
            <PanelHead kind={kind} />
          </figcaption>
          <PanelBody kind={kind} />
        </figure>
      ))}
    </section>
  );
}

function KindChoice({ kind, place }: { readonly kind: PanelKind; readonly place: number }): JSX.Element {
  const choose = (next: string): void => {
    const found = KINDS.find((one) => one === next);
    if (found) places.value = places.value.map((old, at) => (at === place ? found : old));
  };
  return (
    <select aria-label={`What place ${place + 1} below the curves shows`} value={kind} onChange={(event) => choose(event.currentTarget.value)}>
      {KINDS.map((one) => <option key={one} value={one} selected={one === kind}>{TITLES[one]}</option>)}
    </select>
  );
}

function PanelHead({ kind }: { readonly kind: PanelKind }): JSX.Element | null {
  if (kind === "scatter") return <SignalChoice label="Across" value={across.value} choose={(name) => { across.value = name; }} />;
  if (kind === "xy") {
    return (
      <span class="pair">
        <SignalChoice label="Up" value={xyUp.value} choose={(name) => { xyUp.value = name; }} />
        <span class="faint">over</span>
        <SignalChoice label="Across" value={xyAcross.value} choose={(name) => { xyAcross.value = name; }} />
      </span>
    );
  }
  if (kind === "correlation" || kind === "cross") {
    const then = (kind === "cross" ? crossCorrelations : correlations).answer.value?.then;
    return (
      <span class="legend-entry">
        {kind === "cross" ? <SignalChoice label="Correlated with" value={crossWith.value} choose={(name) => { crossWith.value = name; }} /> : null}
        {then && kind === "correlation" ? <><span class="swatch line" style={{ color: "var(--before)" }} />before <span class="swatch line" style={{ color: "var(--after)" }} />after </> : null}
        <span class="swatch dashed" style={{ color: "var(--ink)" }} />{kind === "cross" ? "99 %" : "99 % of white"}
      </span>
    );
  }
  if (kind === "heat") return null;
  const made = trackPoints.value?.how;
  return made === "velocity" ? <span class="faint">from the GPS velocity</span> : null;
}

const MOTION: ReadonlyArray<{ name: string; text: string }> = [
  { name: "speed", text: "speed" },
  { name: "climb_rate", text: "climb rate" },
  { name: "load_factor", text: "load factor" },
  { name: "turn_rate", text: "turn rate" },
];

interface SignalChoiceProps {
  readonly label: string;
  readonly value: string;
  readonly choose: (name: string) => void;
}

function SignalChoice({ label, value, choose }: SignalChoiceProps): JSX.Element {
  const columns = shown.value?.opened.columns.filter(({ values, name }) => values > 0 && name !== "time_s") ?? [];
  return (
    <select aria-label={label} value={value} onChange={(event) => choose(event.currentTarget.value)}>
      <optgroup label="Motion">
        {MOTION.map(({ name, text }) => <option key={name} value={name} selected={name === value}>{text}</option>)}
      </optgroup>
      <optgroup label="Recorded">
        {columns.map(({ name }) => <option key={name} value={name} selected={name === value}>{columnName(name)}</option>)}
      </optgroup>
    </select>
  );
}

function PanelBody({ kind }: { readonly kind: PanelKind }): JSX.Element {
  switch (kind) {
    case "scatter": return <PointsPanel found={scatter.answer.value} problem={scatter.problem.value} isError />;
    case "xy": return <PointsPanel found={pairs.answer.value} problem={pairs.problem.value} isError={false} />;
    case "correlation": return <CorrelationPanel found={correlations.answer.value} problem={correlations.problem.value} isCross={false} />;
    case "cross": return <CrossPanel />;
    case "track": return <TrackPanel />;
    case "heat": return <HeatMap />;
  }
}

function name(of: string): string {
  return MOTION.find((one) => one.name === of)?.text ?? columnName(of);
}

interface PointsPanelProps {
  readonly found: Points | null;
  readonly problem: string | null;
  readonly isError: boolean;
}

function PointsPanel({ found, problem, isError }: PointsPanelProps): JSX.Element {
  if (problem !== null) return <p class="plot empty">{problem}</p>;
  if (!found) return <div class="plot waiting" />;
  const { reply } = found;
  if (reply.of === 0) return <p class="plot empty">The flight does not record {name(found.x)}{isError ? "" : ` and ${name(found.y)} together`}.</p>;
  const [time, x, y] = [reply.time_s, reply.x, reply.y];
  const order = Array.from(x.keys()).sort((one, other) => (x[one] ?? 0) - (x[other] ?? 0));
  const span = brush.value;
  const isBrushed = (i: number): boolean => span !== null && (time[i] ?? NaN) >= span.from && (time[i] ?? NaN) <= span.to;
  const role: Role = isError ? (standing(found.asked) ?? "before") : "reference";
  const spec: PointsSpec = {
    x: order.map((i) => x[i] ?? 0),
    layers: [
      { role, as: "dots", y: order.map((i) => (isBrushed(i) ? null : (y[i] ?? null))) },
      { role: "brush", as: "bold dots", y: order.map((i) => (isBrushed(i) ? (y[i] ?? null) : null)) },
    ],
    xName: `${name(found.x)}${axisUnit(reply.x_unit)}`,
    yName: isError ? "error, m" : `${name(found.y)}${axisUnit(reply.y_unit)}`,
    band: null,
    zero: isError,
    yRange: null,
  };
  const brushed = order.filter(isBrushed).length;
  const what = isError ? `Error of ${sensorName(sensor.value ?? "baro")}` : name(found.y);
  return <PointsChart label={`${what} over ${name(found.x)}, ${order.length} points${span ? `, ${brushed} of them brushed` : ""}`} spec={spec} />;
}

function axisUnit(of: string): string {
  const text = unit(of).trim();
  return text === "" ? "" : `, ${text}`;
}

function CrossPanel(): JSX.Element {
  useEffect(() => {
    isCrossShown.value = true;
    return () => { isCrossShown.value = false; };
  }, []);
  return <CorrelationPanel found={crossCorrelations.answer.value} problem={crossCorrelations.problem.value} isCross />;
}

interface CorrelationPanelProps {
  readonly found: Correlations | null;
  readonly problem: string | null;
  readonly isCross: boolean;
}

function CorrelationPanel({ found, problem, isCross }: CorrelationPanelProps): JSX.Element {
  if (problem !== null) return <p class="plot empty">{problem}</p>;
  if (!found) return <div class="plot waiting" />;
  const { now, then } = found;
  const lag = Array.from(now.lag_s);
  if (lag.length < 3) return <p class="plot empty">Too short, or with too many gaps, for a correlation.</p>;
  // Matched by lag, because one of the two may reach less far.
  const column = (reply: typeof now): Array<number | null> => {
    const known = new Map(Array.from(reply.lag_s, (at, i) => [Math.round(at / reply.block_s), reply.correlation[i]]));
    return lag.map((at) => { const value = known.get(Math.round(at / now.block_s)); return value === undefined || Number.isNaN(value) ? null : value; });
  };
  const values = column(now).map((value) => value ?? 0);
  const largest = Math.max(now.band, ...values.map(Math.abs), ...(then ? column(then).map((value) => Math.abs(value ?? 0)) : [])) * 1.08;
  const spec: PointsSpec = {
    x: lag,
    layers: [
      ...(then ? [{ role: "before", as: "line", y: column(then) } as const] : []),
      { role: standing(found.asked) ?? "before", as: "line", y: column(now) },
    ],
    xName: isCross ? "the error is later by, s" : "lag, s",
    yName: "correlation",
    band: now.band,
    zero: true,
    yRange: isCross ? [-largest, largest] : [Math.min(-0.5, ...values), 1.05],
  };
  const beyond = isBeyondReference.value ? "error beyond the reference" : "error";
  if (isCross) {
    const place = values.reduce((best, value, i) => (Math.abs(value) > Math.abs(values[best] ?? 0) ? i : best), 0);
    const label = `Correlation of the ${beyond} with ${name(crossWith.value)}: ${short(values[place] ?? 0)} where the error is ${short(lag[place] ?? 0)} s later; unrelated signals stay within ${short(now.band)}`;
    return <PointsChart label={label} spec={spec} />;
  }
  const first = column(now)[1];
  return <PointsChart label={`Autocorrelation of the ${beyond}: ${first === null || first === undefined ? "" : `${short(first)} at ${short(lag[1] ?? 0)} s`}; white noise stays within ${short(now.band)}`} spec={spec} />;
}

function TrackPanel(): JSX.Element {
  const found = trackPoints.value;
  if (!found) return <p class="plot empty">No position and no velocity is recorded.</p>;
  return <Track points={found} />;
}
