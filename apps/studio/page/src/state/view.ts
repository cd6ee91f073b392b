// The part of the flight that is in view: one time axis for everything in the middle of the screen.

import { signal } from "@preact/signals";

export interface Span {
  readonly from: number;
  readonly to: number;
}

/** What a drag over a time chart does. */
export type Drag = "select" | "pan" | "zoom";

/** The whole flight. */
export const whole = signal<Span>({ from: 0, to: 1 });
/** What is in view. */
export const view = signal<Span>({ from: 0, to: 1 });
/** The brushed stretch. */
export const brush = signal<Span | null>(null);
/** Position of the cursor, seconds. */
export const cursor = signal<number | null>(null);
export const drag = signal<Drag>("select");

const NARROWEST = 1e-3;

/** Limits a view to the flight; it keeps its length when it is moved against an end. */
export function inside({ from, to }: Span): Span {
  const all = whole.value;
  const length = Math.min(Math.max(to - from, NARROWEST), all.to - all.from);
  const start = Math.min(Math.max(from, all.from), all.to - length);
  return { from: start, to: start + length };
}

export function show(span: Span): void {
  const next = inside(span);
  if (next.from !== view.value.from || next.to !== view.value.to) view.value = next;
}

export function showWhole(): void {
  view.value = whole.value;
}

export function isWhole(): boolean {
  return view.value.from <= whole.value.from && view.value.to >= whole.value.to;
}

export function zoom(factor: number, about?: number): void {
  const { from, to } = view.value;
  const at = about ?? cursor.value ?? (from + to) / 2;
  const middle = at < from || at > to ? (from + to) / 2 : at;
  show({ from: middle - (middle - from) * factor, to: middle + (to - middle) * factor });
}

export function pan(share: number): void {
  const { from, to } = view.value;
  const by = (to - from) * share;
  show({ from: from + by, to: to + by });
}

/** Shows another flight, first the part of it that is used. */
export function lookAt(span: Span, used: Span): void {
  const length = Math.max(span.to - span.from, NARROWEST);
  whole.value = { from: span.from, to: span.from + length };
  const margin = 0.03 * (used.to - used.from);
  view.value = inside({ from: Math.max(used.from - margin, span.from), to: Math.min(used.to + margin, span.to) });
  brush.value = null;
  cursor.value = null;
}
