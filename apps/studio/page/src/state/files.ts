// Files in and out of the page.

import { made } from "../ask";
import { pageWithFlights } from "./inside";
import { writeModel } from "./server";
import { flights, holdOuts, learners, notice, openLog, shown } from "./flights";
import { messageOf } from "./resource";
import { model } from "./model";
import { headline, isServed, openModel, timesOfAll } from "./studio";

export type ExportKind = "model" | "page" | "flight" | "compare" | "diagnose" | "ladder";

export function download(name: string, media: string, bytes: BlobPart): void {
  const address = URL.createObjectURL(new Blob([bytes], { type: media }));
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/** Saves the model: to disk through the server, else as a download. */
export async function saveModel(): Promise<void> {
  if (isServed) {
    try {
      notice.value = await writeModel(model.value.text);
    } catch (error) {
      notice.value = messageOf(error);
    }
    return;
  }
  download(model.value.name, "application/toml", model.value.text);
}

export async function exportFile(kind: ExportKind): Promise<void> {
  if (kind === "model") {
    download(model.value.name, "application/toml", model.value.text);
    return;
  }
  if (kind === "page") {
    try {
      download("flights.html", "text/html", await pageWithFlights(headline.value));
    } catch (error) {
      notice.value = messageOf(error);
    }
    return;
  }
  const flight = shown.value;
  const ids = (list: ReadonlyArray<{ flight: string }>): string[] => list.map((one) => one.flight);
  try {
    if (!flight) throw new Error("No flight is open to export.");
    const all = [...learners.value, ...holdOuts.value];
    const file = await made({
      export:
        kind === "flight" ? { what: "flight", flight: flight.flight }
        : kind === "compare" ? { what: "compare", flight: flight.flight, model: model.value, times: flight.times }
        : kind === "diagnose" ? { what: "diagnose", flights: ids(learners.value), hold_outs: ids(holdOuts.value), model: model.value, times: timesOfAll() }
        : { what: "ladder", flights: ids(all), model: model.value, times: timesOfAll() },
    });
    download(file.name, file.media, file.bytes);
  } catch (error) {
    notice.value = messageOf(error);
  }
}

/** Opens logs, all at once; a `.toml` file is a model. */
export async function openFiles(list: Iterable<File>): Promise<void> {
  await Promise.all([...list].map(async (file) => {
    try {
      if (file.name.toLowerCase().endsWith(".toml")) await openModel(file.name, await file.text());
      else await openLog(file.name, file);
    } catch (error) {
      notice.value = `${file.name}: ${messageOf(error)}`;
    }
  }));
}

/** Lets the user choose files. */
export function chooseFiles(): void {
  const input = document.createElement("input");
  input.type = "file";
  input.multiple = true;
  input.addEventListener("change", () => void openFiles(input.files ?? []));
  input.click();
}

export const isEmpty = (): boolean => flights.value.length === 0;
