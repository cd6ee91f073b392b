// node ask.mjs MODULE FLIGHT REQUEST...: opens the flight (as "flight"), sends the module each request, and
// writes to standard output what comes beside the last answer, or that answer if nothing does.
import { readFileSync, writeSync } from "node:fs";
import { basename } from "node:path";

const [module, flight, ...requests] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(readFileSync(module), { pylon: { progress() {} } });
const { memory, allocate, ask } = instance.exports;
const given = (bytes) => {
  const at = allocate(bytes.length);
  new Uint8Array(memory.buffer, at, bytes.length).set(bytes);
  return [at, bytes.length];
};
const answered = (request, bytes) => {
  const places = ask(...given(new TextEncoder().encode(request)), ...given(bytes));
  const [json, jsonLength, , , file, fileLength] = new Uint32Array(memory.buffer, places, 6);
  const part = (at, length) => new Uint8Array(memory.buffer, at, length).slice();
  return fileLength > 0 ? part(file, fileLength) : part(json, jsonLength);
};
const opening = JSON.stringify({ call: "open", of: { flight: "flight", file: basename(flight) } });
let bytes = answered(opening, readFileSync(flight));
for (const request of requests) bytes = answered(request, new Uint8Array());
for (let done = 0; done < bytes.length; ) done += writeSync(1, bytes, done);
