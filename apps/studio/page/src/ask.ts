// The engine of this page, started at the first request.

import { server } from "./engine/server";
import { startStudio } from "./engine/client";
import type { CallOptions, MadeFile, Resolved, Studio } from "./engine/client";
import type { Calls } from "./generated/protocol";

type Asked = Exclude<keyof Calls, "open" | "open_sample" | "close" | "export">;

let started: Promise<Studio> | undefined;

function engine(): Promise<Studio> {
  return (started ??= startStudio());
}

/** The server of `pylon studio`; null for a page from a disk. */
export const served = server();

export async function ask<N extends Asked>(call: N, of: Calls[N]["of"], options?: CallOptions): Promise<Resolved<Calls[N]["answer"]>> {
  return (await engine()).call(call, of, options);
}

export type OpenedFlight = { flight: string } & Resolved<Calls["open"]["answer"]>;

export async function openFile(file: string, blob: Blob, options?: CallOptions): Promise<OpenedFlight> {
  return (await engine()).open(file, blob, options);
}

export async function openScenario(sample: string, options?: CallOptions): Promise<OpenedFlight> {
  return (await engine()).openSample(sample, options);
}

export async function forget(flight: string): Promise<void> {
  (await engine()).close(flight);
}

export async function made(of: Calls["export"]["of"]): Promise<MadeFile> {
  return (await engine()).export(of);
}

/** The log that a flight was opened from; null for one that comes with Pylon. */
export async function sourceOf(flight: string): Promise<Blob | null> {
  return (await engine()).source(flight);
}
