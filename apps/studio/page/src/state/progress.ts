// Progress of long work, and how to cancel it.

import { signal } from "@preact/signals";

export interface Progress {
  readonly text: string;
  /** From 0 to 1; null if unknown. */
  readonly share: number | null;
  /** Cancels the work; absent if it can't be cancelled. */
  readonly cancel?: () => void;
}

export const progress = signal<Progress | null>(null);
