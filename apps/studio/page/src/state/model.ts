// The model and what it was before.

import { computed, signal } from "@preact/signals";

import type { ModelText } from "../protocol";

export const DEFAULT_MODEL: ModelText = { name: "model.toml", text: "" };

/** Every state of the model that Undo can go back to; the last one counts. */
export const models = signal<ReadonlyArray<ModelText>>([DEFAULT_MODEL]);
export const model = computed(() => models.value.at(-1) ?? DEFAULT_MODEL);
/** The model before its newest revision. */
export const before = computed(() => models.value.at(-2) ?? null);
export const canUndo = computed(() => models.value.length > 1);
