// Right: the effects, ranked by how many metres of the error they explain.

import type { JSX } from "preact";

import { metres, percent, short, unit, withSigma } from "../charts/number";
import type { CandidateFacts as Candidate, EffectGuide, SensorDiagnosis } from "../protocol";
import { sensor, shown } from "../state/flights";
import { whatIf } from "../state/pictures";
import { accept, addEffect, diagnosed, doubted, guides, modelFacts } from "../state/studio";
import { progress } from "../state/progress";
import { openPlan } from "./plan_dialog";
import { OwnEffect } from "./own_effect";
import { isNarrow } from "./screen";
import { capital, columnName, plain, sensorName } from "./words";

interface Row {
  readonly candidate: Candidate;
  readonly guide: EffectGuide | undefined;
  readonly probability: number | null;
  /** Found to be missing, alone or as one of a set. */
  readonly isSuspect: boolean;
}

export function Effects(): JSX.Element {
  const found = diagnosed.answer.value?.diagnosis;
  const name = sensor.value;
  const here = name === null ? undefined : found?.sensors[name];
  return (
    <aside class="side effects" aria-label="Effects" data-tour="effects">
      <Doubted />
      {diagnosed.problem.value !== null ? <p class="box">{diagnosed.problem.value}</p> : null}
      {found && here && name !== null ? <Found name={name} here={here} rows={rowsOf(name)} /> : <Waiting />}
      {found && here ? null : <><InModel /><OwnEffect /></>}
      {found && found.untested.length > 0 ? <Untested /> : null}
      {isNarrow.value && found ? <p class="pad"><button type="button" disabled={progress.value !== null} onClick={openPlan}>Plan the next flight…</button></p> : null}
    </aside>
  );
}

function Waiting(): JSX.Element | null {
  if (diagnosed.problem.value !== null) return null;
  if (shown.value && shown.value.opened.overview.refused !== null) return <p class="faint pad">Without an analysis no effect can be ranked.</p>;
  return <p class="faint pad">{progress.value ? `${progress.value.text}…` : "Effects are ranked here once a flight is open."}</p>;
}

function rowsOf(name: string): Row[] {
  const sensors = diagnosed.answer.value?.diagnosis.sensors ?? {};
  // An effect on the reference appears in every sensor's error.
  const subjects = ["gps", name].map((subject) => sensors[subject]).filter((one) => one !== undefined);
  const rows = subjects.flatMap((one) => one.candidates.map((candidate): Row => ({
    candidate,
    guide: guides.value.get(candidate.effect),
    probability: candidate.probability ?? probabilityOf(one, candidate.effect),
    isSuspect: one.missing.includes(candidate.effect) || one.indistinguishable.some((set) => set.includes(candidate.effect)),
  })));
  return rows.sort((one, other) => Number(other.isSuspect) - Number(one.isSuspect) || size(other) - size(one));
}

function size({ candidate }: Row): number {
  return candidate.size_m;
}

function probabilityOf(here: SensorDiagnosis, effect: string): number | null {
  for (const [at, set] of here.indistinguishable.entries()) {
    const place = set.indexOf(effect);
    if (place >= 0) return here.probabilities[at]?.[place] ?? null;
  }
  return null;
}

interface FoundProps {
  readonly name: string;
  readonly here: SensorDiagnosis;
  readonly rows: ReadonlyArray<Row>;
}

function Found({ name, here, rows }: FoundProps): JSX.Element {
  const suspects = rows.filter(({ isSuspect }) => isSuspect);
  const others = rows.filter(({ isSuspect }) => !isSuspect);
  const most = Math.max(...rows.map(size), 1e-9);
  return (
    <>
      <h2 class="pad">{sensorName(name)}: {plain(here.verdict)}</h2>
      {/^(One of|Either) /.test(here.advice) ? null : here.indistinguishable.map((set, at) => <SetBox key={set.join()} set={set} mayBeNothing={typeof here.nothing[at] === "number"} />)}
      {here.advice ? (
        <p class="box advice"><b>Next</b> {inWords(here.advice)}{" "}
          <button type="button" class="plain advice-plan" disabled={progress.value !== null} onClick={openPlan}>Plan the next flight…</button>
        </p>
      ) : null}
      <ul class="effect-list">
        {suspects.map((row) => <EffectRow key={row.candidate.effect} row={row} most={most} />)}
      </ul>
      <InModel />
      <OwnEffect />
      {others.length > 0 ? (
        <details class="others" open={!isNarrow.value}>
          <summary>Tested, no evidence: {others.length}</summary>
          <ul class="effect-list">
            {others.map((row) => <EffectRow key={row.candidate.effect} row={row} most={most} />)}
          </ul>
        </details>
      ) : null}
    </>
  );
}

/** Replaces the ids of effects in the engine's advice by titles; removes the command that adds one. */
function inWords(advice: string): string {
  return advice.replace(/ \(pylon add [^)]*\)/g, "").replace(/\b(?:baro|imu|gps)\.[a-z_]+/g, title);
}

function title(effect: string): string {
  return guides.value.get(effect)?.title ?? effect;
}

function SetBox({ set, mayBeNothing }: { readonly set: ReadonlyArray<string>; readonly mayBeNothing: boolean }): JSX.Element {
  return (
    <p class="box set">
      <b>{mayBeNothing ? "One of these may act, or nothing" : "One of these acts; these flights cannot show which"}:</b> {set.map(title).join(", ")}.
    </p>
  );
}

function EffectRow({ row, most }: { readonly row: Row; readonly most: number }): JSX.Element {
  const { candidate, guide, probability, isSuspect } = row;
  const { effect, coefficient, sigma } = candidate;
  const isOn = whatIf.value.includes(effect);
  const toggle = (): void => {
    whatIf.value = isOn ? whatIf.value.filter((one) => one !== effect) : [...whatIf.value, effect];
  };
  const label = guide?.title ?? effect;
  return (
    <li class={`effect ${isSuspect ? "suspect" : ""}`} data-effect={effect}>
      <div class="effect-head">
        <button type="button" class="switch" role="switch" aria-checked={isOn} aria-label={`What if: draw ${label} over the error`} title="What if? Draws its prediction over the error" onClick={toggle}><span /></button>
        <span class="effect-title" title={guide?.what ?? effect}>{capital(label)}</span>
        <b class="number">{metres(candidate.size_m)}</b>
      </div>
      <div class="effect-bar" aria-hidden="true"><span style={{ width: `${(100 * size(row)) / most}%` }} /></div>
      <div class="effect-body">
        <div class="effect-facts">
          <PlausibleRange guide={guide} coefficient={coefficient} sigma={sigma} />
          <p class="number faint" title={probability === null ? "" : "probability of being the one that acts"}>
            {withSigma(coefficient, sigma)}{unit(candidate.unit)}
            {probability === null ? "" : ` · ${percent(probability)}`}
            {probability === null && isSuspect ? ` · ${chance(candidate.p_value)}` : ""}
          </p>
        </div>
        <button type="button" class={isSuspect ? "main add" : "add"} aria-label={`Add ${label}`} disabled={progress.value !== null} onClick={() => void addEffect(effect)}>Add</button>
      </div>
    </li>
  );
}

function chance(p: number): string {
  return p >= 0.995 ? "may be chance" : `chance ${p < 0.001 ? "< 0.1 %" : percent(p)}`;
}

interface RangeProps {
  readonly guide: EffectGuide | undefined;
  readonly coefficient: number;
  readonly sigma: number;
}

/**
 * The plausible range is the middle of the track; the estimate is a dot with its sigma, at the edge if it is
 * beyond the track.
 */
function PlausibleRange({ guide, coefficient, sigma }: RangeProps): JSX.Element | null {
  if (!guide) return null;
  const [low = 0, high = 0] = guide.plausible;
  const margin = 0.25 * (high - low);
  const place = (value: number): number => Math.min(Math.max((value - low + margin) / (high - low + 2 * margin), 0.01), 0.99) * 100;
  const [left, right] = [place(coefficient - sigma), place(coefficient + sigma)];
  const isInside = coefficient >= low && coefficient <= high;
  const text = `plausible ${short(low)} to ${short(high)}${unit(guide.unit)}; estimate ${isInside ? "within" : "beyond"}`;
  return (
    <div class="range" role="img" aria-label={text} title={`${text}. ${guide.source}`}>
      <span class="range-plausible" style={{ left: `${place(low)}%`, width: `${place(high) - place(low)}%` }} />
      {low < 0 && high > 0 ? <span class="range-zero" style={{ left: `${place(0)}%` }} /> : null}
      <span class="range-sigma" style={{ left: `${left}%`, width: `${Math.max(right - left, 0.5)}%` }} />
      <span class={`range-estimate ${isInside ? "" : "beyond"}`} style={{ left: `${place(coefficient)}%` }} />
    </div>
  );
}

function InModel(): JSX.Element | null {
  const effects = modelFacts.answer.value?.effects ?? [];
  if (effects.length === 0) return null;
  return (
    <section class="in-model">
      <h2 class="pad">In the model</h2>
      <ul class="effect-list">
        {effects.map((term) => (
          <li key={term.effect} class="effect kept">
            <div class="effect-head"><span class="tick" aria-hidden="true">✓</span><span class="effect-title" title={term.effect}>{capital(title(term.effect))}</span></div>
            <p class="number faint">{withSigma(term.coefficient, term.sigma)}{unit(term.unit)}{term.learned_from ? `, from ${term.learned_from}` : ""}</p>
          </li>
        ))}
      </ul>
    </section>
  );
}

function Untested(): JSX.Element {
  const list = diagnosed.answer.value?.diagnosis.untested ?? [];
  return (
    <details class="others">
      <summary>Not tested: {list.length}</summary>
      <ul class="untested">
        {list.map(({ effect, needs, reason }) => <li key={effect}><b>{capital(title(effect))}</b>: {reason ?? `needs ${needs.map(columnName).join(", ")}`}</li>)}
      </ul>
    </details>
  );
}

function Doubted(): JSX.Element | null {
  const answer = doubted.value;
  if (!answer) return null;
  return (
    <div class="box doubted" role="alertdialog" aria-label="Its own numbers speak against this effect">
      <p><b>{capital(title(answer.addition.effect))}: its own numbers speak against it.</b></p>
      <ul>{answer.addition.concerns.map((text) => <li key={text}>{text}</li>)}</ul>
      <p class="acts">
        <button type="button" onClick={() => { doubted.value = null; }}>Leave it out</button>
        <button type="button" onClick={() => accept(answer)}>Add it anyway</button>
      </p>
    </div>
  );
}
