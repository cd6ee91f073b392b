// A user's session: open, read, brush, add, see the error fall, undo, reload, export.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, test } from "node:test";

import { choose, drop, launch, open, openSample, revisionsAre, sentence } from "./browser.mjs";
import { igc } from "./igc.mjs";

let browser;
before(async () => { browser = await launch(); });
after(async () => browser.close());

test("a cause is read, added, undone, and kept over a reload", async () => {
  const { context, page, wrongs } = await open(browser);
  await openSample(page, "hidden-static-port");
  assert.match(await sentence(page), /\d/, "the sentence has a number");
  assert.match(await page.locator(".effect.suspect").first().textContent(), /static|dynamic/i);
  const first = await page.locator(".effect.suspect").first().getAttribute("data-effect");
  assert.equal(first, "baro.dynamic_pressure", "what the scenario hides is what is named");

  // What if: another curve at once.
  await page.getByRole("switch").first().click();
  await page.locator(".chart.error .legend-entry", { hasText: "What if" }).waitFor();
  await page.getByRole("switch").first().click();
  await page.locator(".chart.error .legend-entry", { hasText: "What if" }).waitFor({ state: "detached" });

  // A brushed stretch is highlighted in the scatter.
  // Wait: its chart may be about to be replaced.
  await page.waitForTimeout(300);
  const curve = await page.locator(".chart.error .u-over").boundingBox();
  await page.mouse.move(curve.x + 0.55 * curve.width, curve.y + 30);
  await page.mouse.down();
  await page.mouse.move(curve.x + 0.7 * curve.width, curve.y + 35, { steps: 4 });
  await page.mouse.up();
  await page.locator(".brushed").waitFor();
  const points = await page.locator(".plot.points").first().getAttribute("aria-label");
  const brushed = Number(/(\d+) of them brushed/.exec(points)?.[1]);
  const all = Number(/(\d+) points/.exec(points)?.[1]);
  assert.ok(brushed > 0 && brushed < all, points);
  await page.getByRole("button", { name: "Zoom to the brushed stretch" }).click();
  assert.ok(await page.getByRole("button", { name: "All", exact: true }).isEnabled());
  await page.locator(".chart.error .u-over").dblclick();

  const [[was]] = await revisionsAre(page, 1);
  await page.locator(".effect.suspect .add").first().click();
  const [[same], [less]] = await revisionsAre(page, 2);
  assert.equal(same, was, "the revision before stays as it was");
  assert.ok(less < 0.7 * was, `${was} m before, ${less} m after`);
  const learned = await sentence(page);
  await page.locator(".chart.error .legend-entry", { hasText: "After" }).waitFor();
  // "After" shows the error after the addition: checked in the dive, where the error was largest.
  await page.mouse.move(curve.x + 0.555 * curve.width, curve.y + 30);
  const value = async (name) => Number.parseFloat((await page.locator(".chart.error .legend-entry", { hasText: name }).locator("b").textContent()).replace("−", "-"));
  const [then, now] = [await value("Before"), await value("After")];
  assert.ok(Math.abs(now) < 0.3 * Math.abs(then), `${then} m before, ${now} m after`);
  await page.locator(".ribbon.trust").nth(1).waitFor(); // trust, before and after

  await page.waitForTimeout(400);
  await page.reload();
  const kept = await revisionsAre(page, 2);
  assert.deepEqual(kept, [[was], [less]], "the same after a reload");
  assert.notEqual(learned, "");

  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Save" }).click()]);
  assert.equal(download.suggestedFilename(), "model.toml");
  const model = await readFile(await download.path(), "utf8");
  assert.match(model, /id = "baro\.dynamic_pressure"/);
  await page.getByText("Export").click();
  const [json] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Comparison (JSON)" }).click()]);
  const compared = JSON.parse(await readFile(await json.path(), "utf8"));
  assert.ok(compared.sensors.baro.free_flight_rms_m < 0.7 * was);

  // Undo goes back to the model that the page was opened with.
  await page.getByRole("button", { name: "Undo" }).click();
  assert.deepEqual(await revisionsAre(page, 1), [[was]]);
  assert.ok(await page.getByRole("button", { name: "Undo" }).isDisabled());
  // A user's own model can be dropped too.
  await drop(page, "ours.toml", model);
  await revisionsAre(page, 2);
  await drop(page, "broken.toml", "[[effect]]\nid = 7\n");
  await page.getByRole("alert").waitFor();
  assert.match(await page.getByRole("alert").textContent(), /broken\.toml|line|id/);
  assert.deepEqual(wrongs, []);
  await context.close();
});

test("the page is there before its engine is, and a log that is dropped meanwhile is opened by it", async () => {
  const { context, page, wrongs } = await open(browser, {
    before: (tab) => tab.addInitScript(() => {
      const compile = WebAssembly.compile.bind(WebAssembly);
      const until = new Promise((go) => { globalThis.letGo = go; });
      WebAssembly.compile = async (source) => { await until; return compile(source); };
    }),
  });
  await page.getByRole("button", { name: "Choose a log…" }).waitFor();
  assert.match(await page.locator("h1").textContent(), /Drop a flight log/);
  // Two clicks: this one, and the one on the file.
  await choose(page, [{ name: "glider.igc", mimeType: "text/plain", buffer: Buffer.from(igc("Ann", "D-1234")) }]);
  await page.locator(".flight", { hasText: "glider.igc" }).waitFor();
  await page.evaluate(() => globalThis.letGo());
  assert.ok((await sentence(page)).length > 20);
  assert.deepEqual(wrongs, []);
  await context.close();
});

test("what is no log is refused with the importer's line, and the others are opened", async () => {
  const { context, page, wrongs } = await open(browser);
  await choose(page, [
    { name: "notes.txt", mimeType: "text/plain", buffer: Buffer.from("dear diary\nwe flew\n") },
    { name: "empty.ulg", mimeType: "application/octet-stream", buffer: Buffer.from("") },
    { name: "glider.igc", mimeType: "text/plain", buffer: Buffer.from(igc("Ann", "D-1234")) },
  ]);
  await page.locator(".flight.failed").nth(1).waitFor();
  const problems = await page.locator(".flight-problem").allTextContents();
  assert.ok(problems.every((text) => text.length > 10), problems.join("; "));
  assert.equal(await page.locator(".flight:not(.failed)").count(), 1);
  await sentence(page);
  await page.getByRole("button", { name: "Close notes.txt" }).click();
  assert.equal(await page.locator(".flight.failed").count(), 1);
  assert.doesNotMatch(await page.locator("body").innerText(), /captive|launch|mother ship/i, "a glider is not told about launches");
  assert.deepEqual(wrongs, []);
  await context.close();
});

test("a pilot who is a script stays text", async () => {
  const { context, page, wrongs } = await open(browser);
  const evil = "<img src=x onerror=\"document.title='had'\">";
  await drop(page, `${evil}.igc`, igc("<script>document.title='had'</script>", evil));
  await sentence(page);
  assert.ok((await page.locator(".flights").textContent()).includes(evil), "shown as it was written");
  assert.equal(await page.locator("#studio img, #studio script").count(), 0);
  assert.equal(await page.title(), "Pylon studio");
  assert.deepEqual(wrongs, []);
  await context.close();
});
