// One engine: a WebAssembly module in a worker of its own. It answers one request after another; ending a
// request means ending the worker.

import type { FromWorker, ToWorker } from "./messages";

interface Exports {
  memory: WebAssembly.Memory;
  allocate(size: number): number;
  ask(request: number, requestLength: number, bytes: number, bytesLength: number): number;
}

const scope = self as unknown as {
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
  postMessage(message: FromWorker, transfer?: Transferable[]): void;
};

let engine: Exports | null = null;
let running = 0;
let told = 0;

/** Copies a part of the engine's memory. */
function copied(at: number, length: number): Uint8Array<ArrayBuffer> {
  if (!engine) throw new Error("the engine has not started");
  return new Uint8Array(engine.memory.buffer, at, length).slice();
}

/** Copies bytes into the engine's memory; the engine owns them from now on. */
function given(bytes: Uint8Array): number {
  if (!engine) throw new Error("the engine has not started");
  const at = engine.allocate(bytes.length);
  new Uint8Array(engine.memory.buffer, at, bytes.length).set(bytes);
  return at;
}

function progress(what: number, length: number, done: number, of: number): void {
  // A message costs more than a step of work.
  const now = performance.now();
  if (now - told < 50) return;
  told = now;
  const text = new TextDecoder().decode(copied(what, length));
  scope.postMessage({ kind: "progress", id: running, progress: { what: text, done, of: of > 0 ? of : null } });
}

async function start(module: WebAssembly.Module | ArrayBuffer): Promise<void> {
  const imports = { pylon: { progress } };
  const instance =
    module instanceof WebAssembly.Module
      ? await WebAssembly.instantiate(module, imports)
      : (await WebAssembly.instantiate(module, imports)).instance;
  engine = instance.exports as unknown as Exports;
}

function ask(id: number, request: string, bytes: ArrayBuffer | null): void {
  if (!engine) throw new Error("the engine has not started");
  running = id;
  const json = new TextEncoder().encode(request);
  const beside = new Uint8Array(bytes ?? new ArrayBuffer(0));
  const answer = engine.ask(given(json), json.length, given(beside), beside.length);
  const [jsonAt, jsonLength, numbersAt, numbersLength, bytesAt, bytesLength] = new Uint32Array(
    engine.memory.buffer,
    answer,
    6,
  ) as unknown as [number, number, number, number, number, number];
  const text = new TextDecoder().decode(copied(jsonAt, jsonLength));
  const numbers = copied(numbersAt, numbersLength * 8).buffer;
  const file = copied(bytesAt, bytesLength).buffer;
  scope.postMessage({ kind: "answer", id, answer: text, numbers, bytes: file }, [numbers, file]);
}

scope.onmessage = ({ data }) => {
  if (data.kind === "start") {
    start(data.module).then(
      () => scope.postMessage({ kind: "started" }),
      (error: unknown) => scope.postMessage({ kind: "crashed", id: 0, why: String(error) }),
    );
    return;
  }
  try {
    ask(data.id, data.request, data.bytes);
  } catch (error) {
    // After a panic, or without memory, the engine must not be used again.
    engine = null;
    scope.postMessage({ kind: "crashed", id: data.id, why: String(error) });
  }
};
