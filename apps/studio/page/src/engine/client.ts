// The page's interface to the engine: typed calls that return promises, with progress and cancellation.
//
//   const studio = await startStudio();
//   const opened = await studio.open(file.name, file, { onProgress });
//   const { comparison, headline } = await studio.call("compare", { flight: opened.flight, model, times: { window: null, airborne: null } });
//
// Each flight is opened in one of several workers, which draws it and compares it. Longer calls (diagnose,
// add, ladder) run in workers of their own, so that a curve can be panned meanwhile; these workers
// themselves open the flights that they need. A worker that is cancelled or killed by a log is restarted with
// the flights that it had; nothing else is affected.

import type { Calls, Opened } from "../generated/protocol";
import type { Progress } from "./messages";
import { type Resolved, resolved } from "./numbers";
import { type Job, type Said, Slot } from "./slot";

export type { Progress } from "./messages";
export type { Resolved } from "./numbers";
export { Cancelled, Crashed, Refused } from "./slot";

export interface CallOptions {
  onProgress?: (progress: Progress) => void;
  /** Aborting it ends the work at once (the worker is terminated); the promise is rejected with `Cancelled`. */
  signal?: AbortSignal;
}

/** A file that the engine made. */
export interface MadeFile {
  name: string;
  media: string;
  bytes: Uint8Array<ArrayBuffer>;
}

type Name = keyof Calls;
type Answer<N extends Name> = Resolved<Calls[N]["answer"]>;

/** Calls that take long: they run in workers of their own. */
const LONG: ReadonlySet<Name> = new Set<Name>(["diagnose", "discover", "add", "ladder", "export", "plan"]);

/** What was opened: a file's bytes, or a flight that comes with Pylon. */
type Source = { file: string; blob: Blob } | { sample: string };

interface Flight {
  source: Source;
  slot: Slot;
}

export interface Parts {
  module: () => Promise<WebAssembly.Module | ArrayBuffer>;
  worker: () => Worker;
}

export class Studio {
  #parts: Parts;
  #module: Promise<WebAssembly.Module | ArrayBuffer> | null = null;
  #flights = new Map<string, Flight>();
  #views: Slot[] = [];
  #long: Slot[] = [];
  /** The worker that made the last diagnosis. */
  #diagnosing: Slot | null = null;
  #width: number;
  #last = 0;

  /** `width`: number of flights that are worked on at a time. */
  constructor(parts: Parts, width = Math.max(1, Math.min(4, (navigator.hardwareConcurrency || 2) - 1))) {
    this.#parts = parts;
    this.#width = width;
  }

  /**
   * Opens a log; a drop, a choice or a download gives a Blob. Rejected with `Refused` and the importer's own
   * line if the file is not a log.
   */
  open(file: string, blob: Blob, options: CallOptions = {}): Promise<{ flight: string } & Resolved<Opened>> {
    return this.#open({ file, blob }, options);
  }

  /** Opens a flight that comes with Pylon (`samples`). */
  openSample(sample: string, options: CallOptions = {}): Promise<{ flight: string } & Resolved<Opened>> {
    return this.#open({ sample }, options);
  }

  /** The log that a flight was opened from; null for one that comes with Pylon. */
  source(flight: string): Blob | null {
    const source = this.#flights.get(flight)?.source;
    return source && "blob" in source ? source.blob : null;
  }

  /** Forgets a flight. */
  close(flight: string): void {
    this.#flights.delete(flight);
    const request = JSON.stringify({ call: "close", of: { flight } });
    for (const slot of [...this.#views, ...this.#long]) {
      slot.forget(flight);
      slot.run({ request, bytes: null, flights: [], onProgress: undefined, signal: undefined, isUrgent: false }).catch(() => undefined);
    }
  }

  /** Asks the engine. */
  async call<N extends Exclude<Name, "open" | "open_sample" | "close" | "export">>(
    name: N,
    of: Calls[N]["of"],
    options: CallOptions = {},
  ): Promise<Answer<N>> {
    const said = await this.#ask(name, of, options);
    return resolved(said.answer, said.numbers) as Answer<N>;
  }

  /** Makes a file of a result, byte for byte what the command line writes. */
  async export(of: Calls["export"]["of"], options: CallOptions = {}): Promise<MadeFile> {
    const said = await this.#ask("export", of, options);
    const { name, media } = said.answer as Calls["export"]["answer"];
    return { name, media, bytes: said.bytes };
  }

  #ask(name: Name, of: object, options: CallOptions): Promise<Said> {
    const flights = named(of).filter((flight) => this.#flights.has(flight) || missing(flight));
    const job = {
      request: JSON.stringify({ call: name, of }),
      bytes: null,
      flights,
      onProgress: options.onProgress,
      signal: options.signal,
      isUrgent: !LONG.has(name),
    };
    if (LONG.has(name)) {
      // The worker of the last diagnosis still has its results, which a plan and an addition use.
      const slot = (name === "plan" || name === "add") && this.#diagnosing ? this.#diagnosing : this.#slot(this.#long);
      if (name === "diagnose") this.#diagnosing = slot;
      return slot.run(job);
    }
    const first = flights[0] === undefined ? undefined : this.#flights.get(flights[0]);
    return (first?.slot ?? this.#slot(this.#views)).run(job);
  }

  async #open(source: Source, options: CallOptions): Promise<{ flight: string } & Resolved<Opened>> {
    const flight = `flight-${++this.#last}`;
    const slot = this.#slot(this.#views);
    this.#flights.set(flight, { source, slot });
    try {
      const job = { ...opening(flight, source), onProgress: options.onProgress, signal: options.signal };
      const said = await slot.run(job);
      slot.opened(flight);
      return { flight, ...(resolved(said.answer, said.numbers) as Resolved<Opened>) };
    } catch (error) {
      this.#flights.delete(flight);
      throw error;
    }
  }

  /** The least busy of these workers, or a new one if all are busy. */
  #slot(slots: Slot[]): Slot {
    const idle = [...slots].sort((a, b) => a.load - b.load)[0];
    if (idle && (idle.load === 0 && slots === this.#long ? true : slots.length >= this.#width)) return idle;
    const slot = new Slot(
      async () => ({ worker: this.#parts.worker(), module: await (this.#module ??= this.#parts.module()) }),
      (flight) => {
        const known = this.#flights.get(flight);
        return known ? opening(flight, known.source) : null;
      },
    );
    slots.push(slot);
    return slot;
  }
}

function opening(flight: string, source: Source): Job {
  const base = { flights: [], onProgress: undefined, signal: undefined, isUrgent: true };
  if ("sample" in source) {
    return { ...base, request: JSON.stringify({ call: "open_sample", of: { flight, sample: source.sample } }), bytes: null };
  }
  const request = JSON.stringify({ call: "open", of: { flight, file: source.file } });
  return { ...base, request, bytes: () => source.blob.arrayBuffer() };
}

/** The flights that a request names. */
function named(of: object): string[] {
  const names: string[] = [];
  const add = (value: object): void => {
    if ("flight" in value && typeof value.flight === "string") names.push(value.flight);
    for (const key of ["flights", "hold_outs"] as const) {
      const list = (value as Record<string, unknown>)[key];
      if (Array.isArray(list)) names.push(...list.filter((item): item is string => typeof item === "string"));
    }
    if ("export" in value && value.export && typeof value.export === "object") add(value.export);
  };
  add(of);
  return [...new Set(names)];
}

function missing(flight: string): never {
  throw new Error(`flight '${flight}' is not open`);
}

/** Starts the engine and the workers that are embedded in this page. */
export async function startStudio(): Promise<Studio> {
  // The engine is embedded after the page's own script.
  if (document.readyState === "loading") {
    await new Promise((ready) => document.addEventListener("DOMContentLoaded", ready, { once: true }));
  }
  const text = (id: string): string => {
    const element = document.getElementById(id);
    if (!element) throw new Error(`this page has no '${id}' inside`);
    return element.textContent ?? "";
  };
  const url = URL.createObjectURL(new Blob([text("pylon-worker")], { type: "text/javascript" }));
  return new Studio({
    worker: () => new Worker(url),
    module: async () => {
      const packed = Uint8Array.from(atob(text("pylon-engine")), (letter) => letter.charCodeAt(0));
      const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
      return WebAssembly.compile(await new Response(stream).arrayBuffer());
    },
  });
}
