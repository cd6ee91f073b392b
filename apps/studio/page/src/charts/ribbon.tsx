// What happened when, as stretches along the shared time axis.

import type { JSX } from "preact";

import { view } from "../state/view";
import { clock } from "./number";
import { useWidth } from "./use_width";

export interface Stretch {
  readonly from: number;
  readonly to: number;
  /** Chooses the look. */
  readonly kind: string;
  readonly text: string;
}

export interface RibbonProps {
  readonly label: string;
  readonly name: string;
  readonly stretches: ReadonlyArray<Stretch>;
  readonly look: "trust" | "manoeuvre";
}

/** Width of a letter of the ribbon's text, pixels. */
const LETTER = 6.6;

export function Ribbon({ label, name, stretches, look }: RibbonProps): JSX.Element {
  const [place, width] = useWidth<HTMLDivElement>();
  const { from, to } = view.value;
  const share = (at: number): number => (Math.min(Math.max(at, from), to) - from) / (to - from);
  const seen = stretches.filter((stretch) => stretch.to > from && stretch.from < to);
  // There may be thousands of stretches: only those wide enough to be seen are drawn.
  const wide = seen.filter((stretch) => (share(stretch.to) - share(stretch.from)) * width > 0.4);
  return (
    <div class={`ribbon ${look}`}>
      <span class="ribbon-name" aria-hidden="true">{name}</span>
      <div class="ribbon-track" ref={place} role="img" aria-label={`${label}: ${spoken(seen)}`}>
        {wide.map((stretch) => {
          const [left, right] = [share(stretch.from), share(stretch.to)];
          const room = (right - left) * width;
          return (
            <span
              key={`${stretch.from} ${stretch.kind}`}
              class={`stretch ${stretch.kind}`}
              style={{ left: `${left * 100}%`, width: `${(right - left) * 100}%` }}
              title={`${stretch.text}, ${clock(stretch.from)} to ${clock(stretch.to)}`}
            >
              {room > stretch.text.length * LETTER + 8 ? stretch.text : ""}
            </span>
          );
        })}
      </div>
    </div>
  );
}

const SPOKEN = 12;

function spoken(stretches: ReadonlyArray<Stretch>): string {
  if (stretches.length === 0) return "nothing in view";
  const first = stretches.slice(0, SPOKEN);
  const words = first.map(({ text, from, to }) => `${text} from ${clock(from)} to ${clock(to)}`);
  const more = stretches.length - first.length;
  return words.join(", ") + (more > 0 ? `, and ${more} more` : "");
}
