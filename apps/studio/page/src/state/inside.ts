// A page with its flights inside: made by Export, opened by its recipient. It has the files' names, never
// their folders.

import { sourceOf } from "../ask";
import type { ModelText, Times } from "../protocol";
import { flights, sensor, shownId } from "./flights";
import type { Use } from "./flights";
import { layoutNow, layouts } from "./layout";
import type { Layout, NamedLayout } from "./layout";
import { models } from "./model";
import { OFFERED, unpacked } from "./offered";

/** Id of the element that holds it. */
const PLACE = "pylon-inside";

export interface InsideFlight {
  readonly file: string;
  /** The scenario that it was simulated by; null for a log. */
  readonly sample: string | null;
  readonly use: Use;
  readonly times: Times;
  /** The log: gzip, base64; null for a scenario. */
  readonly log: string | null;
  readonly isShown: boolean;
}

/** The sentence that was found, to be read before anything is computed again. */
export interface InsideSentence {
  readonly sentence: string;
  readonly tone: "good" | "caution" | "bad" | "none";
}

export interface Inside {
  readonly flights: ReadonlyArray<InsideFlight>;
  readonly models: ReadonlyArray<ModelText>;
  readonly sensor: string | null;
  readonly layout: Layout;
  readonly layouts: ReadonlyArray<NamedLayout>;
  readonly said: InsideSentence;
}

/** What is inside this page; null if nothing is. This page's own script wrote it. */
export function inside(): Inside | null {
  const text = document.getElementById(PLACE)?.textContent ?? "";
  return text === "" ? null : (JSON.parse(text) as Inside);
}

/** The original log of a flight. */
export async function logOf(flight: InsideFlight): Promise<Blob> {
  return unpacked(flight.log ?? "");
}

async function packed(blob: Blob): Promise<string> {
  const bytes = new Uint8Array(await new Response(blob.stream().pipeThrough(new CompressionStream("gzip"))).arrayBuffer());
  let text = "";
  // A number of arguments that every JavaScript engine accepts.
  for (let at = 0; at < bytes.length; at += 0x8000) text += String.fromCharCode(...bytes.subarray(at, at + 0x8000));
  return btoa(text);
}

/** This page with what is open in it, as one file. */
export async function pageWithFlights(said: InsideSentence): Promise<Blob> {
  const open = flights.value.filter(({ opened }) => opened !== null);
  const session: Inside = {
    flights: await Promise.all(open.map(async ({ id, flight, file, sample, use, times }) => {
      const blob = await sourceOf(flight);
      return { file, sample, use, times, log: blob ? await packed(blob) : null, isShown: id === shownId.value };
    })),
    models: models.value,
    sensor: sensor.value,
    layout: layoutNow(),
    layouts: layouts.value,
    said,
  };
  const root = document.documentElement.cloneNode(true);
  if (!(root instanceof HTMLElement)) throw new Error("this page can't be copied");
  root.removeAttribute("class");
  root.querySelector(`#${PLACE}`)?.remove();
  root.querySelector(`#${OFFERED}`)?.remove();
  root.querySelector("#studio")?.replaceChildren();
  // Remove what the script has put outside its own element.
  for (const child of root.querySelectorAll("body > :not(#studio, script)")) child.remove();
  // Remove what lets a page that `pylon studio` serves call its server: it is not for the recipient.
  root.querySelector('meta[name="pylon-token"]')?.remove();
  const policy = root.querySelector('meta[http-equiv="Content-Security-Policy"]');
  policy?.setAttribute("content", (policy.getAttribute("content") ?? "").replace(/connect-src [^;]*/, "connect-src 'none'"));
  // Placed before the page's own script, which reads it at the start. No text in it can end its element.
  const place = document.createElement("script");
  place.id = PLACE;
  place.type = "text/plain";
  place.textContent = JSON.stringify(session).replaceAll("<", "\\u003c");
  root.querySelector("#studio")?.after("\n", place);
  return new Blob(["<!doctype html>\n", root.outerHTML, "\n"], { type: "text/html" });
}
