// The session that survives a reload: the open logs and their uses, the model's states, the layout.

import { batch, effect } from "@preact/signals";

import type { Airborne, ModelText, Times, Window } from "../protocol";
import { flights, reopen, sensor, show, shownId } from "./flights";
import type { Flight, Use } from "./flights";
import { layOut, layoutNow, layouts } from "./layout";
import type { Layout, NamedLayout, PanelKind } from "./layout";
import { logOf } from "./inside";
import type { Inside } from "./inside";
import { keepSession, keptLog, keptSession } from "./kept";
import { DEFAULT_MODEL, models } from "./model";
import type { Drag } from "./view";

/** Change this number, and what an older page kept is no longer read. */
const VERSION = 2;

interface Kept {
  readonly version: number;
  readonly flights: ReadonlyArray<Pick<Flight, "id" | "file" | "sample" | "use" | "times">>;
  readonly models: ReadonlyArray<ModelText>;
  readonly shown: string | null;
  readonly sensor: string | null;
  readonly layout: Layout;
  readonly layouts?: ReadonlyArray<NamedLayout>;
}

function now(): Kept {
  return {
    version: VERSION,
    flights: flights.value.filter(({ opened }) => opened !== null).map(({ id, file, sample, use, times }) => ({ id, file, sample, use, times })),
    models: models.value,
    shown: shownId.value,
    sensor: sensor.value,
    layout: layoutNow(),
    layouts: layouts.value,
  };
}

export function keepOnChange(): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  effect(() => {
    const session = now();
    clearTimeout(timer);
    // A page that may not keep anything still works.
    timer = setTimeout(() => void keepSession(session).catch(() => undefined), 150);
  });
}

export async function restore(): Promise<void> {
  const found = await keptSession().catch(() => null);
  if (!isKept(found)) return;
  batch(() => {
    models.value = found.models.length > 0 ? found.models : [DEFAULT_MODEL];
    layOut(found.layout);
    layouts.value = found.layouts ?? [];
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

/** Opens what is inside the page. It is neither kept in this browser nor mixed with what was kept before. */
export async function openInside(found: Inside): Promise<void> {
  batch(() => {
    models.value = found.models.length > 0 ? found.models : [DEFAULT_MODEL];
    layOut(found.layout);
    layouts.value = found.layouts;
    sensor.value = found.sensor;
  });
  const opened = found.flights.map(async (flight, at): Promise<string> => {
    const id = `inside-${at}`;
    const { file, sample, use, times } = flight;
    const blob = flight.log === null ? null : await logOf(flight);
    await reopen({ id, flight: "", file, sample, use, times, opened: null, problem: null }, blob);
    return id;
  });
  await Promise.all(opened);
  const shown = found.flights.findIndex(({ isShown }) => isShown);
  if (shown >= 0) show(`inside-${shown}`);
  if (found.sensor !== null) sensor.value = found.sensor;
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

function isMoment(value: unknown): value is number | null {
  return value === null || typeof value === "number";
}

function isAirborne(value: unknown): value is Airborne | null {
  return value === null || (isRecord(value) && isMoment(value["take_off_s"]) && isMoment(value["landing_s"]));
}

function isTimes(value: unknown): value is Times {
  return isRecord(value) && isWindow(value["window"]) && isAirborne(value["airborne"]);
}

function isPanel(value: unknown): value is PanelKind {
  return value === "scatter" || value === "xy" || value === "correlation" || value === "cross" || value === "track" || value === "heat";
}

function isDrag(value: unknown): value is Drag {
  return value === "select" || value === "pan" || value === "zoom";
}

function isLayout(value: unknown): value is Layout {
  return isRecord(value) && Array.isArray(value["places"]) && value["places"].every(isPanel) && isText(value["across"]) && isText(value["xyAcross"])
    && isText(value["xyUp"]) && (value["crossWith"] === undefined || isText(value["crossWith"])) && isDrag(value["drag"]);
}

function isKept(value: unknown): value is Kept {
  if (!isRecord(value) || value["version"] !== VERSION) return false;
  const { flights: kept, models: states, layout, shown, sensor: chosen } = value;
  const areFlights = Array.isArray(kept) && kept.every((one: unknown) =>
    isRecord(one) && isText(one["id"]) && isText(one["file"]) && (one["sample"] === null || isText(one["sample"])) && isUse(one["use"]) && isTimes(one["times"]));
  const areModels = Array.isArray(states) && states.every((one: unknown) => isRecord(one) && isText(one["name"]) && isText(one["text"]));
  const named = value["layouts"];
  const areLayouts = named === undefined || (Array.isArray(named) && named.every((one: unknown) => isRecord(one) && isText(one["name"]) && isLayout(one["layout"])));
  return areFlights && areModels && isLayout(layout) && areLayouts && (shown === null || isText(shown)) && (chosen === null || isText(chosen));
}
