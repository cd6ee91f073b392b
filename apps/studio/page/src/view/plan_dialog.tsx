// The plan of the next flight: manoeuvres on the left, what they would show on the right, before they are
// flown.

import type { JSX } from "preact";
import { useRef } from "preact/hooks";
import { signal } from "@preact/signals";

import { clock, percent, short, sigmaText, unit, withSigma } from "../charts/number";
import type { EffectOutlook, FlightPlan, Offer, PlannedLeg, SetOutlook } from "../protocol";
import { download } from "../state/files";
import { learners } from "../state/flights";
import { beginPlan, change, changeLeg, isPlanning, offers, plan, planned, planProblem } from "../state/plan";
import { progress } from "../state/progress";
import { guides } from "../state/studio";
import { amountUnit, rangeText, wordsOf } from "./plan_words";
import { capital, sensorName } from "./words";

/** The dialog, once it exists. */
const dialog = signal<HTMLDialogElement | null>(null);

export function openPlan(): void {
  dialog.value?.showModal();
  void beginPlan();
}

/** Whether there is a flight to base a plan on. */
export const canPlan = (): boolean => learners.value.length > 0;

export function PlanDialog(): JSX.Element {
  const place = useRef<HTMLDialogElement>(null);
  const keep = (element: HTMLDialogElement | null): void => {
    place.current = element;
    dialog.value = element;
  };
  const now = plan.value;
  return (
    <dialog ref={keep} class="plan" aria-label="Plan the next flight" onClick={(event) => { if (event.target === place.current) place.current?.close(); }}>
      <div class="plan-head">
        <h2>Plan the next flight</h2>
        <p class="faint plan-status" role="status">{isPlanning.value ? `${progress.value?.text ?? "Flying it"}…` : "What it would tell, before anybody flies it"}</p>
        {isPlanning.value && progress.value?.cancel ? <button type="button" class="plain" onClick={progress.value.cancel}>Cancel</button> : null}
        <button type="button" class="plain" aria-label="Close the plan" onClick={() => place.current?.close()}>×</button>
      </div>
      {planProblem.value === null ? null : <p class="box plan-problem" role="alert">{planProblem.value}</p>}
      {now ? (
        <div class="plan-body">
          <section class="plan-flight" aria-label="What is flown">
            <Start now={now} />
            <ol class="plan-legs">{now.legs.map((leg, at) => <Leg key={at} leg={leg} at={at} count={now.legs.length} />)}</ol>
            <Choice />
            <Facts />
          </section>
          <section class={`plan-outlook ${isPlanning.value ? "old" : ""}`} aria-label="What it would tell" aria-busy={isPlanning.value}>
            <Sets />
            <Intervals />
          </section>
        </div>
      ) : null}
      <p class="acts plan-acts">
        <button type="button" class="main" disabled={planned.value === null || isPlanning.value} onClick={saveScenario}>Save as a scenario (TOML)</button>
        <button type="button" disabled={planned.value === null || isPlanning.value} onClick={printCard}>Print the flight card</button>
      </p>
    </dialog>
  );
}

function saveScenario(): void {
  if (planned.value) download("next-flight.toml", "application/toml", planned.value.scenario);
}

/** Prints the card alone: the style sheet depends on this class. */
function printCard(): void {
  const { classList } = document.documentElement;
  classList.add("prints-card");
  addEventListener("afterprint", () => classList.remove("prints-card"), { once: true });
  print();
}

interface FieldProps {
  readonly label: string;
  readonly value: number;
  readonly least: number;
  readonly most: number;
  readonly unit: string;
  readonly step?: number;
  readonly put: (value: number) => void;
}

/** A number with its unit; invalid input is ignored. */
function Field({ label, value, least, most, unit: of, step = 1, put }: FieldProps): JSX.Element {
  return (
    <span class="plan-field">
      <input
        type="number" aria-label={label} title={label} min={least} max={most} step={step} value={value}
        onInput={(event) => {
          const found = event.currentTarget.valueAsNumber;
          if (Number.isFinite(found)) put(found);
        }}
      />
      <span class="faint">{of}</span>
    </span>
  );
}

function Start({ now }: { readonly now: FlightPlan }): JSX.Element {
  return (
    <div class="plan-start">
      <label>Cruise <Field label="Cruising airspeed, m/s" value={now.speed_mps} least={8} most={350} unit="m/s" put={(speed_mps) => change({ speed_mps })} /></label>
      <label>from <Field label="Altitude at the beginning, m above mean sea level" value={now.altitude_m} least={0} most={15_000} unit="m" put={(altitude_m) => change({ altitude_m })} /></label>
      <label>first level <Field label="Straight and level for the calibration, seconds" value={now.calibration_s} least={20} most={600} unit="s" put={(calibration_s) => change({ calibration_s })} /></label>
    </div>
  );
}

function Leg({ leg, at, count }: { readonly leg: PlannedLeg; readonly at: number; readonly count: number }): JSX.Element {
  const offer = offers.value.find((one) => one.leg.manoeuvre === leg.manoeuvre);
  const words = wordsOf(leg.manoeuvre);
  const move = (by: number): void => {
    const legs = [...(plan.value?.legs ?? [])];
    const [own] = legs.splice(at, 1);
    if (own) legs.splice(at + by, 0, own);
    change({ legs });
  };
  return (
    <li class="plan-leg">
      <span class="plan-leg-name" title={words.about}>{at + 1}. {words.name}</span>
      <span class="plan-leg-acts">
        <button type="button" class="plain" aria-label={`Earlier: ${words.name}`} disabled={at === 0} onClick={() => move(-1)}>↑</button>
        <button type="button" class="plain" aria-label={`Later: ${words.name}`} disabled={at === count - 1} onClick={() => move(1)}>↓</button>
        <button type="button" class="plain" aria-label={`Leave out ${words.name}`} disabled={count === 1} onClick={() => change({ legs: (plan.value?.legs ?? []).filter((_, i) => i !== at) })}>×</button>
      </span>
      <span class="plan-leg-numbers">
        {offer && words.amount !== "" ? (
          <label>{words.amount} <Field label={`${words.name}: ${words.amount}`} value={leg.amount} least={offer.least} most={offer.most} unit={amountUnit(offer)} step={offer.unit === "g" ? 0.1 : 1} put={(amount) => changeLeg(at, { amount })} /></label>
        ) : null}
        <Field label={`${words.name}: how long each is held, seconds`} value={leg.duration_s} least={1} most={600} unit="s each" put={(duration_s) => changeLeg(at, { duration_s })} />
        <Field label={`${words.name}: how often`} value={leg.times} least={1} most={40} unit="times" put={(times) => changeLeg(at, { times: Math.round(times) })} />
      </span>
    </li>
  );
}

/** Manoeuvres that can be added, with what each would show by itself. */
function Choice(): JSX.Element {
  return (
    <ul class="plan-offers" aria-label="Manoeuvres to add">
      {offers.value.map((offer) => {
        const words = wordsOf(offer.leg.manoeuvre);
        return (
          <li key={offer.leg.manoeuvre}>
            <button type="button" class="plan-offer" onClick={() => change({ legs: [...(plan.value?.legs ?? []), offer.leg] })}>
              <span>+ {words.name}</span>
              <span class="faint number">{gainText(offer)}</span>
            </button>
          </li>
        );
      })}
    </ul>
  );
}

function gainText({ gain }: Offer): string {
  if (!gain) return "can't be flown here";
  const parts: string[] = [];
  if (gain.tells_apart !== null) parts.push(`tells apart ${percent(gain.tells_apart)}`);
  if (gain.shows > 0) parts.push(`shows ${gain.shows} more`);
  if (gain.narrows_to < 0.995) parts.push(`intervals to ${percent(gain.narrows_to)}`);
  return parts.length === 0 ? "tells nothing new" : parts.join(" · ");
}

function Facts(): JSX.Element | null {
  const found = planned.value;
  if (!found) return null;
  const { reached } = found;
  return (
    <div class="plan-facts faint">
      <p class="number">
        {clock(found.duration_s)} in all · {rangeText(reached.airspeed_mps)} m/s · {rangeText(reached.altitude_m)} m · {rangeText(reached.load_factor, 1)} g · within {(reached.distance_m / 1000).toFixed(1)} km
      </p>
      {found.remarks.map((remark) => <p key={remark}>{remark}</p>)}
    </div>
  );
}

function title(effect: string): string {
  return guides.value.get(effect)?.title ?? effect;
}

function Sets(): JSX.Element | null {
  const sets = planned.value?.outlook.sets ?? [];
  if (sets.length === 0) return null;
  return (
    <>
      <h3>Which of a set acts</h3>
      {sets.map((set) => <SetTable key={set.members.map(({ effect }) => effect).join()} set={set} />)}
    </>
  );
}

function SetTable({ set }: { readonly set: SetOutlook }): JSX.Element {
  return (
    <table class="plan-set">
      <caption>This flight resolves the set with {percent(set.resolved)}.</caption>
      <thead><tr><th scope="col">If it is…</th><th scope="col">said now</th><th scope="col">said then</th><th scope="col">left of {set.members.length}</th></tr></thead>
      <tbody>
        {set.members.map(({ effect, probability, probability_then: then, left, sigmas }) => (
          <tr key={effect} data-member={effect}>
            <th scope="row">{capital(title(effect))}</th>
            <td class="number">{percent(probability)}</td>
            <td class="number">
              <span class="plan-bar" aria-hidden="true"><span style={{ width: `${100 * (then ?? probability)}%` }} /></span>
              <b>{then === null ? "not recorded" : percent(then)}</b>
            </td>
            <td class="number" title={sigmas === null ? "" : `${short(sigmas)} sigma from the most similar of the others`}>{left === null ? "–" : left}</td>
          </tr>
        ))}
        {set.nothing === null ? null : (
          <tr data-member="nothing" title={`If none acts, the set is no longer reported with ${percent(set.cleared ?? 0)}`}>
            <th scope="row">Nothing</th>
            <td class="number">{percent(set.nothing)}</td>
            <td class="number">–</td>
            <td class="number">–</td>
          </tr>
        )}
      </tbody>
    </table>
  );
}

function Intervals(): JSX.Element {
  const effects = planned.value?.outlook.effects ?? [];
  const shown = [...effects].sort((one, other) => Number(other.is_found) - Number(one.is_found) || shrink(one) - shrink(other));
  return (
    <>
      <h3>Each effect's interval</h3>
      <table class="plan-intervals">
        <thead><tr><th scope="col">Effect</th><th scope="col">two sigma now, and then</th><th scope="col">now</th><th scope="col">then</th></tr></thead>
        <tbody>{shown.map((effect) => <Interval key={effect.effect} of={effect} />)}</tbody>
      </table>
    </>
  );
}

/**
 * Sort key: share of itself to which the interval shrinks. Effects that only the plan would show come first.
 */
function shrink({ sigma_now: now, sigma_then: then, is_seen_now, is_seen_then }: EffectOutlook): number {
  if (is_seen_then && !is_seen_now) return -1;
  return now === null || then === null ? (then === null ? 2 : 0) : then / now;
}

function Interval({ of }: { readonly of: EffectOutlook }): JSX.Element {
  const { coefficient, sigma_now: now, sigma_then: then, largest } = of;
  // The picture spans the present interval; for an effect that no flight shows, all that is physically
  // possible.
  const half = Math.min(2 * (now ?? Infinity), largest) || 1;
  const width = (sigma: number | null): number => (sigma === null ? 100 : Math.min((200 * sigma) / half, 100));
  const digits = (sigma: number | null): string => (sigma === null ? "not shown" : coefficient === null ? `± ${sigmaText(sigma)}${unit(of.unit)}` : withSigma(coefficient, sigma) + unit(of.unit));
  const sensor = of.sensor === "gps" ? "the reference" : sensorName(of.sensor).toLowerCase();
  return (
    <tr data-effect={of.effect} class={of.is_found ? "found" : ""}>
      <th scope="row" title={`On ${sensor}${of.is_planned ? "" : "; the plan has no signal of it"}`}>{capital(title(of.effect))}{of.is_seen_then && !of.is_seen_now ? <span class="plan-new"> would show</span> : null}</th>
      <td>
        <span class="plan-track" role="img" aria-label={`${width(then) < width(now) ? `shrinks to ${percent(width(then) / width(now))} of itself` : "stays as it is"}`}>
          <span class="plan-now" style={{ width: `${width(now)}%` }} />
          <span class="plan-then" style={{ width: `${Math.max(width(then), 0.8)}%` }} />
        </span>
      </td>
      <td class="number">{digits(now)}</td>
      <td class="number">{then === null ? "not shown" : `± ${sigmaText(then)}`}</td>
    </tr>
  );
}
