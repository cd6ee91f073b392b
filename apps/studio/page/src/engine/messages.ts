// Messages between the page and a worker.

/** How far a request has come. */
export interface Progress {
  /** What is being done, in plain words. */
  what: string;
  /** Steps done. */
  done: number;
  /** Total number of steps; null if it is not known beforehand. */
  of: number | null;
}

export type ToWorker =
  | { kind: "start"; module: WebAssembly.Module | ArrayBuffer }
  | { kind: "ask"; id: number; request: string; bytes: ArrayBuffer | null };

export type FromWorker =
  | { kind: "started" }
  | { kind: "progress"; id: number; progress: Progress }
  | { kind: "answer"; id: number; answer: string; numbers: ArrayBuffer; bytes: ArrayBuffer }
  | { kind: "crashed"; id: number; why: string };
