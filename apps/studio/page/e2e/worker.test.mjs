// A log that kills the engine kills a worker, and nothing else.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { launch, open, openSample, revisionsAre, sentence } from "./browser.mjs";

let browser;
before(async () => { browser = await launch(); });
after(async () => browser.close());

/** Memory limit of the engine in this test: enough for the flight, too little for the log. */
const MEMORY_MB = 192;
/** Size of the log: two bytes of text a value, several in memory. */
const LOG_MB = 60;

/** Runs in the page before its script: limits the engine's memory to this many pages of 64 kB. */
function limitMemory(pages) {
  const compile = WebAssembly.compile.bind(WebAssembly);
  WebAssembly.compile = async (source) => {
    const bytes = new Uint8Array(source);
    let at = 8;
    const number = () => {
      let [value, shift] = [0, 0];
      for (;;) {
        const byte = bytes[at++];
        value |= (byte & 127) << shift;
        shift += 7;
        if (byte < 128) return value;
      }
    };
    const encoded = (value) => (value < 128 ? [value] : [(value & 127) | 128, ...encoded(value >> 7)]);
    while (at < bytes.length) {
      const start = at;
      const section = bytes[at++];
      const end = number() + at;
      if (section === 5) {
        number(); // number of memories: one
        number(); // kind of its limits: a minimum alone
        const least = number(); // the minimum
        const body = [1, 1, ...encoded(least), ...encoded(pages)];
        return compile(new Uint8Array([...bytes.subarray(0, start), 5, ...encoded(body.length), ...body, ...bytes.subarray(end)]));
      }
      at = end;
    }
    throw new Error("the module has no memory");
  };
}

test("a log that is too large for the engine kills its worker; the page says so and goes on", async () => {
  const { context, page, wrongs } = await open(browser, { before: (page) => page.addInitScript(limitMemory, MEMORY_MB * 16) });
  await openSample(page, "hidden-static-port");
  await sentence(page);
  await revisionsAre(page, 1);
  await page.evaluate((megabytes) => {
    const columns = 40;
    const names = Array.from({ length: columns }, (_, i) => `c${i}`);
    const head = `# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m,${names.join(",")}\n`;
    const row = `1,2,3${",4".repeat(columns)}\n`;
    const rows = row.repeat(Math.floor(1_000_000 / row.length));
    const transfer = new DataTransfer();
    transfer.items.add(new File([head, ...new Array(megabytes).fill(rows)], "killer.csv"));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
  }, LOG_MB);
  const failed = page.locator(".flight.failed");
  await failed.waitFor();
  assert.match(await failed.textContent(), /killer\.csv.*engine crashed.*nothing else is affected/s);

  // The other flight is worked on as before, also by the worker that was killed.
  await page.locator(".effect.suspect .add").first().click();
  const [[was], [less]] = await revisionsAre(page, 2);
  assert.ok(less < 0.7 * was, `${was} m before, ${less} m after`);
  await page.getByLabel("Formula of the effect").fill("tas_mps^2 / (2*g)");
  await page.locator(".formula-fit, .formula-problem").first().waitFor();
  await page.getByRole("button", { name: "Close killer.csv" }).click();
  assert.deepEqual(wrongs, []);
  await context.close();
});
