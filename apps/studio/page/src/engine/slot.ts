// A worker and its queue. It does one job at a time, and is restarted after one that was cancelled or
// killed it.

import type { FromWorker, Progress, ToWorker } from "./messages";

/** The caller ended the work. */
export class Cancelled extends Error {
  constructor() {
    super("cancelled");
  }
}

/** The engine refused to answer; the message is its reason, one line for the user. */
export class Refused extends Error {}

/** The engine crashed: a defect of Pylon, or not enough memory. Other workers continue. */
export class Crashed extends Error {}

export interface Said {
  answer: unknown;
  numbers: Float64Array;
  bytes: Uint8Array<ArrayBuffer>;
}

export interface Job {
  request: string;
  /** Read when the job's turn comes. */
  bytes: (() => Promise<ArrayBuffer>) | null;
  /** Flights that must be open; those that are not are opened first. */
  flights: string[];
  onProgress: ((progress: Progress) => void) | undefined;
  signal: AbortSignal | undefined;
  /** Runs before waiting jobs that are not urgent. */
  isUrgent: boolean;
}

interface Waiting {
  job: Job;
  resolve: (said: Said) => void;
  reject: (error: Error) => void;
}

/** Message for the user that the engine crashed. */
function brokeOff(why: string): string {
  return `The engine crashed: not enough memory, or a defect in Pylon (${why}). It was restarted; nothing else is affected.`;
}

export class Slot {
  #make: () => Promise<{ worker: Worker; module: WebAssembly.Module | ArrayBuffer }>;
  /** The job that opens a flight. */
  #opening: (flight: string) => Job | null;
  #worker: Worker | null = null;
  #queue: Waiting[] = [];
  #isBusy = false;
  #opened = new Set<string>();
  #lastId = 0;
  #interrupt: ((error: Error) => void) | null = null;

  constructor(
    make: () => Promise<{ worker: Worker; module: WebAssembly.Module | ArrayBuffer }>,
    opening: (flight: string) => Job | null,
  ) {
    this.#make = make;
    this.#opening = opening;
  }

  /** Number of its jobs, waiting or running. */
  get load(): number {
    return this.#queue.length + (this.#isBusy ? 1 : 0);
  }

  /** Runs a job when its turn comes. */
  run(job: Job): Promise<Said> {
    if (job.signal?.aborted) return Promise.reject(new Cancelled());
    return new Promise((resolve, reject) => {
      const waiting = { job, resolve, reject };
      const at = job.isUrgent ? this.#queue.findIndex((other) => !other.job.isUrgent) : -1;
      if (at < 0) this.#queue.push(waiting);
      else this.#queue.splice(at, 0, waiting);
      job.signal?.addEventListener("abort", () => this.#cancel(waiting), { once: true });
      void this.#next();
    });
  }

  /** Marks a flight as not open, so that it is opened again when a job needs it. */
  forget(flight: string): void {
    this.#opened.delete(flight);
  }

  #cancel(waiting: Waiting): void {
    const at = this.#queue.indexOf(waiting);
    if (at >= 0) {
      this.#queue.splice(at, 1);
      waiting.reject(new Cancelled());
    } else if (this.#running === waiting) {
      this.#end(new Cancelled());
    }
  }

  #running: Waiting | null = null;

  /** Terminates the worker and its job. */
  #end(error: Error): void {
    this.#worker?.terminate();
    this.#worker = null;
    this.#opened.clear();
    const interrupt = this.#interrupt;
    this.#interrupt = null;
    interrupt?.(error);
  }

  async #next(): Promise<void> {
    if (this.#isBusy) return;
    const waiting = this.#queue.shift();
    if (!waiting) return;
    this.#isBusy = true;
    this.#running = waiting;
    try {
      for (const flight of waiting.job.flights.filter((name) => !this.#opened.has(name))) {
        const opening = this.#opening(flight);
        if (!opening) throw new Refused(`flight '${flight}' is not open`);
        await this.#ask({ ...opening, onProgress: waiting.job.onProgress });
        this.#opened.add(flight);
      }
      waiting.resolve(await this.#ask(waiting.job));
    } catch (error) {
      waiting.reject(error instanceof Error ? error : new Error(String(error)));
    } finally {
      this.#running = null;
      this.#isBusy = false;
      void this.#next();
    }
  }

  /** Marks a flight as open: its opening was a job of its own. */
  opened(flight: string): void {
    this.#opened.add(flight);
  }

  async #ask(job: Job): Promise<Said> {
    const bytes = job.bytes ? await job.bytes() : null;
    const worker = this.#worker ?? (await this.#start());
    if (job.signal?.aborted) throw new Cancelled();
    const id = ++this.#lastId;
    return new Promise<Said>((resolve, reject) => {
      this.#interrupt = reject;
      worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
        if (data.kind === "progress" && data.id === id) {
          job.onProgress?.(data.progress);
        } else if (data.kind === "answer" && data.id === id) {
          this.#interrupt = null;
          const answer = JSON.parse(data.answer) as { ok: unknown } | { error: string };
          if ("error" in answer) reject(new Refused(answer.error));
          else resolve({ answer: answer.ok, numbers: new Float64Array(data.numbers), bytes: new Uint8Array(data.bytes) });
        } else if (data.kind === "crashed") {
          this.#end(new Crashed(brokeOff(data.why)));
        }
      };
      worker.onerror = (event) => this.#end(new Crashed(brokeOff(event.message || "the worker ended")));
      const message: ToWorker = { kind: "ask", id, request: job.request, bytes };
      worker.postMessage(message, bytes ? [bytes] : []);
    });
  }

  async #start(): Promise<Worker> {
    const { worker, module } = await this.#make();
    await new Promise<void>((resolve, reject) => {
      this.#interrupt = (error) => {
        worker.terminate();
        reject(error);
      };
      worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
        if (data.kind === "started") resolve();
        else if (data.kind === "crashed") reject(new Crashed(data.why));
      };
      worker.onerror = (event) => reject(new Crashed(event.message || "the worker could not be started"));
      const message: ToWorker = { kind: "start", module };
      worker.postMessage(message);
    });
    this.#interrupt = null;
    this.#worker = worker;
    return worker;
  }
}
