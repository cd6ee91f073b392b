// What works only under `pylon studio`, which serves the page together with the user's files.

import { computed, signal } from "@preact/signals";

import { served } from "../ask";
import { Conflict } from "../engine/server";
import type { ServedModel } from "../engine/server";
import { FOUND, flights, notice, openLog, shown } from "./flights";
import { model as current, models } from "./model";
import { progress } from "./progress";
import { messageOf } from "./resource";

let model: ServedModel | null = null;
const named = signal<ReadonlyArray<string>>([]);
const offersFlying = signal(false);

/** Index of the shown flight among those that the server was started with; -1 if it is none of them. */
const place = computed(() => (shown.value && shown.value.sample === null ? named.value.indexOf(shown.value.file) : -1));
/** Whether the shown flight can be flown by the firmware in the emulator. */
export const canFly = computed(() => offersFlying.value && place.value >= 0);

/** Writes the model's file; returns a message for the user. */
export async function writeModel(text: string): Promise<string> {
  if (!served || !model) throw new Error("`pylon studio` was started without --model: export the model instead.");
  try {
    model = await served.save(text, model.version);
    return `${model.model.name} is written.`;
  } catch (error) {
    if (!(error instanceof Conflict)) throw error;
    const { theirs } = error;
    model = theirs;
    models.value = [...models.value, theirs.model];
    return `${theirs.model.name} was changed by another program since it was read. That revision is shown now; Undo goes back to yours, and Save then writes it.`;
  }
}

/** Flies the shown flight with the model through drivers and firmware in the emulator. */
export async function fly(): Promise<void> {
  if (!served || place.value < 0) return;
  progress.value = { text: "Flying in QEMU", share: null };
  try {
    notice.value = flown(await served.fly(place.value, current.value.text, shown.value?.times ?? FOUND));
  } catch (error) {
    notice.value = messageOf(error);
  } finally {
    progress.value = null;
  }
}

function flown(report: unknown): string {
  const said = typeof report === "object" && report !== null ? report : {};
  const ticks = "ticks" in said && typeof said.ticks === "number" ? said.ticks : 0;
  if ("bit_for_bit" in said && said.bit_for_bit === true) return `Flown in QEMU: ${ticks} ticks of the flight computer's image, each bit for bit the host's.`;
  const differ = "ticks_that_differ" in said && typeof said.ticks_that_differ === "number" ? said.ticks_that_differ : 0;
  return `The flight computer's image in QEMU differs from the host in ${differ} of ${ticks} ticks: run pylon fly for details.`;
}

/** Opens what the server was started with, unless it is open already. */
export async function openServed(): Promise<void> {
  const from = served;
  if (!from) return;
  try {
    const session = await from.session();
    model = session.model;
    offersFlying.value = session.canFly;
    named.value = session.flights;
    if (session.model) models.value = [session.model.model];
    const open = new Set(flights.value.map(({ file }) => file));
    const missing = session.flights.map((file, at) => ({ file, at })).filter(({ file }) => !open.has(file));
    await Promise.all(missing.map(async ({ file, at }) => openLog(file, await from.flight(at))));
  } catch (error) {
    notice.value = messageOf(error);
  }
}
