// The curves and points in the middle of the screen: their requests to the engine, and their look.

import { computed, effect, signal } from "@preact/signals";

import { ask } from "../ask";
import type { Band, Gaps, Level, Line, Mark, TimeSpec, Values } from "../charts/time_chart";
import type { Role } from "../charts/colours";
import type { Acting, CandidateFacts, Correlated, Diagnosed, Drawn, ModelText, NoiseFacts, Paired, Series, Signal, Times } from "../protocol";
import { sensor, shown } from "./flights";
import { crossWith } from "./layout";
import { resource } from "./resource";
import type { Resource } from "./resource";
import { before, model, standing } from "./model";
import type { Of } from "./model";
import { diagnosed, diagnosedBefore, guides, isDrawn, ribbons } from "./studio";
import { inside, view } from "./view";
import type { Span } from "./view";

/** The width of the time charts, pixels. */
export const chartWidth = signal(800);
/** Effects whose prediction is drawn over the error. */
export const whatIf = signal<ReadonlyArray<string>>([]);

/** Milliseconds without a change before curves are requested again. */
export const REST = 70;
/** Share of the view that is requested in addition on each side, so that panning shows curves at once. */
const MARGIN = 0.5;

interface CurvesQuestion {
  readonly flight: string;
  readonly model: ModelText;
  readonly times: Times;
  readonly signals: Signal[];
  readonly from_s: number;
  readonly to_s: number;
  readonly pixels: number;
}

export function question(text: ModelText | null, signals: (sensor: string) => Signal[]): CurvesQuestion | null {
  const flight = shown.value;
  const name = sensor.value;
  if (!flight || name === null || text === null || flight.opened.overview.refused !== null) return null;
  const { from, to } = view.value;
  const margin = MARGIN * (to - from);
  const span = inside({ from: Math.max(from - margin, flight.opened.first_s), to: Math.min(to + margin, flight.opened.last_s) });
  const pixels = Math.max(Math.round((chartWidth.value * (span.to - span.from)) / (to - from)), 64);
  return {
    flight: flight.flight, model: text, times: flight.times, signals: signals(name),
    from_s: span.from, to_s: span.to, pixels,
  };
}

export async function curves(request: CurvesQuestion): Promise<Of<Series>> {
  return { ...(await ask("series", request)), asked: request.model };
}

function acting({ effect, coefficient, time_constant_s, since }: CandidateFacts): Acting {
  return { effect, coefficient, time_constant_s, since };
}

/**
 * Whether a model has or defines an effect. If so, the effect no longer counts as found by a diagnosis of the
 * model before.
 */
function has(of: ModelText | null, id: string): boolean {
  return of !== null && of.text.includes(`"${id}"`);
}

/**
 * The error beyond the reference once a diagnosis has estimated the reference's wander; until then the error.
 * Also the error if no known effect explains the sensor: then the noise was fitted to the misfit too, and
 * removing the wander would remove the misfit from its own picture.
 */
function errorSignal(name: string, found: Diagnosed | null, of: ModelText | null): Signal {
  const noise = found?.diagnosis.noise ?? null;
  const isUnexplained = found?.diagnosis.sensors[name]?.verdict === "unknown_effect";
  if (!found || noise === null || isUnexplained) return { signal: "error", sensor: name };
  const all = Object.values(found.diagnosis.sensors).flatMap((one) => one?.candidates ?? []);
  return { signal: "beyond_reference", sensor: name, noise: noise as NoiseFacts, found: all.filter(({ chosen, effect: id }) => chosen && !has(of, id)).map(acting) };
}

/** A sensor's error as the page shows it. */
export function errorSignalOf(name: string): Signal {
  return errorSignal(name, diagnosed.answer.value, model.value);
}

const altitudes = resource(
  () => question(model.value, (name) => [
    { signal: "measured", sensor: name },
    { signal: "modelled", sensor: name },
  ]),
  curves,
  REST,
);
effect(() => {
  const flight = shown.value;
  // If nothing can be drawn, nothing waits for the drawing.
  const isNone = flight !== null && (sensor.value === null || flight.opened.overview.refused !== null);
  if (isNone || altitudes.answer.value || altitudes.problem.value !== null) isDrawn.value = true;
});
const errorNow = resource(() => question(model.value, (name) => [errorSignal(name, diagnosed.answer.value, model.value)]), curves, REST);
const errorBefore = resource(() => question(before.value, (name) => [errorSignal(name, diagnosedBefore.answer.value, before.value)]), curves, REST);
const predictions = resource(
  () => (whatIf.value.length === 0 ? null : question(model.value, (name) => predicted(name))),
  curves,
  REST,
);

/** Predictions of the what-if effects, with the coefficients of the diagnosis. */
function predicted(name: string): Signal[] {
  const sensors = diagnosed.answer.value?.diagnosis.sensors ?? {};
  const found = Object.entries(sensors).flatMap(([subject, here]) =>
    (here?.candidates ?? []).filter(({ effect }) => whatIf.value.includes(effect)).map((candidate) => ({ subject, candidate })));
  return found
    .filter(({ subject, candidate }) => subject === name || guides.value.get(candidate.effect)?.subject === "gps")
    .map(({ candidate }) => ({ signal: "effect", of: acting(candidate) }));
}

function values(numbers: Float64Array): Values {
  return Array.from(numbers, (value) => (Number.isNaN(value) ? null : value));
}

function gapsOf(drawn: Drawn): Gaps {
  const pairs = drawn.gaps_s;
  const gaps: Span[] = [];
  for (let i = 0; i + 1 < pairs.length; i += 2) gaps.push({ from: pairs[i] ?? 0, to: pairs[i + 1] ?? 0 });
  return gaps;
}

interface Curve {
  readonly least: Values;
  readonly greatest: Values;
  readonly mean: Values;
  readonly sigma: Float64Array | null;
  readonly gaps: Gaps;
  readonly isEmpty: boolean;
  readonly isThinned: boolean;
}

function curve(reply: Series, at: number): Curve | null {
  const drawn = reply.curves[at];
  if (!drawn) return null;
  const [least, greatest] = [drawn.least, drawn.greatest];
  return {
    least: values(least),
    greatest: values(greatest),
    mean: values(least.map((value, i) => (value + (greatest[i] ?? NaN)) / 2)),
    sigma: drawn.sigma ? drawn.sigma : null,
    gaps: gapsOf(drawn),
    isEmpty: drawn.values === 0,
    isThinned: reply.is_thinned,
  };
}

/** Draws an envelope where many samples share a pixel, else a line. */
function drawn(name: string, role: Role, found: Curve, alpha = 0.45): { bands: Band[]; lines: Line[] } {
  if (!found.isThinned) return { bands: [], lines: [{ name, role, y: found.mean, gaps: found.gaps }] };
  return { bands: [{ name, role, low: found.least, high: found.greatest, gaps: found.gaps, alpha, edge: true }], lines: [] };
}

function sigmaBand(name: string, role: Role, found: Curve): Band[] {
  const { sigma } = found;
  if (!sigma) return [];
  const edge = (sign: number): Values => found.mean.map((value, i) => {
    const by = sigma[i] ?? NaN;
    return value === null || Number.isNaN(by) ? null : value + sign * by;
  });
  return [{ name: `${name}, one sigma`, quiet: true, role, low: edge(-1), high: edge(1), gaps: found.gaps, alpha: 0.2, edge: false }];
}

export const calibration = computed<Span | null>(() => {
  const window = shown.value?.times.window;
  if (window) return { from: window.start_s, to: window.end_s };
  const phase = ribbons.answer.value?.phases.find(({ what }) => what === "calibrating");
  return phase ? { from: phase.from_s, to: phase.to_s } : null;
});

/** The settling time: first seconds of captive flight, which the model says to ignore. */
export const settling = computed<Span | null>(() => {
  const phase = ribbons.answer.value?.phases.find(({ what }) => what === "settling");
  return phase ? { from: phase.from_s, to: phase.to_s } : null;
});

const marks = computed<Mark[]>(() => {
  const launch = ribbons.answer.value?.launch_s ?? null;
  const hasLaunch = shown.value?.opened.overview.has_launch === true;
  return launch === null || !hasLaunch ? [] : [{ name: "launch", at: launch, role: "ink" }];
});

export const altitudeSpec = computed<TimeSpec | null>(() => {
  const reply = altitudes.answer.value;
  if (!reply) return null;
  const [measured, modelled] = [0, 1].map((at) => curve(reply, at));
  const parts = [
    ...(measured && !measured.isEmpty ? [drawn("Measured", "measured", measured)] : []),
    ...(modelled && !modelled.isEmpty ? [drawn("Modelled", "modelled", modelled)] : []),
  ];
  return {
    x: Array.from(reply.time_s),
    bands: parts.flatMap(({ bands }) => bands),
    lines: parts.flatMap(({ lines }) => lines),
    levels: [], marks: marks.value, shade: calibration.value, ignored: null, zero: false, unit: "",
  };
});

/** Whether the shown error excludes the reference's wander. */
export const isBeyondReference = computed(() => {
  const reply = errorNow.answer.value;
  return reply?.curves[0]?.signal.signal === "beyond_reference";
});

interface Part {
  readonly x: ReadonlyArray<number>;
  readonly bands: Band[];
  readonly lines: Line[];
}

function errorPart(reply: Series, name: string, role: Role): Part | null {
  const found = curve(reply, 0);
  if (!found || found.isEmpty) return null;
  const { bands, lines } = drawn(name, role, found, 0.5);
  const x = Array.from(reply.time_s);
  const span = settling.value;
  const seen = (y: Values): Values => (span ? y.map((value, i) => ((x[i] ?? 0) < span.to ? null : value)) : y);
  return {
    x,
    bands: [...sigmaBand(name, role, found), ...bands].map((band) => ({ ...band, low: seen(band.low), high: seen(band.high) })),
    lines: lines.map((line) => ({ ...line, y: seen(line.y), width: 1.75 })),
  };
}

/** The prediction of the user's own formula: set by `formula.ts`, drawn here. */
export const ownPrediction = signal<Of<Series> | null>(null);

export const errorSpec = computed<TimeSpec | null>(() => {
  const now = errorNow.answer.value;
  if (!now) return null;
  const then = before.value ? errorBefore.answer.value : null;
  const parts: Part[] = [];
  const roles = new Set<string>();
  for (const reply of then ? [then, now] : [now]) {
    const role = standing(reply.asked);
    if (role === null || roles.has(role)) continue;
    // One picture shows one measure; the diagnosis of one of the two models may still be under way.
    if (reply.curves[0]?.signal.signal !== now.curves[0]?.signal.signal) continue;
    roles.add(role);
    // Without a revision there is no "after": the error shown is the one that Add would reduce.
    const part = errorPart(reply, before.value === null ? "Error" : role === "after" ? "After" : "Before", role);
    if (part) parts.push(part);
  }
  const what = whatIf.value.length > 0 ? predictions.answer.value : null;
  if (what) parts.push(predictionPart(what));
  if (ownPrediction.value) parts.push(predictionPart(ownPrediction.value));
  const merged = joined(parts);
  const bound = sensor.value === null ? undefined : ribbons.answer.value?.bounds_m[sensor.value];
  return { ...merged, levels: limits(bound), marks: marks.value, shade: calibration.value, ignored: settling.value, zero: true, unit: "" };
});

function predictionPart(reply: Series): Part {
  const lines = reply.curves.map((of, at): Line | null => {
    const found = curve(reply, at);
    if (!found || of.signal.signal !== "effect") return null;
    const title = guides.value.get(of.signal.of.effect)?.title ?? of.signal.of.effect;
    return { name: `What if: ${title}`, role: "what-if", y: found.mean, gaps: found.gaps, dashed: true, width: 2 };
  });
  return { x: Array.from(reply.time_s), bands: [], lines: lines.filter((line) => line !== null) };
}

function limits(bound: number | undefined): Level[] {
  const launch = ribbons.answer.value?.launch_s ?? null;
  const end = shown.value?.opened.last_s ?? 0;
  if (bound === undefined || launch === null) return [];
  return [
    { name: "alarm limit", y: bound, role: "ink", from: launch, to: end },
    { name: "", y: -bound, role: "ink", from: launch, to: end },
  ];
}

/** Joins parts on one axis. Where a part has no point, its curve continues to its next one. */
function joined(parts: ReadonlyArray<Part>): { x: ReadonlyArray<number>; bands: Band[]; lines: Line[] } {
  const [first, ...rest] = parts;
  if (!first) return { x: [], bands: [], lines: [] };
  const isShared = rest.every(({ x }) => x.length === first.x.length && x[0] === first.x[0] && x.at(-1) === first.x.at(-1));
  if (isShared) return { x: first.x, bands: parts.flatMap(({ bands }) => bands), lines: parts.flatMap(({ lines }) => lines) };
  const x = [...new Set(parts.flatMap((part) => part.x))].sort((one, other) => one - other);
  const place = new Map(x.map((time, i) => [time, i]));
  const spread = (part: Part, y: Values): Values => {
    const out = new Array<number | null>(x.length).fill(null);
    part.x.forEach((time, i) => { out[place.get(time) ?? 0] = y[i] ?? null; });
    return out;
  };
  return {
    x,
    bands: parts.flatMap((part) => part.bands.map((band) => ({ ...band, low: spread(part, band.low), high: spread(part, band.high) }))),
    lines: parts.flatMap((part) => part.lines.map((line) => ({ ...line, y: spread(part, line.y) }))),
  };
}

/** Largest number of points. They are requested once, and brushed here. */
const MOST_POINTS = 3000;

export function signalOf(name: string): Signal {
  switch (name) {
    case "speed": return { signal: "speed" };
    case "climb_rate": return { signal: "climb_rate" };
    case "load_factor": return { signal: "load_factor" };
    case "turn_rate": return { signal: "turn_rate" };
    case "error": return errorSignal(sensor.value ?? "baro", diagnosed.answer.value, model.value);
    default: return { signal: "column", name };
  }
}

export interface Points {
  /** The model that the points belong to. */
  readonly asked: ModelText;
  readonly reply: Paired;
  readonly x: string;
  readonly y: string;
}

/** Points of one signal over another, both chosen by the user; `isAll`: also in the settling time. */
export function points(x: () => string, y: () => string, isAll = false): { answer: { readonly value: Points | null }; problem: { readonly value: string | null } } {
  return resource(
    () => {
      const flight = shown.value;
      if (!flight || flight.opened.overview.refused !== null || x() === "" || y() === "") return null;
      return { flight: flight.flight, x: x(), y: y(), xSignal: signalOf(x()), ySignal: signalOf(y()), model: model.value, times: flight.times, from: isAll ? null : (settling.value?.to ?? null) };
    },
    async (of): Promise<Points> => ({
      asked: of.model, x: of.x, y: of.y,
      reply: await ask("scatter", {
        flight: of.flight, model: of.model, times: of.times, x: of.xSignal, y: of.ySignal,
        from_s: of.from, to_s: null, at_most: MOST_POINTS,
      }),
    }),
    REST,
  );
}

export interface Correlations {
  /** The model that `now` belongs to. */
  readonly asked: ModelText;
  readonly now: Correlated;
  readonly then: Correlated | null;
}

const LAG_SHARE = 0.15;
const LONGEST_LAG = 120;

function correlationsWith(other: () => string | null): Resource<Correlations> {
  return resource(
    () => {
      const flight = shown.value;
      if (!flight || flight.opened.overview.refused !== null || sensor.value === null || !errorNow.answer.value) return null;
      const name = other();
      return {
        flight: flight.flight, times: flight.times, model: model.value, before: before.value,
        signal: errorSignal(sensor.value, diagnosed.answer.value, model.value), signalBefore: errorSignal(sensor.value, diagnosedBefore.answer.value, before.value),
        with: name === null ? null : signalOf(name),
        from: settling.value?.to ?? null,
        longest: Math.min(LONGEST_LAG, LAG_SHARE * (flight.opened.last_s - flight.opened.first_s)),
      };
    },
    async (of): Promise<Correlations> => {
      const one = (text: ModelText, signal: Signal): Promise<Correlated> => ask("correlation", {
        flight: of.flight, model: text, times: of.times, signal, with: of.with, from_s: of.from, to_s: null, longest_lag_s: of.longest,
      });
      return { asked: of.model, now: await one(of.model, of.signal), then: of.before ? await one(of.before, of.signalBefore) : null };
    },
    REST,
  );
}

/** The error's autocorrelation, with the present model and with the one before. */
export const correlations = correlationsWith(() => null);
/** Whether the error's correlation with another signal is shown; it is requested only then. */
export const isCrossShown = signal(false);
export const crossCorrelations = correlationsWith(() => (isCrossShown.value ? crossWith.value : null));
