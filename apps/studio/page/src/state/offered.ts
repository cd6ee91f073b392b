// Real flights that the page offers: logs that `cargo xtask site` found where it was built (offered.json says which and whose).

import { openLog } from "./flights";

/** The element that has them. */
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

/** Those in this page; none where it was built without. */
export function offered(): ReadonlyArray<Offered> {
  const text = document.getElementById(OFFERED)?.textContent ?? "";
  return text === "" ? [] : (JSON.parse(text) as Offered[]);
}

export async function openOffered({ file, log }: Offered): Promise<void> {
  await openLog(file, await unpacked(log));
}

/** A log as it was, of gzip in base64. */
export async function unpacked(log: string): Promise<Blob> {
  const packed = Uint8Array.from(atob(log), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).blob();
}
