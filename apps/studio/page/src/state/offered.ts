// Real flights that the page offers: logs that `cargo xtask site` found when it built the page (offered.json
// lists them and their owners).

import { openLog } from "./flights";

/** Id of the element that holds them. */
export const OFFERED = "pylon-offered";

export interface Offered {
  readonly file: string;
  readonly title: string;
  readonly about: string;
  /** Whose log it is, and its licence. */
  readonly from: string;
  /** The log: gzip, base64. */
  readonly log: string;
}

/** The flights in this page; none if it was built without them. */
export function offered(): ReadonlyArray<Offered> {
  const text = document.getElementById(OFFERED)?.textContent ?? "";
  return text === "" ? [] : (JSON.parse(text) as Offered[]);
}

export async function openOffered({ file, log }: Offered): Promise<void> {
  await openLog(file, await unpacked(log));
}

/** The original log, from gzip in base64. */
export async function unpacked(log: string): Promise<Blob> {
  const packed = Uint8Array.from(atob(log), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).blob();
}
