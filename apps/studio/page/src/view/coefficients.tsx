// An effect's coefficients from several flights of a vehicle, and which of them do not fit the others.

import type { JSX } from "preact";

import { unit, withSigma } from "../charts/number";
import { diagnosed, guides } from "../state/studio";
import { capital } from "./words";

interface Dot {
  readonly file: string;
  readonly value: number;
  readonly sigma: number;
  readonly isOdd: boolean;
}

export function Coefficients({ vehicle }: { readonly vehicle: string }): JSX.Element | null {
  const batch = diagnosed.answer.value?.batch;
  const found = batch?.by_vehicle.find((one) => one.vehicle === vehicle);
  if (!batch || !found || found.effects.length === 0) return null;
  return (
    <ul class="coefficients" aria-label={`Coefficients of ${vehicle}, flight by flight`}>
      {found.effects.map((effect) => {
        const odd = new Set(effect.outliers.map(({ file }) => file));
        const dots = batch.by_flight.flatMap((flight): Dot[] => {
          const one = flight.vehicle === vehicle ? flight.coefficients[effect.effect] : undefined;
          return one ? [{ file: flight.file, value: one.value, sigma: one.sigma, isOdd: odd.has(flight.file) }] : [];
        });
        const title = capital(guides.value.get(effect.effect)?.title ?? effect.effect);
        return (
          <li key={effect.effect}>
            <p>{title}: <span class="number">{withSigma(effect.mean, effect.sigma)}{unit(effect.unit)}</span></p>
            <Strip dots={dots} mean={effect.mean} unit={unit(effect.unit)} />
            {odd.size > 0 ? <p class="odd">Does not fit the others: {[...odd].join(", ")}</p> : null}
          </li>
        );
      })}
    </ul>
  );
}

function Strip({ dots, mean, unit: of }: { readonly dots: ReadonlyArray<Dot>; readonly mean: number; readonly unit: string }): JSX.Element {
  const low = Math.min(mean, ...dots.map(({ value, sigma }) => value - sigma));
  const high = Math.max(mean, ...dots.map(({ value, sigma }) => value + sigma));
  const place = (value: number): string => `${4 + (92 * (value - low)) / Math.max(high - low, 1e-12)}%`;
  const spoken = dots.map(({ file, value, sigma, isOdd }) => `${file} ${withSigma(value, sigma)}${of}${isOdd ? ", does not belong" : ""}`).join("; ");
  return (
    <div class="strip" role="img" aria-label={spoken}>
      <span class="strip-mean" style={{ left: place(mean) }} />
      {dots.map(({ file, value, sigma, isOdd }) => (
        <span key={file} class={`strip-dot ${isOdd ? "odd" : ""}`} style={{ left: place(value) }} title={`${file}: ${withSigma(value, sigma)}${of}`} />
      ))}
    </div>
  );
}
