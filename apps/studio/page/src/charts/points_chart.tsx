// Points and curves over an axis other than time: scatter, x-y, correlations. Drawn by uPlot.

import type { JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";

import { colour, faint, onTheme } from "./colours";
import type { Role } from "./colours";
import { short } from "./number";

export interface Layer {
  readonly role: Role;
  readonly y: ReadonlyArray<number | null>;
  readonly as: "dots" | "bold dots" | "stems" | "line";
}

export interface PointsSpec {
  /** Never decreasing. */
  readonly x: ReadonlyArray<number>;
  readonly layers: ReadonlyArray<Layer>;
  readonly xName: string;
  readonly yName: string;
  /** Distance from zero of the two dashed lines; null for none. */
  readonly band: number | null;
  readonly zero: boolean;
  readonly yRange: [number, number] | null;
}

const FONT = '11px system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';

export function PointsChart({ label, spec }: { readonly label: string; readonly spec: PointsSpec }): JSX.Element {
  const place = useRef<HTMLDivElement>(null);
  const latest = useRef(spec);
  const plot = useRef<uPlot | null>(null);
  latest.current = spec;
  const shape = JSON.stringify([spec.layers.map(({ role, as }) => [role, as]), spec.xName, spec.yName]);

  useEffect(() => {
    const box = place.current;
    if (!box) return undefined;
    const made = make(box, () => latest.current);
    plot.current = made;
    const stop = onTheme(() => made.redraw(false, true));
    const watcher = new ResizeObserver(() => made.setSize(sizeOf(box)));
    watcher.observe(box);
    return () => {
      watcher.disconnect();
      stop();
      made.destroy();
      plot.current = null;
    };
  }, [shape]);

  useEffect(() => plot.current?.setData(columns(spec)), [spec]);

  return <div ref={place} class="plot points" role="img" aria-label={label} />;
}

function columns(spec: PointsSpec): uPlot.AlignedData {
  return [[...spec.x], ...spec.layers.map(({ y }) => [...y])];
}

function sizeOf(box: HTMLElement): { width: number; height: number } {
  return { width: Math.max(box.clientWidth, 120), height: Math.max(box.clientHeight, 80) };
}

function make(box: HTMLElement, spec: () => PointsSpec): uPlot {
  const first = spec();
  const axis: uPlot.Axis = {
    stroke: () => colour("faint"),
    grid: { stroke: () => colour("grid"), width: 1 },
    ticks: { show: false },
    font: FONT,
    labelFont: FONT,
    labelSize: 15,
    labelGap: 0,
    gap: 3,
    values: (_, splits) => splits.map(mark),
  };
  const options: uPlot.Options = {
    ...sizeOf(box),
    padding: [6, 8, 0, 0],
    legend: { show: false },
    cursor: { show: false },
    scales: {
      x: { time: false, range: (_, least, greatest) => room(least, greatest) },
      y: { range: (_, least, greatest) => yRange(spec(), least, greatest) },
    },
    axes: [
      { ...axis, size: 18, label: first.xName },
      { ...axis, size: 40, space: 24, label: first.yName },
    ],
    series: [{}, ...first.layers.map(series)],
    hooks: { draw: [(self) => lines(self, spec())] },
  };
  return new uPlot(options, columns(first), box);
}

function mark(value: number): string {
  const size = Math.abs(value);
  if (size >= 1e5 || (size > 0 && size < 1e-3)) return short(value);
  return String(Math.round(value * 1e6) / 1e6).replace("-", "−");
}

function series({ role, as }: Layer): uPlot.Series {
  if (as === "line") return { stroke: () => colour(role), width: 2, points: { show: false } };
  if (as === "stems") {
    const bars = uPlot.paths.bars?.({ size: [0.5, 4, 1], align: 0 });
    return {
      stroke: () => colour(role), fill: () => colour(role), width: 0, points: { show: false },
      ...(bars ? { paths: bars } : {}),
    };
  }
  const bold = as === "bold dots";
  const fill = (): string => (bold ? colour(role) : faint(role, 0.5));
  return {
    paths: () => null,
    points: { show: true, size: bold ? 5 : 3.5, width: 0, stroke: fill, fill },
  };
}

function room(least: number | null, greatest: number | null): uPlot.Range.MinMax {
  const [low, high] = [least ?? 0, greatest ?? 1];
  const margin = low === high ? 1 : 0.03 * (high - low);
  return [low - margin, high + margin];
}

function yRange(spec: PointsSpec, least: number | null, greatest: number | null): uPlot.Range.MinMax {
  if (spec.yRange) return spec.yRange;
  let [low, high] = [least ?? 0, greatest ?? 0];
  if (spec.zero) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
  if (spec.band !== null) [low, high] = [Math.min(low, -spec.band), Math.max(high, spec.band)];
  return room(low, high === low ? low + 1 : high);
}

function lines(plot: uPlot, spec: PointsSpec): void {
  const { ctx, bbox } = plot;
  const level = (y: number, style: string, dash: ReadonlyArray<number>): void => {
    const at = plot.valToPos(y, "y", true);
    ctx.strokeStyle = style;
    ctx.lineWidth = uPlot.pxRatio;
    ctx.setLineDash(dash.map((length) => length * uPlot.pxRatio));
    ctx.beginPath();
    ctx.moveTo(bbox.left, at);
    ctx.lineTo(bbox.left + bbox.width, at);
    ctx.stroke();
    ctx.setLineDash([]);
  };
  if (spec.zero) level(0, colour("faint"), []);
  if (spec.band !== null) for (const y of [-spec.band, spec.band]) level(y, colour("ink"), [5, 4]);
}
