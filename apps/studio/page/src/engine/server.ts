// The server of `pylon studio`, if the page came from one.

import type { ModelText, Times } from "../generated/protocol";

/** What the server was started with. */
export interface Session {
  /** Names of the files on its command line; `flight` fetches them. */
  flights: string[];
  /** The model that may be written; null if none was named. */
  model: ServedModel | null;
  /** Whether "Fly in QEMU" is offered. */
  canFly: boolean;
}

/** A model and the version of its file. */
export interface ServedModel {
  model: ModelText;
  /** Identifies the file's text; sent back when the file is written. */
  version: string;
}

/** The file was changed since it was read: by another studio, or by hand. */
export class Conflict extends Error {
  constructor(readonly theirs: ServedModel) {
    super("the model's file was changed since it was read");
  }
}

export class Server {
  #token: string;

  constructor(token: string) {
    this.#token = token;
  }

  async session(): Promise<Session> {
    return (await this.#fetch("api/session")).json() as Promise<Session>;
  }

  /** A named file, by its place in `session().flights`. */
  async flight(place: number): Promise<Blob> {
    return (await this.#fetch(`api/flight/${place}`)).blob();
  }

  /** The model's file as it is now. */
  async model(): Promise<ServedModel> {
    return (await this.#fetch("api/model")).json() as Promise<ServedModel>;
  }

  /** Replaces the model's file if it is unchanged since it was read; rejected with `Conflict` otherwise. */
  async save(text: string, version: string): Promise<ServedModel> {
    const response = await this.#fetch("api/model", { method: "PUT", body: text, headers: { "If-Match": `"${version}"` } }, [412]);
    const served = (await response.json()) as ServedModel;
    if (response.status === 412) throw new Conflict(served);
    return served;
  }

  /**
   * Flies a named flight in the emulator with a model, and returns what `pylon fly --json` prints. Takes as
   * long as the flight, or several times as long.
   */
  async fly(place: number, model: string, { window, airborne }: Times): Promise<unknown> {
    const said: string[] = [];
    if (window) said.push(`calibrate=${window.start_s}..${window.end_s}`);
    if (airborne) said.push(`airborne=${airborne.take_off_s ?? ""}..${airborne.landing_s ?? ""}`);
    const query = said.length > 0 ? `?${said.join("&")}` : "";
    return (await this.#fetch(`api/fly/${place}${query}`, { method: "POST", body: model })).json();
  }

  async #fetch(path: string, init: RequestInit = {}, allowed: number[] = []): Promise<Response> {
    const headers = { ...init.headers, Authorization: `Bearer ${this.#token}` };
    const response = await fetch(path, { ...init, headers, cache: "no-store" });
    if (!response.ok && !allowed.includes(response.status)) throw new Error((await response.text()).trim());
    return response;
  }
}

/** The server that this page came from; null for a page from a disk. */
export function server(): Server | null {
  const token = document.querySelector<HTMLMetaElement>('meta[name="pylon-token"]')?.content;
  return token ? new Server(token) : null;
}
