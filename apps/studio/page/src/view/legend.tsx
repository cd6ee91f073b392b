// What each curve is, and its value where the cursor stands; without a cursor the name alone.

import type { JSX } from "preact";

import { short } from "../charts/number";
import type { TimeSpec, Values } from "../charts/time_chart";
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
        <span key={name} class="legend-entry">
          <span class={`swatch ${look}`} style={{ color: `var(--${role})` }} aria-hidden="true" />
          {name}
          {value === null ? null : <b class="number">{value}</b>}
        </span>
      ))}
    </figcaption>
  );
}

function entries(spec: TimeSpec, at: number | null): Entry[] {
  const place = at === null ? -1 : nearest(spec.x, at);
  const bands = spec.bands.map((band): Entry => ({ name: band.name, role: band.role, look: "area", value: range(band.low, band.high, place) }));
  const lines = spec.lines.map((line): Entry => ({ name: line.name, role: line.role, look: line.dashed ? "dashed" : "line", value: one(line.y, place) }));
  return [...lines, ...bands];
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

/** Between values as far apart as this nothing is read off, in points of the axis. */
const REACH = 60;

function around(y: Values, place: number): number | null {
  if (place < 0) return null;
  for (let by = 0; by <= REACH; by += 1) {
    const value = y[place - by] ?? y[place + by] ?? null;
    if (value !== null) return value;
  }
  return null;
}

function one(y: Values, place: number): string | null {
  const value = around(y, place);
  return value === null ? null : short(value);
}

function range(low: Values, high: Values, place: number): string | null {
  const [from, to] = [around(low, place), around(high, place)];
  if (from === null || to === null) return null;
  const [one, other] = [short(from), short(to)];
  return one === other ? one : `${one} to ${other}`;
}
