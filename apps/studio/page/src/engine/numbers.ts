// Arrays of an answer, which come beside its JSON.

import type { Numbers } from "../generated/protocol";

/** An answer with its arrays in place: every `Numbers` is a Float64Array. NaN means no value. */
export type Resolved<T> = T extends Numbers
  ? Float64Array
  : T extends readonly (infer Item)[]
    ? Resolved<Item>[]
    : T extends object
      ? { [Key in keyof T]: Resolved<T[Key]> }
      : T;

function isNumbers(value: object): value is Numbers {
  const keys = Object.keys(value);
  return keys.length === 2 && "start" in value && "length" in value && !Array.isArray(value);
}

/** Puts an answer's arrays in place. */
export function resolved<T>(answer: T, numbers: Float64Array): Resolved<T> {
  const walk = (value: unknown): unknown => {
    if (value === null || typeof value !== "object") return value;
    if (Array.isArray(value)) return value.map(walk);
    if (isNumbers(value)) return numbers.subarray(value.start, value.start + value.length);
    return Object.fromEntries(Object.entries(value).map(([key, inner]) => [key, walk(inner)]));
  };
  return walk(answer) as Resolved<T>;
}
