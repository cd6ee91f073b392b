// Curves over the shared time axis, drawn by uPlot.

import { effect, useSignal } from "@preact/signals";
import type { JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";

import { brush, cursor, view } from "../state/view";
import type { Span } from "../state/view";
import { colour, faint, onTheme } from "./colours";
import type { Role } from "./colours";
import { listen, press } from "./gestures";
import { moment, short } from "./number";

export type Values = ReadonlyArray<number | null>;

/** Stretches without a record, which no line crosses. */
export type Gaps = ReadonlyArray<Span>;

export interface Line {
  readonly name: string;
  readonly role: Role;
  readonly y: Values;
  readonly gaps: Gaps;
  readonly width?: number;
  readonly dashed?: boolean;
  /** Left out of the legend, because another entry covers it. */
  readonly quiet?: boolean;
}

/** The area between two curves: an envelope of all samples, or a standard deviation about a mean. */
export interface Band {
  readonly name: string;
  readonly role: Role;
  readonly low: Values;
  readonly high: Values;
  readonly gaps: Gaps;
  readonly alpha: number;
  readonly edge: boolean;
  readonly quiet?: boolean;
}

export interface Level {
  readonly name: string;
  readonly y: number;
  readonly role: Role;
  readonly from: number;
  readonly to: number;
}

export interface Mark {
  readonly name: string;
  readonly at: number;
  readonly role: Role;
}

export interface TimeSpec {
  /** Seconds of the flight's clock. */
  readonly x: ReadonlyArray<number>;
  readonly bands: ReadonlyArray<Band>;
  readonly lines: ReadonlyArray<Line>;
  readonly levels: ReadonlyArray<Level>;
  readonly marks: ReadonlyArray<Mark>;
  readonly shade: Span | null;
  /** Span that is ignored; nothing is drawn there. */
  readonly ignored: Span | null;
  /** Whether the vertical range must include zero. */
  readonly zero: boolean;
  readonly unit: string;
}

export interface TimeChartProps {
  /** What the chart shows, for those who can't see it. */
  readonly label: string;
  readonly spec: TimeSpec;
  readonly axis: boolean;
}

/** Steps of the time axis: round seconds, minutes and hours. */
const STEPS_S = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400];

/** As wide as `--gutter`: the ribbons begin where the curves do. */
const GUTTER = 68;
const RIGHT = 10;
const FONT = '11.5px system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';

const nothing = (): null => null;
/** Height of a name with its spacing, pixels. */
const NAME_PX = 17;
const UNBOUND: uPlot.Cursor.Bind = {
  mousedown: nothing, mouseup: nothing, click: nothing, dblclick: nothing, mousemove: nothing, mouseleave: nothing, mouseenter: nothing,
};

export function TimeChart({ label, spec, axis }: TimeChartProps): JSX.Element {
  const place = useRef<HTMLDivElement>(null);
  const latest = useRef(spec);
  const plot = useRef<uPlot | null>(null);
  const draft = useSignal<Span | null>(null);
  latest.current = spec;
  const shape = shapeOf(spec, axis);

  useEffect(() => {
    const box = place.current;
    if (!box) return undefined;
    const made = make(box, () => latest.current, axis, () => draft.value);
    plot.current = made;
    const stops = [
      onTheme(() => made.redraw(false, true)),
      effect(() => {
        const { from, to } = view.value;
        made.setScale("x", { min: from, max: to });
      }),
      effect(() => {
        void [brush.value, draft.value];
        made.redraw(false, false);
      }),
      effect(() => moveCursor(made, cursor.value, view.value)),
    ];
    const watcher = new ResizeObserver(() => {
      const size = sizeOf(box);
      if (size.width !== made.width || size.height !== made.height) made.setSize(size);
    });
    watcher.observe(box);
    return () => {
      watcher.disconnect();
      for (const stop of stops) stop();
      made.destroy();
      plot.current = null;
    };
  }, [shape]);

  useEffect(() => {
    const box = place.current;
    if (!box) return undefined;
    const axis = (): DOMRect => (plot.current?.over ?? box).getBoundingClientRect();
    return listen({ area: box, axis, draft: (span) => { draft.value = span; } });
  }, []);

  useEffect(() => {
    plot.current?.setData(columns(spec), false);
    const { from, to } = view.value;
    plot.current?.setScale("x", { min: from, max: to });
  }, [spec]);

  return (
    <div
      ref={place}
      class="plot time"
      role="img"
      tabIndex={0}
      aria-label={`${label}. Arrow keys move the cursor, with Shift the view; plus and minus zoom, 0 shows all; [ and ] brush, Escape ends the brush.`}
      onKeyDown={(event) => {
        if (press(event)) event.preventDefault();
      }}
    />
  );
}

function shapeOf(spec: TimeSpec, axis: boolean): string {
  const bands = spec.bands.map(({ name, role, alpha, edge }) => [name, role, alpha, edge]);
  const lines = spec.lines.map(({ name, role, width, dashed }) => [name, role, width, dashed]);
  return JSON.stringify([bands, lines, axis, spec.unit]);
}

function columns(spec: TimeSpec): uPlot.AlignedData {
  const all: Array<Array<number | null>> = [];
  for (const { low, high } of spec.bands) all.push([...high], [...low]);
  for (const { y } of spec.lines) all.push([...y]);
  return [[...spec.x], ...all];
}

function sizeOf(box: HTMLElement): { width: number; height: number } {
  return { width: Math.max(box.clientWidth, 120), height: Math.max(box.clientHeight, 60) };
}

function make(
  box: HTMLElement,
  spec: () => TimeSpec,
  axis: boolean,
  drafted: () => Span | null,
): uPlot {
  const first = spec();
  const series: uPlot.Series[] = [{}];
  const bands: uPlot.Band[] = [];
  for (const band of first.bands) {
    const edge: uPlot.Series = band.edge
      ? { stroke: () => faint(band.role, 0.75), width: 1 }
      : { stroke: () => "transparent", width: 0 };
    const at = bands.length;
    const gaps: uPlot.Series.GapsRefiner = (self) => pixels(self, spec().bands[at]?.gaps ?? []);
    series.push({ ...edge, gaps, points: { show: false } }, { ...edge, gaps, points: { show: false } });
    const last = series.length - 1;
    bands.push({ series: [last - 1, last], fill: () => faint(band.role, band.alpha) });
  }
  for (const [at, line] of first.lines.entries()) {
    series.push({
      gaps: (self) => pixels(self, spec().lines[at]?.gaps ?? []),
      stroke: () => colour(line.role),
      width: line.width ?? 1.5,
      points: { show: false },
      ...(line.dashed ? { dash: [6, 4] } : {}),
    });
  }
  const common: uPlot.Axis = {
    stroke: () => colour("faint"),
    grid: { stroke: () => colour("grid"), width: 1 },
    ticks: { show: false },
    font: FONT,
  };
  const options: uPlot.Options = {
    ...sizeOf(box),
    padding: [6, RIGHT, axis ? 0 : 4, 0],
    series,
    bands,
    legend: { show: false },
    scales: {
      x: { time: false, auto: false },
      y: { range: (_, least, greatest) => rangeOf(spec(), least, greatest) },
    },
    axes: [
      axis
        ? { ...common, size: 20, gap: 3, values: (_, splits) => splits.map((value) => tick(value, splits)), incrs: STEPS_S }
        : { ...common, size: 0, values: (_, splits) => splits.map(() => "") },
      { ...common, size: GUTTER, gap: 4, space: 26, values: (_, splits) => splits.map((value) => `${trimmed(value)}${first.unit}`) },
    ],
    // The page's own gestures move the cursor.
    cursor: { bind: UNBOUND, drag: { x: false, y: false, setScale: false }, points: { show: false }, y: false },
    hooks: {
      drawClear: [(self) => under(self, spec())],
      draw: [(self) => over(self, spec(), drafted())],
    },
  };
  return new uPlot(options, columns(first), box);
}

// A line continues across a missing value, but not across a gap of the record.
function pixels(plot: uPlot, gaps: Gaps): uPlot.Series.Gaps {
  return gaps.map(({ from, to }) => [plot.valToPos(from, "x", true), plot.valToPos(to, "x", true)]);
}

function trimmed(value: number): string {
  const size = Math.abs(value);
  if (size > 0 && (size < 1e-5 || size >= 1e7)) return short(value);
  return String(Math.round(value * 1e6) / 1e6).replace("-", "−");
}

/** Time from which the axis is labelled in minutes, seconds. */
const MINUTES_S = 120;

function isInMinutes(splits: ReadonlyArray<number>): boolean {
  const step = splits.length > 1 ? (splits[1] ?? 0) - (splits[0] ?? 0) : 0;
  return step >= 1 && (splits.at(-1) ?? 0) > MINUTES_S;
}

function tick(value: number, splits: ReadonlyArray<number>): string {
  if (!isInMinutes(splits)) return `${trimmed(value)} s`;
  return moment(value);
}

function rangeOf(spec: TimeSpec, least: number | null, greatest: number | null): uPlot.Range.MinMax {
  let [low, high] = [least ?? 0, greatest ?? 0];
  if (spec.zero) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
  // A limit is shown unless it is far beyond what was measured.
  const room = Math.max(high - low, 1e-9);
  for (const { y } of spec.levels) {
    if (y > high && y - high < room) high = y;
    if (y < low && low - y < room) low = y;
  }
  if (low === high) return [low - 1, high + 1];
  const margin = 0.06 * (high - low);
  return [low - margin, high + margin];
}

function moveCursor(plot: uPlot, at: number | null, span: Span): void {
  if (at === null || at < span.from || at > span.to) {
    plot.setCursor({ left: -10, top: -10 }, false);
    return;
  }
  const left = ((at - span.from) / (span.to - span.from)) * plot.over.clientWidth;
  plot.setCursor({ left, top: plot.over.clientHeight / 2 }, false);
}

function clipped(plot: uPlot, act: (ctx: CanvasRenderingContext2D, ratio: number) => void): void {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  act(ctx, uPlot.pxRatio);
  ctx.restore();
}

function under(plot: uPlot, spec: TimeSpec): void {
  clipped(plot, (ctx, ratio) => {
    if (spec.ignored) hatch(plot, ctx, spec.ignored, ratio);
    if (spec.shade) fill(plot, ctx, spec.shade, faint("calibration", 0.22));
    if (brush.value) fill(plot, ctx, brush.value, faint("brush", 0.13));
  });
}

function fill(plot: uPlot, ctx: CanvasRenderingContext2D, span: Span, style: string): void {
  const [left, right] = [plot.valToPos(span.from, "x", true), plot.valToPos(span.to, "x", true)];
  ctx.fillStyle = style;
  ctx.fillRect(left, plot.bbox.top, right - left, plot.bbox.height);
}

function hatch(plot: uPlot, ctx: CanvasRenderingContext2D, span: Span, ratio: number): void {
  const { top, height } = plot.bbox;
  const [left, right] = [plot.valToPos(span.from, "x", true), plot.valToPos(span.to, "x", true)];
  ctx.save();
  ctx.beginPath();
  ctx.rect(left, top, right - left, height);
  ctx.clip();
  ctx.strokeStyle = colour("rule");
  ctx.lineWidth = ratio;
  for (let x = left - height; x < right; x += 7 * ratio) stroke(ctx, x, top + height, x + height, top);
  ctx.restore();
}

function over(plot: uPlot, spec: TimeSpec, draft: Span | null): void {
  clipped(plot, (ctx, ratio) => {
    const { bbox } = plot;
    ctx.font = FONT.replace(/^[\d.]+/, (size) => String(Number(size) * ratio));
    if (spec.zero) {
      const zero = plot.valToPos(0, "y", true);
      ctx.strokeStyle = colour("faint");
      ctx.lineWidth = ratio;
      stroke(ctx, bbox.left, zero, bbox.left + bbox.width, zero);
    }
    for (const level of spec.levels) limit(plot, ctx, level, ratio);
    spec.marks.forEach((mark) => event(plot, ctx, mark, ratio));
    for (const span of [brush.value, draft]) {
      if (!span) continue;
      if (span === draft) fill(plot, ctx, span, faint("brush", 0.13));
      ctx.strokeStyle = colour("brush");
      ctx.lineWidth = 1.5 * ratio;
      for (const at of [span.from, span.to]) {
        const x = plot.valToPos(at, "x", true);
        stroke(ctx, x, bbox.top, x, bbox.top + bbox.height);
      }
    }
  });
}

function limit(plot: uPlot, ctx: CanvasRenderingContext2D, level: Level, ratio: number): void {
  const y = plot.valToPos(level.y, "y", true);
  const [left, right] = [plot.valToPos(level.from, "x", true), plot.valToPos(level.to, "x", true)];
  ctx.strokeStyle = colour(level.role);
  ctx.lineWidth = 1.25 * ratio;
  ctx.setLineDash([7 * ratio, 5 * ratio]);
  stroke(ctx, left, y, right, y);
  ctx.setLineDash([]);
  if (!level.name) return;
  const end = Math.min(right, plot.bbox.left + plot.bbox.width) - 5 * ratio;
  ctx.textAlign = "right";
  // Levels come in pairs about zero: the name is written beyond the one with room for it.
  const room = level.y > 0 ? y - plot.bbox.top : plot.bbox.top + plot.bbox.height - y;
  const named = room > NAME_PX * ratio ? level.y : -level.y;
  ctx.textBaseline = named > 0 ? "bottom" : "top";
  write(ctx, level.name, end, plot.valToPos(named, "y", true) + (named > 0 ? -2 : 2) * ratio, level.role, ratio);
}

function event(plot: uPlot, ctx: CanvasRenderingContext2D, mark: Mark, ratio: number): void {
  const x = plot.valToPos(mark.at, "x", true);
  ctx.strokeStyle = colour(mark.role);
  ctx.lineWidth = 1.5 * ratio;
  stroke(ctx, x, plot.bbox.top, x, plot.bbox.top + plot.bbox.height);
  if (!mark.name) return;
  const room = plot.bbox.left + plot.bbox.width - x > ctx.measureText(mark.name).width + 10 * ratio;
  ctx.textAlign = room ? "left" : "right";
  ctx.textBaseline = "top";
  write(ctx, mark.name, x + (room ? 5 : -5) * ratio, plot.bbox.top + 3 * ratio, mark.role, ratio);
}

function stroke(ctx: CanvasRenderingContext2D, x0: number, y0: number, x1: number, y1: number): void {
  ctx.beginPath();
  ctx.moveTo(x0, y0);
  ctx.lineTo(x1, y1);
  ctx.stroke();
}

// Outlined in the background colour, to be readable over anything.
function write(ctx: CanvasRenderingContext2D, text: string, x: number, y: number, role: Role, ratio: number): void {
  ctx.strokeStyle = colour("ground");
  ctx.lineWidth = 3.5 * ratio;
  ctx.lineJoin = "round";
  ctx.strokeText(text, x, y);
  ctx.fillStyle = colour(role);
  ctx.fillText(text, x, y);
}
