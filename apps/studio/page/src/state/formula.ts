// The user's own effect, defined by a formula, and the search for laws.

import { batch, computed, effect, signal } from "@preact/signals";

import { ask } from "../ask";
import type { Defined, Discovered, FormulaChecked, ModelText } from "../protocol";
import { holdOuts, learners, notice, sensor, shown } from "./flights";
import { model } from "./model";
import { curves, errorSignalOf, ownPrediction, question, REST, settling } from "./pictures";
import { messageOf, resource } from "./resource";
import { learn, timesOfAll, withProgress } from "./studio";

export interface Draft {
  /** What it acts on: a sensor, `gps` or `every sensor`; empty for the sensor that is shown. */
  readonly on: string;
  readonly regressor: string;
  /** Its id; empty if the engine is to make one. */
  readonly id: string;
  readonly about: string;
}

const EMPTY: Draft = { on: "", regressor: "", id: "", about: "" };

export const draft = signal<Draft>(EMPTY);
export const subject = computed(() => draft.value.on || sensor.value || "baro");

function checking(wanted: Draft): { model: ModelText; flight: string; regressor: string } & Parameters<typeof ask<"formula">>[1] | null {
  const flight = shown.value;
  if (!flight || flight.opened.overview.refused !== null || wanted.regressor.trim() === "" || sensor.value === null) return null;
  const on = wanted.on || sensor.value;
  const of = flight.opened.sensors.includes(on) ? on : sensor.value;
  return {
    model: model.value, id: wanted.id === "" ? null : wanted.id, on, regressor: wanted.regressor, largest: null, about: wanted.about,
    flight: flight.flight, times: flight.times, error: errorSignalOf(of), from_s: settling.value?.to ?? null,
  };
}

/** The formula, checked while it is typed. */
const answered = resource(() => checking(draft.value), async (of): Promise<{ of: string; found: FormulaChecked }> => ({ of: of.regressor, found: await ask("formula", of) }), 250);
/** Why it could not be checked. */
export const checkProblem = answered.problem;
/** Result of the check of the present formula; null while it is typed. */
export const checked = computed<FormulaChecked | null>(() => (answered.answer.value?.of === draft.value.regressor ? answered.answer.value.found : null));
/** Definition of the formula, if it can be used. */
export const defined = computed<Defined | null>(() => checked.value?.definition ?? null);

export const ownCurve = resource(
  () => {
    const found = defined.value;
    if (!found) return null;
    return question(found.model, () => [{ signal: "effect", of: { effect: found.effect, coefficient: found.coefficient, time_constant_s: null, since: null } }]);
  },
  curves,
  REST,
);

effect(() => { ownPrediction.value = defined.value ? ownCurve.answer.value : null; });

/** Adds the definition and the revision that learns it. */
export async function addFormula(): Promise<void> {
  const found = defined.value;
  if (!found) return;
  pending = found.effect;
  await learn(found.effect, found.model);
}

/**
 * The effect that is to be added. Its formula stays in the box until the model has it, because the user may
 * be asked first.
 */
let pending: string | null = null;

effect(() => {
  const { text } = model.value;
  if (pending === null || !text.includes(`"${pending}"`)) return;
  pending = null;
  forgetDraft();
});

function forgetDraft(): void {
  draft.value = EMPTY;
}

export const discovered = signal<Discovered | null>(null);

/** Laws that were found hold only for the flights and the model of the search. */
effect(() => {
  void [learners.value, holdOuts.value, model.value];
  discovered.value = null;
});

export async function discover(): Promise<void> {
  const names = (list: ReadonlyArray<{ flight: string }>): string[] => list.map(({ flight }) => flight);
  try {
    const found = await withProgress("Searching for laws", (options) => ask("discover", {
      flights: names(learners.value), hold_outs: names(holdOuts.value), model: model.value, times: timesOfAll(),
    }, options));
    discovered.value = found;
  } catch (error) {
    notice.value = messageOf(error);
  }
}

/** Makes a law that was found the formula. */
export function take(at: number): void {
  const found = discovered.value;
  const law = found?.discovery.laws[at];
  const id = found?.ids[at];
  if (!law || id === undefined) return;
  batch(() => {
    draft.value = { on: law.on, regressor: law.regressor, id, about: `a law that pylon discover proposed, with a probability of ${law.probability.toFixed(2)}` };
    if (shown.value?.opened.sensors.includes(law.on)) sensor.value = law.on;
  });
}

