// An answer that is kept up to date with its question.

import { effect, signal } from "@preact/signals";
import type { ReadonlySignal } from "@preact/signals";

export interface Resource<A> {
  /** The newest answer; the one before stays until it arrives. Null without a question or an answer to it. */
  readonly answer: ReadonlySignal<A | null>;
  readonly problem: ReadonlySignal<string | null>;
}

/**
 * Asks again whenever the question changes, at the earliest after `rest` milliseconds without a change.
 * One question is under way at a time: of those that come meanwhile only the last is asked.
 */
export function resource<Q, A>(question: () => Q | null, ask: (question: Q) => Promise<A>, rest = 0): Resource<A> {
  const answer = signal<A | null>(null);
  const problem = signal<string | null>(null);
  let asked = "";
  let waiting: Q | null = null;
  let isUnderWay = false;
  let timer: ReturnType<typeof setTimeout> | undefined;

  const next = async (): Promise<void> => {
    if (isUnderWay || waiting === null) return;
    const current = waiting;
    waiting = null;
    isUnderWay = true;
    const key = asked;
    try {
      const found = await ask(current);
      if (key === asked) {
        answer.value = found;
        problem.value = null;
      }
    } catch (error) {
      if (key === asked) {
        answer.value = null;
        problem.value = messageOf(error);
      }
    } finally {
      isUnderWay = false;
      void next();
    }
  };

  effect(() => {
    const current = question();
    const key = JSON.stringify(current);
    if (key === asked) return;
    asked = key;
    clearTimeout(timer);
    waiting = current;
    if (current === null) {
      answer.value = null;
      problem.value = null;
      return;
    }
    timer = setTimeout(() => void next(), rest);
  });
  return { answer, problem };
}

export function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
