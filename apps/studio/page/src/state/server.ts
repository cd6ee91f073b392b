// What only `pylon studio` can do, which serves the page beside the user's files.

import { served } from "../ask";
import { Conflict } from "../engine/server";
import type { ServedModel } from "../engine/server";
import { models } from "./model";
import { flights, notice, openLog } from "./flights";
import { messageOf } from "./resource";

let model: ServedModel | null = null;

/** Writes the model's file; says where it went. */
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

/** Opens what the server was started with, unless it is open already. */
export async function openServed(): Promise<void> {
  const from = served;
  if (!from) return;
  try {
    const session = await from.session();
    model = session.model;
    if (session.model) models.value = [session.model.model];
    const open = new Set(flights.value.map(({ file }) => file));
    const missing = session.flights.map((file, place) => ({ file, place })).filter(({ file }) => !open.has(file));
    await Promise.all(missing.map(async ({ file, place }) => openLog(file, await from.flight(place))));
  } catch (error) {
    notice.value = messageOf(error);
  }
}
