// The next flight: its plan, and what it would show.

import { computed, effect, signal } from "@preact/signals";

import { ask } from "../ask";
import type { FlightPlan, ModelText, Offer, Planned, PlannedLeg, Times } from "../protocol";
import { holdOuts, learners } from "./flights";
import { model } from "./model";
import { messageOf } from "./resource";
import { timesOfAll, withProgress } from "./studio";

/** The plan as the user has changed it; null before Pylon has suggested one. */
export const plan = signal<FlightPlan | null>(null);
/** The engine's answer for the last plan that could be flown. */
export const planned = signal<Planned | null>(null);
/** Manoeuvres to choose from, best first. */
export const offers = signal<ReadonlyArray<Offer>>([]);
/** Why the plan as it stands cannot be flown. */
export const planProblem = signal<string | null>(null);
/** Whether what is shown still belongs to the plan before. */
export const isPlanning = signal(false);

interface Basis {
  readonly flights: string[];
  readonly hold_outs: string[];
  readonly model: ModelText;
  readonly times: Record<string, Times>;
}

const basis = computed<Basis>(() => ({
  flights: learners.value.map(({ flight }) => flight),
  hold_outs: holdOuts.value.map(({ flight }) => flight),
  model: model.value,
  times: timesOfAll(),
}));

/** Flights, model and times that the plan was made for, as JSON. */
let madeFor = "";

// A plan is discarded when its flights, model or times change.
effect(() => {
  if (JSON.stringify(basis.value) === madeFor) return;
  madeFor = "";
  planned.value = null;
  plan.value = null;
  offers.value = [];
  planProblem.value = null;
});

/** Asks for a suggestion, unless there is a plan for these flights and this model. */
export async function beginPlan(): Promise<void> {
  if (plan.value !== null || isPlanning.value) return;
  const on = basis.value;
  madeFor = JSON.stringify(on);
  await flying(async () => {
    const answer = await withProgress("Planning the next flight", (options) => ask("plan", { ...on, plan: null }, options));
    offers.value = answer.offers;
    plan.value = answer.plan;
    return answer;
  });
}

let timer: ReturnType<typeof setTimeout> | undefined;
let newest = 0;
/** Milliseconds without a change before a plan is flown. */
const REST = 250;

/** Changes the plan, which is flown once the user pauses. */
export function change(part: Partial<FlightPlan>): void {
  if (!plan.value) return;
  plan.value = { ...plan.value, ...part };
  isPlanning.value = true;
  clearTimeout(timer);
  timer = setTimeout(() => void flying(async () => ask("plan", { ...basis.value, plan: plan.value })), REST);
}

export function changeLeg(at: number, part: Partial<PlannedLeg>): void {
  const legs = plan.value?.legs ?? [];
  change({ legs: legs.map((leg, i) => (i === at ? { ...leg, ...part } : leg)) });
}

async function flying(act: () => Promise<Planned>): Promise<void> {
  newest += 1;
  const own = newest;
  isPlanning.value = true;
  try {
    const answer = await act();
    if (own !== newest) return;
    planned.value = answer;
    planProblem.value = null;
  } catch (error) {
    if (own === newest) planProblem.value = messageOf(error);
  } finally {
    if (own === newest) isPlanning.value = false;
  }
}
