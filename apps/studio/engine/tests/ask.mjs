// node ask.mjs MODULE FLIGHT QUESTION: what the module answers, on standard output.
import { readFileSync, writeSync } from "node:fs";

const [module, flight, question] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(readFileSync(module), {});
const { put, answer, get } = instance.exports;
for (const byte of readFileSync(flight)) put(byte);
const bytes = Uint8Array.from({ length: answer(Number(question)) }, (_, at) => get(at));
for (let done = 0; done < bytes.length; ) done += writeSync(1, bytes, done);
