// The error by manoeuvre and speed: a table in which a larger error makes a darker cell.

import type { JSX } from "preact";

import type { Paired } from "../protocol";
import { points } from "../state/pictures";
import { standing } from "../state/model";
import { ribbons } from "../state/studio";
import { capital, plain } from "./words";

const found = points(() => "speed", () => "error");
const COLUMNS = 4;

interface Row {
  readonly manoeuvre: string;
  /** For each range of speed: root mean square error, m, and number of points. */
  readonly cells: ReadonlyArray<{ readonly rms: number; readonly count: number } | null>;
}

export function HeatMap(): JSX.Element {
  const spans = ribbons.answer.value?.manoeuvres ?? [];
  if (found.problem.value !== null) return <p class="plot empty">{found.problem.value}</p>;
  if (!found.answer.value) return <div class="plot waiting" />;
  const { reply, asked } = found.answer.value;
  const role = standing(asked) ?? "before";
  if (reply.of === 0 || spans.length === 0) return <p class="plot empty">The flight has no speed.</p>;
  const edges = edgesOf(reply.x);
  const rows = rowsOf(reply, spans, edges);
  const most = Math.max(...rows.flatMap(({ cells }) => cells.map((cell) => cell?.rms ?? 0)), 1e-9);
  return (
    <div class="plot heat" tabIndex={0} role="region" aria-label="Error by manoeuvre and speed">
      <table>
        <caption class="hidden-text">Root mean square error in metres, by manoeuvre and speed</caption>
        <thead>
          <tr>
            <th scope="col">rms, m, at m/s</th>
            {edges.slice(1).map((to, at) => <th key={to} scope="col" class="number">{Math.round(edges[at] ?? 0)}–{Math.round(to)}</th>)}
          </tr>
        </thead>
        <tbody>
          {rows.map(({ manoeuvre, cells }) => (
            <tr key={manoeuvre}>
              <th scope="row">{capital(plain(manoeuvre))}</th>
              {cells.map((cell, at) => (
                <td
                  key={edges[at]}
                  class="number"
                  style={cell ? { background: `color-mix(in srgb, var(--${role}) ${Math.round((45 * cell.rms) / most)}%, var(--ground))` } : {}}
                  title={cell ? `${cell.count} points` : "never flown"}
                >
                  {cell ? cell.rms.toFixed(1) : ""}
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function edgesOf(speeds: Float64Array): number[] {
  const known = speeds.filter((speed) => !Number.isNaN(speed));
  const [low, high] = known.reduce<[number, number]>(([least, most], speed) => [Math.min(least, speed), Math.max(most, speed)], [Infinity, -Infinity]);
  return Array.from({ length: COLUMNS + 1 }, (_, at) => low + (at * (high - low)) / COLUMNS);
}

function rowsOf({ time_s, x, y }: Paired, spans: ReadonlyArray<{ from_s: number; to_s: number; what: string }>, edges: ReadonlyArray<number>): Row[] {
  const sums = new Map<string, Array<{ squares: number; count: number }>>();
  const [low, high] = [edges[0] ?? 0, edges.at(-1) ?? 1];
  let at = 0;
  for (let i = 0; i < time_s.length; i += 1) {
    const [time, speed, error] = [time_s[i] ?? NaN, x[i] ?? NaN, y[i] ?? NaN];
    while (at + 1 < spans.length && (spans[at]?.to_s ?? Infinity) < time) at += 1;
    const span = spans[at];
    if (!span || time < span.from_s || time > span.to_s || Number.isNaN(error)) continue;
    const column = Math.min(COLUMNS - 1, Math.floor((COLUMNS * (speed - low)) / Math.max(high - low, 1e-9)));
    const row = sums.get(span.what) ?? Array.from({ length: COLUMNS }, () => ({ squares: 0, count: 0 }));
    sums.set(span.what, row);
    const cell = row[column];
    if (!cell) continue;
    cell.squares += error * error;
    cell.count += 1;
  }
  return [...sums].map(([manoeuvre, row]) => ({
    manoeuvre,
    cells: row.map(({ squares, count }) => (count === 0 ? null : { rms: Math.sqrt(squares / count), count })),
  }));
}
