// The flights that are open, and the one that is looked at.

import { batch, computed, signal } from "@preact/signals";

import { ask } from "../ask";
import type { Opened, Window } from "../protocol";
import { dropLog, keepLog } from "./kept";
import { messageOf } from "./resource";
import { brush, lookAt } from "./view";

/** What a flight is for: the coefficients are learned from it, they are judged by it, or it is only looked at. */
export type Use = "learn" | "hold_out" | "off";

export interface Flight {
  readonly id: string;
  readonly file: string;
  /** The name of the scenario that it was simulated by; null for a log. */
  readonly sample: string | null;
  readonly use: Use;
  /** Where to calibrate; null: where Pylon would. */
  readonly window: Window | null;
  readonly opened: Opened | null;
  /** Why it could not be opened: the importer's own line. */
  readonly problem: string | null;
}

export const flights = signal<ReadonlyArray<Flight>>([]);
export const shownId = signal<string | null>(null);
export const sensor = signal<string | null>(null);
/** What the user is to know, and may send away. */
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

/** In the order in which their first flight was opened. */
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

/** Opens a log's bytes; the first good one is shown. */
export async function openLog(file: string, bytes: Uint8Array): Promise<void> {
  const id = newId();
  const isKept = keepLog(id, bytes.slice()).then(() => true, () => false);
  add({ id, file, sample: null, use: "learn", window: null, opened: null, problem: null });
  await opening(id, async () => (await ask("open", { flight: id, file }, { bytes })).answer);
  if (!(await isKept)) notice.value = `This browser has no room to keep ${file}: after a reload it has to be opened again.`;
}

export async function openSample(sample: string): Promise<void> {
  const id = newId();
  add({ id, file: `${sample} (simulated)`, sample, use: "learn", window: null, opened: null, problem: null });
  await opening(id, async () => (await ask("open_sample", { flight: id, sample })).answer);
}

/** As it was before a reload. */
export async function reopen(kept: Flight, bytes: Uint8Array | null): Promise<void> {
  add({ ...kept, opened: null, problem: null });
  await opening(kept.id, async () => {
    if (kept.sample !== null) {
      await ask("open_sample", { flight: kept.id, sample: kept.sample });
    } else if (bytes) {
      await ask("open", { flight: kept.id, file: kept.file }, { bytes });
    } else {
      throw new Error(`${kept.file}: this browser did not keep the log; open it again`);
    }
    return (await ask("flight", { flight: kept.id, window: kept.window })).answer;
  });
}

function add(flight: Flight): void {
  flights.value = [...flights.value, flight];
}

async function opening(id: string, act: () => Promise<Opened>): Promise<void> {
  try {
    const opened = await act();
    batch(() => {
      change(id, { opened, problem: null });
      if (shown.value === null || shownId.value === null) show(id);
    });
  } catch (error) {
    change(id, { problem: messageOf(error) });
    void dropLog(id);
  }
}

export function show(id: string): void {
  const opened = flights.value.find((flight) => flight.id === id)?.opened;
  if (!opened) return;
  batch(() => {
    shownId.value = id;
    lookAt({ from: opened.first_s, to: opened.last_s });
    if (sensor.value === null || !opened.sensors.includes(sensor.value)) {
      sensor.value = opened.sensors.includes("baro") ? "baro" : (opened.sensors[0] ?? null);
    }
  });
}

export function setUse(id: string, use: Use): void {
  change(id, { use });
}

/** Calibrates elsewhere; null: where Pylon would. */
export async function setWindow(id: string, window: Window | null): Promise<void> {
  try {
    const { answer } = await ask("flight", { flight: id, window });
    change(id, { window, opened: answer });
  } catch (error) {
    notice.value = messageOf(error);
  }
}

export function close(id: string): void {
  const wasOpen = flights.value.find((flight) => flight.id === id)?.opened;
  batch(() => {
    flights.value = flights.value.filter((flight) => flight.id !== id);
    if (shownId.value !== id) return;
    shownId.value = null;
    brush.value = null;
    const next = flights.value.find(({ opened }) => opened !== null);
    if (next) show(next.id);
  });
  void dropLog(id);
  if (wasOpen) void ask("close", { flight: id });
}
