// The model and its previous states.

import { computed, signal } from "@preact/signals";

import type { ModelText } from "../protocol";

export const DEFAULT_MODEL: ModelText = { name: "model.toml", text: "" };

/** Every state of the model that Undo can go back to; the last one is the present model. */
export const models = signal<ReadonlyArray<ModelText>>([DEFAULT_MODEL]);
export const model = computed(() => models.value.at(-1) ?? DEFAULT_MODEL);
/** The model before its newest revision. */
export const before = computed(() => models.value.at(-2) ?? null);
/** Which of the two a model is; null if neither, because the model has changed since a request. */
export function standing(text: ModelText): "before" | "after" | null {
  if (before.value === null) return text.text === model.value.text ? "before" : null;
  if (text.text === model.value.text) return "after";
  return text.text === before.value.text ? "before" : null;
}

/** An answer with the model that it belongs to, because answers arrive late. */
export type Of<A> = A & { readonly asked: ModelText };

export const canUndo = computed(() => models.value.length > 1);
