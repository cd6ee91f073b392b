// The layout that the user chose.

import { batch, signal } from "@preact/signals";

import { drag } from "./view";
import type { Drag } from "./view";

export type PanelKind = "scatter" | "xy" | "correlation" | "cross" | "track" | "heat";

/** Panels in the places below the curves, where there is not room for all. */
export const places = signal<ReadonlyArray<PanelKind>>(["scatter", "correlation"]);
/** The signals of the scatter and of the x-y picture. */
export const across = signal("speed");
export const xyAcross = signal("speed");
export const xyUp = signal("climb_rate");
/** What the error is correlated with. */
export const crossWith = signal("climb_rate");

/** The layout in the form in which it is kept. */
export interface Layout {
  readonly places: ReadonlyArray<PanelKind>;
  readonly across: string;
  readonly xyAcross: string;
  readonly xyUp: string;
  readonly crossWith?: string;
  readonly drag: Drag;
}

export interface NamedLayout {
  readonly name: string;
  readonly layout: Layout;
}

/** Layouts that the user has named. */
export const layouts = signal<ReadonlyArray<NamedLayout>>([]);

export function layoutNow(): Layout {
  return { places: places.value, across: across.value, xyAcross: xyAcross.value, xyUp: xyUp.value, crossWith: crossWith.value, drag: drag.value };
}

export function layOut(layout: Layout): void {
  batch(() => {
    places.value = layout.places;
    across.value = layout.across;
    xyAcross.value = layout.xyAcross;
    xyUp.value = layout.xyUp;
    // A layout kept by an older page lacks it.
    crossWith.value = layout.crossWith ?? crossWith.value;
    drag.value = layout.drag;
  });
}

/** Keeps the present layout under a name, in place of the one that had it. */
export function keepLayout(name: string): void {
  layouts.value = [...layouts.value.filter((one) => one.name !== name), { name, layout: layoutNow() }];
}

export function dropLayout(name: string): void {
  layouts.value = layouts.value.filter((one) => one.name !== name);
}
