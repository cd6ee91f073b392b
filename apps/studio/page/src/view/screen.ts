// Size of the screen.

import { signal } from "@preact/signals";

function matches(query: string): ReturnType<typeof signal<boolean>> {
  const list = matchMedia(query);
  const now = signal(list.matches);
  list.addEventListener("change", () => { now.value = list.matches; });
  return now;
}

/** A phone: everything in one column. */
export const isNarrow = matches("(max-width: 760px)");
/** Room for every panel below the curves. */
export const isWide = matches("(min-width: 1600px)");
