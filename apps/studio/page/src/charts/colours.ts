// The style sheet's colours as a canvas needs them, in the present theme.

export type Role =
  | "ink" | "faint" | "grid" | "rule" | "ground"
  | "measured" | "modelled" | "reference" | "before" | "after" | "what-if"
  | "calibration" | "brush" | "untrustworthy" | "doubtful" | "trusted";

let probe: HTMLElement | undefined;
const known = new Map<Role, string>();
const listeners = new Set<() => void>();

/** The colour as `rgb(...)`. */
export function colour(role: Role): string {
  const found = known.get(role);
  if (found !== undefined) return found;
  if (!probe) {
    probe = document.createElement("span");
    probe.hidden = true;
    document.body.append(probe);
  }
  probe.style.color = `var(--${role})`;
  const value = getComputedStyle(probe).color;
  known.set(role, value);
  return value;
}

/** The colour with a transparency. */
export function faint(role: Role, alpha: number): string {
  const parts = colour(role).match(/[\d.]+/g) ?? ["0", "0", "0"];
  return `rgba(${parts.slice(0, 3).join(", ")}, ${alpha})`;
}

/** Calls back when the theme has changed; the returned function ends that. */
export function onTheme(act: () => void): () => void {
  listeners.add(act);
  return () => listeners.delete(act);
}

function changed(): void {
  known.clear();
  for (const act of listeners) act();
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
// Prints are on white.
matchMedia("print").addEventListener("change", changed);
