// Right, below the known effects: the user's own effect by formula, and the search for laws.

import type { JSX } from "preact";
import { useState } from "preact/hooks";

import { percent, short, unit, withSigma } from "../charts/number";
import type { FormulaProblem } from "../protocol";
import { learners, shown } from "../state/flights";
import { addFormula, checked, checkProblem, defined, discover, discovered, draft, subject, take } from "../state/formula";
import type { Draft } from "../state/formula";
import { progress } from "../state/progress";
import { Cloud } from "../charts/cloud";
import { sensorName } from "./words";

export function OwnEffect(): JSX.Element | null {
  const flight = shown.value;
  if (!flight || flight.opened.overview.refused !== null) return null;
  return (
    <section class="own" aria-labelledby="own-title">
      <h2 class="pad" id="own-title">An effect of your own</h2>
      <FormulaBox />
      <Laws />
    </section>
  );
}

function change(part: Partial<Draft>): void {
  // After an edit it is no longer the law that was proposed.
  draft.value = { ...draft.value, id: "", about: "", ...part };
}

function FormulaBox(): JSX.Element {
  const { regressor } = draft.value;
  const sensors = shown.value?.opened.sensors ?? [];
  const subjects = [...sensors, "gps", ...(sensors.length > 1 ? ["every sensor"] : [])];
  const answer = checked.value;
  const problem = answer?.problem ?? null;
  return (
    <form class="formula" onSubmit={(event) => { event.preventDefault(); if (defined.value && progress.value === null) void addFormula(); }}>
      <div class="formula-head">
        <select aria-label="What it acts on" value={subject.value} onChange={(event) => change({ on: event.currentTarget.value })}>
          {subjects.map((name) => <option key={name} value={name} selected={name === subject.value}>{name === "every sensor" ? "Every sensor" : sensorName(name)}</option>)}
        </select>
        <span class="faint" aria-hidden="true">+= c ·</span>
        <Names />
      </div>
      <input
        type="text" class="formula-text" aria-label="Formula of the effect" placeholder="tas_mps^2 / (2*g) * throttle"
        spellcheck={false} autocomplete="off" autocapitalize="off"
        value={regressor} aria-invalid={problem !== null} aria-describedby="formula-said"
        onInput={(event) => change({ regressor: event.currentTarget.value })}
      />
      <div id="formula-said" aria-live="polite">
        {checkProblem.value !== null ? <p class="formula-problem">{checkProblem.value}</p> : null}
        {problem ? <Problem text={regressor} problem={problem} /> : null}
        {answer?.definition ? <Fit /> : null}
      </div>
    </form>
  );
}

/** The formula again, with the place of the problem marked. */
function Problem({ text, problem }: { readonly text: string; readonly problem: FormulaProblem }): JSX.Element {
  const { from, to, message } = problem;
  const place = text.slice(from, Math.max(to, from + 1));
  return (
    <div class="formula-problem">
      <p class="formula-echo"><span>{text.slice(0, from)}</span><mark>{place === "" ? "⌷" : place}</mark><span>{text.slice(Math.max(to, from + 1))}</span></p>
      <p>{message}</p>
    </div>
  );
}

function Fit(): JSX.Element | null {
  const found = defined.value;
  if (!found) return null;
  return (
    <div class="formula-fit">
      <Cloud x={found.x} y={found.y} slope={found.coefficient} label={`The error over the formula; a straight line explains ${percent(found.explained)} of it`} />
      <div class="effect-facts">
        <p class="number" title="By least squares over this flight, for the eye. Add learns the coefficient that counts.">c ≈ {short(found.coefficient)}{unit(found.unit)}</p>
        <p class="faint">explains {percent(found.explained)} of the error here, drawn over it</p>
        <p class="faint formula-id">{found.effect}</p>
      </div>
      <button type="submit" class="main add" disabled={progress.value !== null || learners.value.length === 0} aria-label={`Add ${found.effect}`}>Add</button>
    </div>
  );
}

const FUNCTIONS = "abs min max clamp sqrt exp ln sin cos step rate integral integral2 lowpass delay captive at_calibration at_launch";
const SIGNALS = "airspeed_mps climb_rate_mps load_factor altitude_m aoa_rad t tau launch";

/** Names that a formula may use. */
function Names(): JSX.Element {
  const [isOpen, setOpen] = useState(false);
  const columns = shown.value?.opened.columns.filter(({ values, name }) => values > 0 && name !== "time_s") ?? [];
  const put = (name: string): void => {
    const { regressor } = draft.value;
    change({ regressor: regressor === "" || /[\s(*/+^-]$/.test(regressor) ? `${regressor}${name}` : `${regressor} * ${name}` });
  };
  return (
    <>
      <button type="button" class="plain formula-names" aria-expanded={isOpen} onClick={() => setOpen(!isOpen)}>names</button>
      {isOpen ? (
        <div class="formula-list">
          <p class="faint">Recorded and known. SI units, as the names say.</p>
          <p>{[...SIGNALS.split(" "), ...columns.map(({ name }) => name)].map((name) => <button key={name} type="button" class="plain" onClick={() => put(name)}>{name}</button>)}</p>
          <p class="faint">Functions: {FUNCTIONS.split(" ").join(", ")}. Constants: g, pi, R, Omega. A number with a unit: 2.5[m/s].</p>
        </div>
      ) : null}
    </>
  );
}

function Laws(): JSX.Element {
  const found = discovered.value;
  const laws = found?.discovery.laws ?? [];
  return (
    <div class="laws">
      <p class="acts">
        <button type="button" disabled={progress.value !== null || learners.value.length === 0} onClick={() => void discover()}>Discover a law…</button>
        <span class="faint">searches what is recorded for one that explains the rest</span>
      </p>
      {found?.why_none ? <p class="box">{found.why_none}</p> : null}
      {laws.length > 0 ? (
        <ol class="law-list">
          {laws.map((law, at) => (
            <li key={law.regressor} class={draft.value.regressor === law.regressor ? "law taken" : "law"}>
              <button type="button" class="plain law-text" aria-label={`Make ${law.regressor} the formula`} onClick={() => take(at)}>{law.regressor}</button>
              <p class="number faint">
                {sensorName(law.on)} · {percent(law.probability)}{law.probability_with_equals > law.probability + 0.005 ? ` (${percent(law.probability_with_equals)} with its equals)` : ""} · {law.size_m.toFixed(1)} m · {withSigma(law.coefficient, law.sigma)}{unit(law.unit)}
              </p>
              <div class="effect-bar law-bar" aria-hidden="true"><span style={{ width: `${100 * law.probability}%` }} /></div>
              {law.advice ? <p class="faint">{law.advice}</p> : null}
            </li>
          ))}
        </ol>
      ) : null}
      {laws.length > 0 && found ? <p class="faint pad">None of them: {percent(found.discovery.none)}. {found.discovery.scored.toLocaleString("en")} laws were looked at. A click draws one, and makes it the formula.</p> : null}
    </div>
  );
}
