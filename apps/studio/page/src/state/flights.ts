// The open flights, and the one that is shown.

import { batch, computed, signal } from "@preact/signals";

import { ask, forget, openFile, openScenario } from "../ask";
import type { OpenedFlight } from "../ask";
import type { Opened, Times } from "../protocol";
import { dropLog, keepLog } from "./kept";
import { messageOf } from "./resource";
import { brush, lookAt } from "./view";
import type { Span } from "./view";

/** What a flight is for: the coefficients are learned from it, they are judged by it, or it is only looked at. */
export type Use = "learn" | "hold_out" | "off";

export interface Flight {
  readonly id: string;
  /** The engine's name for it; empty until it is open. */
  readonly flight: string;
  readonly file: string;
  /** The name of the scenario that it was simulated by; null for a log. */
  readonly sample: string | null;
  readonly use: Use;
  /** Calibration window and time in the air, set by the user; null: as Pylon finds them. */
  readonly times: Times;
  readonly opened: Opened | null;
  /** Why it could not be opened: the importer's own line. */
  readonly problem: string | null;
}

/** Times as Pylon finds them. */
export const FOUND: Times = { window: null, airborne: null };

export const flights = signal<ReadonlyArray<Flight>>([]);
export const shownId = signal<string | null>(null);
export const sensor = signal<string | null>(null);
/** A message for the user, who may dismiss it. */
export const notice = signal<string | null>(null);

export const shown = computed(() => {
  const found = flights.value.find(({ id }) => id === shownId.value);
  return found?.opened ? { ...found, opened: found.opened } : null;
});

export const ready = computed(() => flights.value.filter(({ opened }) => opened !== null && opened.overview.refused === null));
export const learners = computed(() => ready.value.filter(({ use }) => use === "learn"));
export const holdOuts = computed(() => ready.value.filter(({ use }) => use === "hold_out"));

export interface Vehicle {
  readonly name: string;
  readonly flights: ReadonlyArray<Flight>;
}

/** Vehicles, in the order in which their first flight was opened. */
export const vehicles = computed<ReadonlyArray<Vehicle>>(() => {
  const groups = new Map<string, Flight[]>();
  for (const flight of flights.value) {
    const name = flight.opened ? flight.opened.vehicle || "Unnamed vehicle" : flight.problem ? "Not opened" : "Opening";
    groups.set(name, [...(groups.get(name) ?? []), flight]);
  }
  return [...groups].map(([name, members]) => ({ name, flights: members }));
});

let count = 0;

function newId(): string {
  count += 1;
  return `flight-${Date.now().toString(36)}-${count}`;
}

function change(id: string, to: Partial<Flight>): void {
  flights.value = flights.value.map((flight) => (flight.id === id ? { ...flight, ...to } : flight));
}

/** Opens a log; the first good one is shown. */
export async function openLog(file: string, blob: Blob): Promise<void> {
  const id = newId();
  add({ id, flight: "", file, sample: null, use: "learn", times: FOUND, opened: null, problem: null });
  const isOpen = await opening(id, () => openFile(file, blob));
  if (!isOpen) return;
  const isKept = await keepLog(id, blob).then(() => true, () => false);
  if (!isKept) notice.value = `This browser has no room to keep ${file}: after a reload it has to be opened again.`;
}

export async function openSample(sample: string): Promise<void> {
  const id = newId();
  add({ id, flight: "", file: `${sample}.csv`, sample, use: "learn", times: FOUND, opened: null, problem: null });
  await opening(id, () => openScenario(sample));
}

/** Opens a flight again, as it was before a reload. */
export async function reopen(kept: Flight, blob: Blob | null): Promise<void> {
  add({ ...kept, flight: "", opened: null, problem: null });
  await opening(kept.id, async () => {
    if (kept.sample === null && !blob) throw new Error(`${kept.file}: this browser did not keep the log; open it again`);
    const opened = kept.sample !== null ? await openScenario(kept.sample) : await openFile(kept.file, blob ?? new Blob());
    if (kept.times.window === null && kept.times.airborne === null) return opened;
    return { flight: opened.flight, ...(await ask("flight", { flight: opened.flight, times: kept.times })) };
  });
}

function add(flight: Flight): void {
  flights.value = [...flights.value, flight];
}

async function opening(id: string, act: () => Promise<OpenedFlight>): Promise<boolean> {
  try {
    const { flight, ...opened } = await act();
    batch(() => {
      change(id, { flight, opened, problem: null });
      if (shown.value === null) show(id);
    });
    return true;
  } catch (error) {
    change(id, { problem: messageOf(error) });
    return false;
  }
}

export function show(id: string): void {
  const opened = flights.value.find((flight) => flight.id === id)?.opened;
  if (!opened) return;
  batch(() => {
    shownId.value = id;
    lookAt({ from: opened.first_s, to: opened.last_s }, usedOf(opened));
    if (sensor.value === null || !opened.sensors.includes(sensor.value)) {
      sensor.value = opened.sensors.includes("baro") ? "baro" : (opened.sensors[0] ?? null);
    }
  });
}

/** The span of a flight without the unused parts at both ends. */
function usedOf({ first_s, last_s, overview }: Opened): Span {
  let [from, to] = [first_s, last_s];
  for (const { from_s, to_s } of overview.unused) {
    if (from_s <= from) from = Math.max(from, to_s);
    if (to_s >= to) to = Math.min(to, from_s);
  }
  return from < to ? { from, to } : { from: first_s, to: last_s };
}

export function setUse(id: string, use: Use): void {
  change(id, { use });
}

/** Changes the calibration window or the time in the air; everything is computed again. */
export async function setTimes(id: string, part: Partial<Times>): Promise<void> {
  try {
    const found = flights.value.find((one) => one.id === id);
    if (!found) return;
    const times = { ...found.times, ...part };
    change(id, { times, opened: await ask("flight", { flight: found.flight, times }) });
  } catch (error) {
    notice.value = messageOf(error);
  }
}

export function close(id: string): void {
  const name = flights.value.find((flight) => flight.id === id)?.flight ?? "";
  batch(() => {
    flights.value = flights.value.filter((flight) => flight.id !== id);
    if (shownId.value !== id) return;
    shownId.value = null;
    brush.value = null;
    const next = flights.value.find(({ opened }) => opened !== null);
    if (next) show(next.id);
  });
  void dropLog(id);
  if (name !== "") void forget(name);
}
