// What takes a while, and how it is ended.

import { signal } from "@preact/signals";

export interface Progress {
  readonly text: string;
  /** From 0 to 1; null: nobody knows. */
  readonly share: number | null;
  /** Ends it; without, it can't be ended. */
  readonly cancel?: () => void;
}

export const progress = signal<Progress | null>(null);
