// A page with its flights inside, as it is sent to another person.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";

import { choose, launch, open, openSample, revisionsAre, sentence, watched } from "./browser.mjs";
import { igc } from "./igc.mjs";

let browser;
before(async () => { browser = await launch(); });
after(async () => browser.close());

test("it opens elsewhere on what was said, with the flights, the model and its revisions, and asks for nothing", async () => {
  const folder = mkdtempSync(join(tmpdir(), "pylon-inside-"));
  try {
    const { context, page, wrongs } = await open(browser);
    await openSample(page, "hidden-static-port");
    await sentence(page);
    const evil = "</script><script>document.title='had'</script>.igc";
    await choose(page, [{ name: evil, mimeType: "text/plain", buffer: Buffer.from(igc("Ann", "D-1234")) }]);
    await page.locator(".flight:not(.failed)").nth(1).waitFor();
    await page.getByLabel(`What ${evil} is for`).selectOption("off");
    await sentence(page);
    await page.locator(".effect.suspect .add").first().click();
    const revisions = await revisionsAre(page, 2);
    const said = await sentence(page);
    const download = page.waitForEvent("download");
    await page.getByText("Export").click();
    await page.getByRole("button", { name: "This page with its flights (HTML)" }).click();
    const file = join(folder, "flights.html");
    await (await download).saveAs(file);
    assert.deepEqual(wrongs, []);
    await context.close();

    const html = readFileSync(file, "utf8");
    assert.match(html, /connect-src 'none'/);
    assert.ok(!html.includes("uplot\" style"), "nothing that was drawn is in it");
    const other = await browser.newContext({ viewport: { width: 1280, height: 720 } });
    other.setDefaultTimeout(60_000);
    const sent = await other.newPage();
    const address = pathToFileURL(file).href;
    // The engine waits, so that what is read first is what the page has inside.
    await sent.addInitScript(() => {
      const compile = WebAssembly.compile.bind(WebAssembly);
      const until = new Promise((go) => { globalThis.letGo = go; });
      WebAssembly.compile = async (source) => { await until; return compile(source); };
    });
    const complaints = watched(sent, (url) => url === address);
    await sent.goto(address);
    await sent.locator("h1").waitFor();
    assert.equal((await sent.locator("h1").textContent()).replace(/^[✓!✕]/, "").trim(), said);
    await sent.evaluate(() => globalThis.letGo());
    assert.deepEqual(await revisionsAre(sent, 2), revisions);
    assert.equal(await sent.locator(".flight:not(.failed)").count(), 2);
    assert.equal(await sent.getByLabel(`What ${evil} is for`).inputValue(), "off");
    assert.equal(await sent.title(), "Pylon studio");
    await sent.getByRole("button", { name: "Undo" }).click();
    assert.equal((await revisionsAre(sent, 1)).length, 1);
    assert.deepEqual(complaints, []);
    // What was sent is not kept in the recipient's browser.
    await sent.waitForTimeout(400);
    const kept = await sent.evaluate(async () => (await indexedDB.databases()).map(({ name }) => name));
    assert.deepEqual(kept, []);
    await other.close();
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
});
