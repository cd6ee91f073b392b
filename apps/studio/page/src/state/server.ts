// What only `pylon studio` can do, which serves the page beside the user's files.

import type { ModelText } from "../protocol";

export async function writeModel(_: ModelText): Promise<string> {
  throw new Error("This page is not served by `pylon studio`.");
}

export async function flyInEmulator(): Promise<void> {
  throw new Error("This page is not served by `pylon studio`.");
}

export async function openServed(): Promise<void> {}
