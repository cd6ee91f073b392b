// The name of each curve and its value at the cursor; without a cursor the name alone.

import type { JSX } from "preact";

import type { Band, TimeSpec, Values } from "../charts/time_chart";
import { cursor } from "../state/view";

interface Entry {
  readonly name: string;
  readonly role: string;
  readonly look: "line" | "area" | "dashed";
  readonly value: string | null;
}

export interface LegendProps {
  readonly title: string;
  readonly unit: string;
  readonly spec: TimeSpec | null;
}

export function Legend({ title, unit, spec }: LegendProps): JSX.Element {
  const list = spec ? entries(spec, cursor.value) : [];
  return (
    <figcaption class="legend">
      <span class="legend-title">{title}, {unit}</span>
      {list.map(({ name, role, look, value }) => (
        <span key={name} class={`legend-entry ${look}`} title={name}>
          <span class={`swatch ${look}`} style={{ color: `var(--${role})` }} aria-hidden="true" />
          <span class="legend-name">{name}</span>
          {value === null ? null : <b class="number">{value}</b>}
        </span>
      ))}
    </figcaption>
  );
}

function entries(spec: TimeSpec, at: number | null): Entry[] {
  const place = at === null ? -1 : nearest(spec.x, at);
  const bands = spec.bands.filter(({ quiet }) => !quiet).map((band): Entry => {
    const sigma = spec.bands.find(({ quiet, role }) => quiet && role === band.role);
    return { name: band.name, role: band.role, look: "area", value: range(band.low, band.high, place, sigmaAt(sigma, place)) };
  });
  const lines = spec.lines.map((line): Entry => {
    const sigma = spec.bands.find(({ quiet, role }) => quiet && role === line.role);
    return { name: line.name, role: line.role, look: line.dashed ? "dashed" : "line", value: one(line.y, place, sigmaAt(sigma, place)) };
  });
  // What-if curves come last.
  return [...lines, ...bands].sort((one, other) => Number(one.look === "dashed") - Number(other.look === "dashed"));
}

function sigmaAt(band: Band | undefined, place: number): number | null {
  if (!band) return null;
  const [low, high] = [around(band.low, place), around(band.high, place)];
  return low === null || high === null ? null : (high - low) / 2;
}

function nearest(x: ReadonlyArray<number>, at: number): number {
  let [low, high] = [0, x.length - 1];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((x[middle] ?? Infinity) < at) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Largest distance from the cursor to a value that is read off, in points of the axis. */
const REACH = 60;

function around(y: Values, place: number): number | null {
  if (place < 0) return null;
  for (let by = 0; by <= REACH; by += 1) {
    const value = y[place - by] ?? y[place + by] ?? null;
    if (value !== null) return value;
  }
  return null;
}

function figure(value: number): string {
  const digits = Math.abs(value) >= 100 ? 1 : 2;
  return value.toFixed(digits).replace("-", "−");
}

function one(y: Values, place: number, sigma: number | null): string | null {
  const value = around(y, place);
  return value === null ? null : `${figure(value)}${sigma === null ? "" : ` ± ${figure(sigma)}`}`;
}

function range(low: Values, high: Values, place: number, sigma: number | null): string | null {
  const [from, to] = [around(low, place), around(high, place)];
  if (from === null || to === null) return null;
  if (sigma !== null) return `${figure((from + to) / 2)} ± ${figure(sigma)}`;
  const [least, greatest] = [figure(from), figure(to)];
  return least === greatest ? least : `${least} to ${greatest}`;
}
