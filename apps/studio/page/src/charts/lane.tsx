// One signal of the motion in a lane as high as a line of text; each pixel spans its least to greatest value.

import type { JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";

import { cursor, view } from "../state/view";
import { colour, faint, onTheme } from "./colours";
import { short } from "./number";

export interface LaneProps {
  readonly name: string;
  readonly unit: string;
  readonly time: Float64Array;
  readonly values: Float64Array;
}

export function Lane({ name, unit, time, values }: LaneProps): JSX.Element {
  const place = useRef<HTMLCanvasElement>(null);
  const { from, to } = view.value;
  const [least, greatest] = limits(time, values, from, to);
  const at = cursor.value === null ? null : nearest(time, values, cursor.value);

  useEffect(() => {
    const canvas = place.current;
    if (!canvas) return undefined;
    const act = (): void => draw(canvas, time, values, from, to, least, greatest);
    act();
    const watcher = new ResizeObserver(act);
    watcher.observe(canvas);
    const stop = onTheme(act);
    return () => {
      watcher.disconnect();
      stop();
    };
  }, [time, values, from, to]);

  const range = Number.isFinite(least) ? `${short(least)} to ${short(greatest)} ${unit}` : "not recorded";
  return (
    <div class="ribbon lane">
      <span class="ribbon-name" aria-hidden="true">{name}</span>
      <div class="ribbon-track">
        <canvas ref={place} role="img" aria-label={`${name}, ${range}`} />
        <span class="lane-value number" aria-hidden="true">{at === null ? range : `${short(at)} ${unit}`}</span>
      </div>
    </div>
  );
}

function limits(time: Float64Array, values: Float64Array, from: number, to: number): [number, number] {
  let [least, greatest] = [Infinity, -Infinity];
  for (let i = 0; i < time.length; i += 1) {
    const [at, value] = [time[i] ?? NaN, values[i] ?? NaN];
    if (at < from || at > to || Number.isNaN(value)) continue;
    least = Math.min(least, value);
    greatest = Math.max(greatest, value);
  }
  return [least, greatest];
}

function nearest(time: Float64Array, values: Float64Array, at: number): number | null {
  let [low, high] = [0, time.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((time[middle] ?? Infinity) < at) low = middle + 1;
    else high = middle;
  }
  const value = values[Math.min(low, values.length - 1)];
  return value === undefined || Number.isNaN(value) ? null : value;
}

function draw(
  canvas: HTMLCanvasElement,
  time: Float64Array,
  values: Float64Array,
  from: number,
  to: number,
  least: number,
  greatest: number,
): void {
  const ratio = devicePixelRatio;
  const [width, height] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio];
  canvas.width = width;
  canvas.height = height;
  const ctx = canvas.getContext("2d");
  if (!ctx || !Number.isFinite(least)) return;
  const span = Math.max(greatest - least, 1e-9);
  const y = (value: number): number => height - 2 * ratio - ((value - least) / span) * (height - 4 * ratio);
  if (least < 0 && greatest > 0) {
    ctx.fillStyle = faint("faint", 0.4);
    ctx.fillRect(0, y(0), width, ratio);
  }
  ctx.strokeStyle = colour("faint");
  ctx.lineWidth = 1.25 * ratio;
  ctx.beginPath();
  let [column, low, high, last] = [-1, 0, 0, -Infinity];
  const flush = (): void => {
    if (column < 0) return;
    ctx.lineTo(column, y(low));
    ctx.lineTo(column, y(high));
  };
  for (let i = 0; i < time.length; i += 1) {
    const [at, value] = [time[i] ?? NaN, values[i] ?? NaN];
    if (at < from - 1 || at > to + 1 || Number.isNaN(value)) continue;
    const next = Math.round(((at - from) / (to - from)) * width);
    if (at - last > 3) {
      flush();
      ctx.moveTo(next, y(value));
      [column, low, high] = [next, value, value];
    } else if (next !== column) {
      flush();
      [column, low, high] = [next, value, value];
    }
    [low, high, last] = [Math.min(low, value), Math.max(high, value), at];
  }
  flush();
  ctx.stroke();
}
