// A small picture: points and the line through them.

import type { JSX } from "preact";

const WIDTH = 96;
const HEIGHT = 56;
const MARGIN = 3;

interface CloudProps {
  readonly x: Float64Array;
  readonly y: Float64Array;
  /** Slope of the line through the middle of the points. */
  readonly slope: number;
  readonly label: string;
}

export function Cloud({ x, y, slope, label }: CloudProps): JSX.Element {
  const [across, up] = [extent(x), extent(y)];
  const px = (value: number): number => MARGIN + ((value - across.least) / across.length) * (WIDTH - 2 * MARGIN);
  const py = (value: number): number => HEIGHT - MARGIN - ((value - up.least) / up.length) * (HEIGHT - 2 * MARGIN);
  const dots = Array.from(x, (value, i) => `M${px(value).toFixed(1)} ${py(y[i] ?? 0).toFixed(1)}h.01`).join("");
  const line = (value: number): number => up.mean + slope * (value - across.mean);
  const [left, right] = [across.least, across.least + across.length];
  return (
    <svg class="cloud" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} width={WIDTH} height={HEIGHT} role="img" aria-label={label}>
      <path class="cloud-dots" d={dots} />
      <line class="cloud-line" x1={px(left)} y1={py(line(left))} x2={px(right)} y2={py(line(right))} />
    </svg>
  );
}

function extent(values: Float64Array): { least: number; length: number; mean: number } {
  let [least, greatest, sum] = [Infinity, -Infinity, 0];
  for (const value of values) {
    least = Math.min(least, value);
    greatest = Math.max(greatest, value);
    sum += value;
  }
  return { least, length: Math.max(greatest - least, 1e-12), mean: sum / Math.max(values.length, 1) };
}
