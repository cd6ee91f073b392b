// The model and its revisions, with undo: the page's own state. Every request gives the engine the text.

import type { ModelText } from "../generated/protocol";

export interface Step {
  model: ModelText;
  /** What made it: "opened", or the effect that was added. */
  why: string;
}

/** A model's states, oldest first; undo goes back, a new state discards what was undone. */
export class ModelHistory {
  #steps: Step[];
  #at = 0;

  constructor(model: ModelText) {
    this.#steps = [{ model, why: "opened" }];
  }

  /** The present model. */
  get now(): ModelText {
    return this.#step(this.#at).model;
  }

  /** The model before its last change; null where it has none. */
  get before(): ModelText | null {
    return this.#at > 0 ? this.#step(this.#at - 1).model : null;
  }

  /** The states up to the present one. */
  get steps(): readonly Step[] {
    return this.#steps.slice(0, this.#at + 1);
  }

  get canUndo(): boolean {
    return this.#at > 0;
  }

  get canRedo(): boolean {
    return this.#at + 1 < this.#steps.length;
  }

  push(model: ModelText, why: string): void {
    this.#steps = [...this.steps, { model, why }];
    this.#at += 1;
  }

  undo(): void {
    if (this.canUndo) this.#at -= 1;
  }

  redo(): void {
    if (this.canRedo) this.#at += 1;
  }

  #step(at: number): Step {
    const step = this.#steps[at];
    if (!step) throw new RangeError("no such state of the model");
    return step;
  }
}
