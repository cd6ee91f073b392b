// The model, what was found out about it, and how it changes. Everything is computed again when a flight or
// the model changes.

import { batch, computed, effect, signal } from "@preact/signals";

import { ask, served } from "../ask";
import { Cancelled } from "../engine/client";
import type { CallOptions } from "../engine/client";
import type { Added, Compared, Diagnosed, EffectGuide, Headline, Ladder, ModelFacts, ModelText, Ribbons, Times } from "../protocol";
import { flights, holdOuts, learners, notice, ready, sensor, shown } from "./flights";
import { before, model, models } from "./model";
import type { Of } from "./model";
import { progress } from "./progress";
import { messageOf, resource } from "./resource";

export const isServed = served !== null;

/** A learned effect that its own numbers contradict: the user decides. */
export const doubted = signal<Added | null>(null);
const added = signal<Headline | null>(null);

export const guides = signal<ReadonlyMap<string, EffectGuide>>(new Map());

export async function loadGuides(): Promise<void> {
  const answer = await ask("effects", {});
  guides.value = new Map(answer.map((guide) => [guide.effect, guide]));
}

const files = (list: ReadonlyArray<{ flight: string }>): string[] => list.map(({ flight }) => flight);

/** Times set by the user, of the flights that are learned from and of those held out. */
export function timesOfAll(): Record<string, Times> {
  const all = [...learners.value, ...holdOuts.value];
  return Object.fromEntries(all.map(({ flight, times }) => [flight, times]));
}

function comparisonOf(text: ModelText | null): { flight: string; model: ModelText; times: Times } | null {
  const flight = shown.value;
  if (!flight || flight.opened.overview.refused !== null || text === null) return null;
  return { flight: flight.flight, model: text, times: flight.times };
}

/** Whether the curves are drawn. Long calls wait for that: the picture comes before the numbers. */
export const isDrawn = signal(false);
/** Milliseconds that numbers wait for curves, which wait until the view is at rest. */
const AFTER_CURVES = 150;

export const compared = resource(() => comparisonOf(model.value), async (of): Promise<Compared> => await ask("compare", of), AFTER_CURVES);
async function ribbonsOf(of: { flight: string; model: ModelText; times: Times }): Promise<Of<Ribbons>> {
  return { ...(await ask("ribbons", of)), asked: of.model };
}

export const ribbons = resource(() => comparisonOf(model.value), ribbonsOf, AFTER_CURVES);
export const ribbonsBefore = resource(() => comparisonOf(before.value), ribbonsOf);

export const diagnosed = resource(
  () => diagnosisOf(model.value),
  async (of): Promise<Diagnosed> => {
    return known(of, (options) => ask("diagnose", of, options));
  },
);

/** Diagnoses of this session by their question. Undo and the model before need them again. */
const answered = new Map<string, Promise<Diagnosed>>();

async function known(of: object, act: (options: CallOptions) => Promise<Diagnosed>): Promise<Diagnosed> {
  const key = JSON.stringify(of);
  const found = answered.get(key) ?? withProgress("Looking for the cause", act, " Change a flight's use or the model to look again.");
  answered.set(key, found);
  try {
    return await found;
  } catch (error) {
    answered.delete(key);
    throw error;
  }
}

/** Does work with its progress shown and a way to cancel it. */
export async function withProgress<A>(text: string, act: (options: CallOptions) => Promise<A>, again = ""): Promise<A> {
  const ending = new AbortController();
  const cancel = (): void => ending.abort();
  const say = (share: number | null, what: string): void => { progress.value = { text: what, share, cancel }; };
  say(null, text);
  try {
    return await act({ signal: ending.signal, onProgress: ({ what, done, of }) => say(of === null ? null : done / of, what) });
  } catch (error) {
    if (error instanceof Cancelled) throw new Error(`Cancelled.${again}`);
    throw error;
  } finally {
    progress.value = null;
  }
}

/** Diagnosis of the model before its newest revision; its error beyond the reference depends on it. */
export const diagnosedBefore = resource(
  () => (before.value ? diagnosisOf(before.value) : null),
  async (of): Promise<Diagnosed> => known(of, (options) => ask("diagnose", of, options)),
);

function diagnosisOf(text: ModelText): { flights: string[]; hold_outs: string[]; model: ModelText; times: Record<string, Times> } | null {
  if (learners.value.length === 0 || !isDrawn.value) return null;
  return { flights: files(learners.value), hold_outs: files(holdOuts.value), model: text, times: timesOfAll() };
}

/** Contents of the present model. */
export const modelFacts = resource(() => ({ model: model.value }), async (of): Promise<ModelFacts> => await ask("model", of));

export interface Judged {
  readonly ladder: Ladder;
  /** Number of flights learned from: the first of each revision's flights. The others were held out. */
  readonly learned: number;
}

function ladderOf(text: ModelText): { flights: string[]; model: ModelText; times: Record<string, Times> } {
  return { flights: files([...learners.value, ...holdOuts.value]), model: text, times: timesOfAll() };
}

/** Ladders of this session by their question. An addition includes one. */
const ladders = new Map<string, Ladder>();

export const ladder = resource(
  // With the number of learners, as the same flights may be used differently.
  () => (ready.value.length === 0 || !isDrawn.value ? null : { of: ladderOf(model.value), learned: learners.value.length }),
  async ({ of, learned }): Promise<Judged> => {
    const key = JSON.stringify(of);
    const found = ladders.get(key) ?? (await ask("ladder", of));
    ladders.set(key, found);
    return { ladder: found, learned };
  },
);

interface Said {
  readonly sentence: string;
  readonly tone: Headline["tone"] | "none";
}

/** What a page with its flights inside reports until it has been computed again. */
export const saidBefore = signal<Said | null>(null);

/** The sentence at the top. */
export const headline = computed<Said>(() => {
  const said = added.value ?? diagnosed.answer.value?.headline;
  if (!said && saidBefore.value) return saidBefore.value;
  return found(said ?? compared.answer.value?.headline);
});

// It holds until this page has its own diagnosis, or knows that there is none.
effect(() => {
  if (diagnosed.answer.value || diagnosed.problem.value !== null) saidBefore.value = null;
});

function found(said: Said | undefined): Said {
  if (flights.value.length === 0) return { sentence: "Drop a flight log: see what your altitude sensors get wrong, and why.", tone: "none" };
  const flight = shown.value;
  if (flight?.opened.overview.refused) return { sentence: `This log can't be analysed: ${flight.opened.overview.refused}`, tone: "caution" };
  if (said) return said;
  const problem = diagnosed.problem.value ?? compared.problem.value;
  if (problem !== null) return { sentence: problem, tone: "caution" };
  const failed = flights.value.find((one) => one.problem !== null);
  if (!flight && failed?.problem) return { sentence: failed.problem, tone: "caution" };
  return { sentence: flight ? "Looking for the cause…" : "Reading the log…", tone: "none" };
}

// The headline of an addition holds until the flights, or what they are for, change.
effect(() => {
  void [learners.value, holdOuts.value];
  added.value = null;
});

export async function addEffect(id: string): Promise<void> {
  await learn(id, model.value);
}

/** Learns an effect of the catalogue, or one that the model defines. */
export async function learn(id: string, text: ModelText): Promise<void> {
  if (learners.value.length === 0) {
    notice.value = "No flight is to be learned from: choose “learn” for one on the left.";
    return;
  }
  const of = ladderOf(text);
  try {
    const answer = await withProgress(`Learning ${guides.value.get(id)?.title ?? id}`, (options) => ask("add", {
      effect: id,
      flights: files(learners.value),
      hold_outs: files(holdOuts.value),
      model: text,
      times: timesOfAll(),
      estimate: false,
      time_constant_s: null,
      since: null,
      date: today(),
    }, options));
    if (answer.ladder) ladders.set(JSON.stringify({ ...of, model: answer.model }), answer.ladder);
    if (answer.addition.concerns.length > 0) doubted.value = answer;
    else accept(answer);
  } catch (error) {
    notice.value = messageOf(error);
  }
}

export function accept(answer: Added): void {
  batch(() => {
    models.value = [...models.value, answer.model];
    added.value = answer.headline;
    doubted.value = null;
    const subject = guides.value.get(answer.addition.instead_of ?? answer.addition.effect)?.subject;
    if (subject !== undefined && shown.value?.opened.sensors.includes(subject)) sensor.value = subject;
  });
}

export function undo(): void {
  if (models.value.length < 2) return;
  batch(() => {
    models.value = models.value.slice(0, -1);
    added.value = null;
  });
}

/** Opens another model, from a user's file. */
export async function openModel(name: string, text: string): Promise<void> {
  try {
    await ask("model", { model: { name, text } });
    batch(() => {
      models.value = [...models.value, { name, text }];
      added.value = null;
    });
  } catch (error) {
    notice.value = messageOf(error);
  }
}

function today(): string {
  const now = new Date();
  const two = (value: number): string => String(value).padStart(2, "0");
  return `${now.getFullYear()}-${two(now.getMonth() + 1)}-${two(now.getDate())}`;
}
