// The flight seen from above, north up; the brushed stretch and the cursor are marked.

import type { JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";

import { colour, onTheme } from "./colours";
import { metres } from "./number";
import { brush, cursor, view } from "../state/view";

export interface TrackPoints {
  readonly time: ReadonlyArray<number>;
  /** Metres from the start of the record. */
  readonly east: ReadonlyArray<number>;
  readonly north: ReadonlyArray<number>;
}

export function Track({ points }: { readonly points: TrackPoints }): JSX.Element {
  const place = useRef<HTMLCanvasElement>(null);
  const [seen, brushed, at] = [view.value, brush.value, cursor.value];
  const extent = extentOf(points);

  useEffect(() => {
    const canvas = place.current;
    if (!canvas) return undefined;
    const act = (): void => {
      const ratio = devicePixelRatio;
      const [width, height] = [canvas.clientWidth, canvas.clientHeight];
      canvas.width = width * ratio;
      canvas.height = height * ratio;
      const ctx = canvas.getContext("2d");
      if (!ctx || !extent) return;
      ctx.scale(ratio, ratio);
      const scale = Math.min((width - 24) / extent.width, (height - 40) / extent.height);
      const x = (i: number): number => width / 2 + ((points.east[i] ?? 0) - extent.east) * scale;
      const y = (i: number): number => (height - 16) / 2 - ((points.north[i] ?? 0) - extent.north) * scale;
      const path = (from: number, to: number, style: string, line: number): void => {
        ctx.strokeStyle = style;
        ctx.lineWidth = line;
        ctx.lineJoin = "round";
        ctx.beginPath();
        let drawing = false;
        points.time.forEach((time, i) => {
          if (time < from || time > to) {
            drawing = false;
            return;
          }
          if (drawing) ctx.lineTo(x(i), y(i));
          else ctx.moveTo(x(i), y(i));
          drawing = true;
        });
        ctx.stroke();
      };
      path(-Infinity, Infinity, colour("rule"), 1.5);
      path(seen.from, seen.to, colour("reference"), 2);
      if (brushed) path(brushed.from, brushed.to, colour("brush"), 3);
      dot(ctx, x(0), y(0), colour("ink"), 3.5);
      if (at !== null) {
        const i = points.time.findIndex((time) => time >= at);
        if (i >= 0) dot(ctx, x(i), y(i), colour("brush"), 5);
      }
      rule(ctx, scale, height, width);
    };
    act();
    const watcher = new ResizeObserver(act);
    watcher.observe(canvas);
    const stop = onTheme(act);
    return () => {
      watcher.disconnect();
      stop();
    };
  }, [points, seen, brushed, at]);

  const size = extent ? `${metres(extent.width)} from west to east, ${metres(extent.height)} from south to north` : "";
  return <canvas class="plot track" ref={place} role="img" aria-label={`Track from above, north up: ${size}`} />;
}

interface Extent {
  /** The centre. */
  readonly east: number;
  readonly north: number;
  readonly width: number;
  readonly height: number;
}

function extentOf({ east, north }: TrackPoints): Extent | null {
  if (east.length === 0) return null;
  const limits = (values: ReadonlyArray<number>): [number, number] =>
    values.reduce<[number, number]>(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
  const [[west, right], [south, top]] = [limits(east), limits(north)];
  return { east: (west + right) / 2, north: (south + top) / 2, width: Math.max(right - west, 1), height: Math.max(top - south, 1) };
}

function dot(ctx: CanvasRenderingContext2D, x: number, y: number, style: string, radius: number): void {
  ctx.fillStyle = style;
  ctx.strokeStyle = colour("ground");
  ctx.lineWidth = 1.5;
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, 2 * Math.PI);
  ctx.fill();
  ctx.stroke();
}

// A scale bar of a round length, at most a third of the picture's width.
function rule(ctx: CanvasRenderingContext2D, scale: number, height: number, width: number): void {
  const most = width / 3 / scale;
  const power = 10 ** Math.floor(Math.log10(most));
  const length = [5, 2, 1].map((factor) => factor * power).find((candidate) => candidate <= most) ?? power;
  const y = height - 10;
  ctx.strokeStyle = ctx.fillStyle = colour("faint");
  ctx.lineWidth = 1.5;
  ctx.beginPath();
  ctx.moveTo(10, y - 4);
  ctx.lineTo(10, y);
  ctx.lineTo(10 + length * scale, y);
  ctx.lineTo(10 + length * scale, y - 4);
  ctx.stroke();
  ctx.font = '11px system-ui, "DejaVu Sans", sans-serif';
  ctx.textBaseline = "bottom";
  ctx.fillText(length >= 1000 ? `${length / 1000} km` : `${length} m`, 16 + length * scale, y + 4);
  ctx.textAlign = "right";
  ctx.fillText("north ↑", width - 8, y + 4);
  ctx.textAlign = "left";
}
