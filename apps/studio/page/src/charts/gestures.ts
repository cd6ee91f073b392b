// Mouse, fingers and keys over a time chart: they change what is in view, and nothing else.

import { brush, cursor, drag, pan, show, showWhole, view, zoom } from "../state/view";
import type { Span } from "../state/view";

/** A drag of fewer pixels is a click. */
const CLICK = 4;
const WHEEL = 0.0015;

export interface Hand {
  /** The element that is touched. */
  readonly area: HTMLElement;
  /** Present rectangle of its time axis. */
  readonly axis: () => DOMRect;
  /** Draws the span during a drag; null: none. */
  readonly draft: (span: Span | null) => void;
}

/** Listens for gestures; the returned function ends that. */
export function listen({ area, axis, draft }: Hand): () => void {
  const fingers = new Map<number, number>();
  let begun: { x: number; time: number; view: Span; as: "select" | "pan" | "zoom" } | null = null;

  const timeAt = (x: number, of: Span = view.value): number => {
    const box = axis();
    return of.from + ((x - box.left) / Math.max(box.width, 1)) * (of.to - of.from);
  };

  const down = (event: PointerEvent): void => {
    if (event.button === 2) return;
    fingers.set(event.pointerId, event.clientX);
    area.setPointerCapture(event.pointerId);
    const touched = event.pointerType === "touch" && drag.value === "select" && fingers.size > 1;
    const as = event.button === 1 || event.shiftKey || touched ? "pan" : drag.value;
    begun = { x: event.clientX, time: timeAt(event.clientX), view: view.value, as };
    if (event.button === 1) event.preventDefault();
  };

  const pinch = (event: PointerEvent): void => {
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    const before = fingers.get(event.pointerId);
    if (other === undefined || before === undefined) return;
    const factor = Math.abs(before - other) / Math.max(Math.abs(event.clientX - other), 8);
    zoom(Math.min(Math.max(factor, 0.5), 2), timeAt(other));
  };

  const move = (event: PointerEvent): void => {
    cursor.value = timeAt(event.clientX);
    if (!begun || !fingers.has(event.pointerId)) return;
    if (fingers.size > 1) {
      pinch(event);
      fingers.set(event.pointerId, event.clientX);
      return;
    }
    if (Math.abs(event.clientX - begun.x) < CLICK) return;
    if (begun.as === "pan") {
      const by = begun.time - timeAt(event.clientX, begun.view);
      show({ from: begun.view.from + by, to: begun.view.to + by });
    } else {
      draft(ordered(begun.time, timeAt(event.clientX)));
    }
  };

  const up = (event: PointerEvent): void => {
    const was = begun;
    fingers.delete(event.pointerId);
    if (fingers.size > 0) return;
    begun = null;
    draft(null);
    if (!was || event.type === "pointercancel") return;
    if (Math.abs(event.clientX - was.x) < CLICK) {
      if (was.as === "select") brush.value = null;
      return;
    }
    const span = ordered(was.time, timeAt(event.clientX));
    if (was.as === "select") brush.value = span;
    if (was.as === "zoom") show(span);
  };

  const wheel = (event: WheelEvent): void => {
    event.preventDefault();
    if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) pan(event.deltaX * WHEEL);
    else if (event.shiftKey) pan(event.deltaY * WHEEL);
    else zoom(Math.exp(event.deltaY * WHEEL), timeAt(event.clientX));
  };

  const leave = (): void => {
    if (!begun) cursor.value = null;
  };

  area.addEventListener("pointerdown", down);
  area.addEventListener("pointermove", move);
  area.addEventListener("pointerup", up);
  area.addEventListener("pointercancel", up);
  area.addEventListener("pointerleave", leave);
  area.addEventListener("wheel", wheel, { passive: false });
  area.addEventListener("dblclick", showWhole);
  return () => {
    area.removeEventListener("pointerdown", down);
    area.removeEventListener("pointermove", move);
    area.removeEventListener("pointerup", up);
    area.removeEventListener("pointercancel", up);
    area.removeEventListener("pointerleave", leave);
    area.removeEventListener("wheel", wheel);
    area.removeEventListener("dblclick", showWhole);
  };
}

function ordered(one: number, other: number): Span {
  const { from, to } = view.value;
  return { from: Math.max(Math.min(one, other), from), to: Math.min(Math.max(one, other), to) };
}

/** Handles a key; returns whether it was one of its own. */
export function press(event: KeyboardEvent): boolean {
  if (event.ctrlKey || event.altKey || event.metaKey) return false;
  const { from, to } = view.value;
  const at = cursor.value ?? (from + to) / 2;
  switch (event.key) {
    case "ArrowLeft":
    case "ArrowRight": {
      const sign = event.key === "ArrowLeft" ? -1 : 1;
      if (event.shiftKey) pan(0.2 * sign);
      else step(at + sign * (to - from) * 0.01);
      return true;
    }
    case "+":
    case "=":
      zoom(0.5, at);
      return true;
    case "-":
      zoom(2, at);
      return true;
    case "0":
    case "Home":
      showWhole();
      return true;
    case "[":
      brush.value = ordered(at, brush.value?.to ?? to);
      return true;
    case "]":
      brush.value = ordered(brush.value?.from ?? from, at);
      return true;
    case "Escape":
      brush.value = null;
      return true;
    default:
      return false;
  }
}

function step(to: number): void {
  const { from, to: end } = view.value;
  if (to < from) pan(-0.2);
  if (to > end) pan(0.2);
  cursor.value = Math.min(Math.max(to, view.value.from), view.value.to);
}
