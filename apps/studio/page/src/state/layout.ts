// What the user put where.

import { signal } from "@preact/signals";

export type PanelKind = "scatter" | "xy" | "correlation" | "track" | "heat";

/** What is in the places below the curves, where there is not room for all. */
export const places = signal<ReadonlyArray<PanelKind>>(["scatter", "correlation"]);
/** The signals of the scatter and of the x-y picture. */
export const across = signal("speed");
export const xyAcross = signal("speed");
export const xyUp = signal("climb_rate");
