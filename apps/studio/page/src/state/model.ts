// The model and what it was before.

import { computed, signal } from "@preact/signals";

import type { ModelText } from "../protocol";

export const DEFAULT_MODEL: ModelText = { name: "model.toml", text: "" };

/** Every state of the model that Undo can go back to; the last one counts. */
export const models = signal<ReadonlyArray<ModelText>>([DEFAULT_MODEL]);
export const model = computed(() => models.value.at(-1) ?? DEFAULT_MODEL);
/** The model before its newest revision. */
export const before = computed(() => models.value.at(-2) ?? null);
/** Which of the two a model is; null: neither, it has changed since something was asked. */
export function standing(text: ModelText): "before" | "after" | null {
  if (before.value === null) return text.text === model.value.text ? "before" : null;
  if (text.text === model.value.text) return "after";
  return text.text === before.value.text ? "before" : null;
}

/** An answer, and the model that it is of: answers come late. */
export type Of<A> = A & { readonly asked: ModelText };

export const canUndo = computed(() => models.value.length > 1);
