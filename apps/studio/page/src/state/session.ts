// The session as it outlives a reload: which logs are open and what for, the model's states, the layout.

import { batch, effect } from "@preact/signals";

import type { ModelText, Window } from "../protocol";
import { flights, reopen, sensor, show, shownId } from "./flights";
import type { Flight, Use } from "./flights";
import { across, places, xyAcross, xyUp } from "./layout";
import type { PanelKind } from "./layout";
import { keepSession, keptLog, keptSession } from "./kept";
import { DEFAULT_MODEL, models } from "./model";
import { drag } from "./view";
import type { Drag } from "./view";

/** Another number, and what an older page kept is not read. */
const VERSION = 1;

interface Kept {
  readonly version: number;
  readonly flights: ReadonlyArray<Pick<Flight, "id" | "file" | "sample" | "use" | "window">>;
  readonly models: ReadonlyArray<ModelText>;
  readonly shown: string | null;
  readonly sensor: string | null;
  readonly layout: { readonly places: ReadonlyArray<PanelKind>; readonly across: string; readonly xyAcross: string; readonly xyUp: string; readonly drag: Drag };
}

function now(): Kept {
  return {
    version: VERSION,
    flights: flights.value.filter(({ opened }) => opened !== null).map(({ id, file, sample, use, window }) => ({ id, file, sample, use, window })),
    models: models.value,
    shown: shownId.value,
    sensor: sensor.value,
    layout: { places: places.value, across: across.value, xyAcross: xyAcross.value, xyUp: xyUp.value, drag: drag.value },
  };
}

export function keepOnChange(): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  effect(() => {
    const session = now();
    clearTimeout(timer);
    // A page that may keep nothing works all the same.
    timer = setTimeout(() => void keepSession(session).catch(() => undefined), 150);
  });
}

export async function restore(): Promise<void> {
  const found = await keptSession().catch(() => null);
  if (!isKept(found)) return;
  batch(() => {
    models.value = found.models.length > 0 ? found.models : [DEFAULT_MODEL];
    places.value = found.layout.places;
    across.value = found.layout.across;
    xyAcross.value = found.layout.xyAcross;
    xyUp.value = found.layout.xyUp;
    drag.value = found.layout.drag;
    sensor.value = found.sensor;
  });
  await Promise.all(found.flights.map(async (flight) => {
    const blob = flight.sample === null ? await keptLog(flight.id).catch(() => null) : null;
    await reopen({ ...flight, flight: "", opened: null, problem: null }, blob);
  }));
  if (found.shown !== null) {
    const wanted = found.sensor;
    show(found.shown);
    if (wanted !== null) sensor.value = wanted;
  }
}

function isRecord(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null;
}

function isText(value: unknown): value is string {
  return typeof value === "string";
}

function isUse(value: unknown): value is Use {
  return value === "learn" || value === "hold_out" || value === "off";
}

function isWindow(value: unknown): value is Window | null {
  return value === null || (isRecord(value) && typeof value["start_s"] === "number" && typeof value["end_s"] === "number");
}

function isPanel(value: unknown): value is PanelKind {
  return value === "scatter" || value === "xy" || value === "correlation" || value === "track" || value === "heat";
}

function isDrag(value: unknown): value is Drag {
  return value === "select" || value === "pan" || value === "zoom";
}

function isKept(value: unknown): value is Kept {
  if (!isRecord(value) || value["version"] !== VERSION) return false;
  const { flights: kept, models: states, layout, shown, sensor: chosen } = value;
  const areFlights = Array.isArray(kept) && kept.every((one: unknown) =>
    isRecord(one) && isText(one["id"]) && isText(one["file"]) && (one["sample"] === null || isText(one["sample"])) && isUse(one["use"]) && isWindow(one["window"]));
  const areModels = Array.isArray(states) && states.every((one: unknown) => isRecord(one) && isText(one["name"]) && isText(one["text"]));
  const isLayout = isRecord(layout) && Array.isArray(layout["places"]) && layout["places"].every(isPanel)
    && isText(layout["across"]) && isText(layout["xyAcross"]) && isText(layout["xyUp"]) && isDrag(layout["drag"]);
  return areFlights && areModels && isLayout && (shown === null || isText(shown)) && (chosen === null || isText(chosen));
}
