// `pylon report` as it is read: on a desk, on a phone, on paper, and without scripts.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";

import { DESK, launch, pylon, root, shoot, violations, watched, withoutPylon } from "./browser.mjs";

let browser;
let folder;
let address;
before(async () => {
  if (withoutPylon) return;
  browser = await launch();
  folder = mkdtempSync(join(tmpdir(), "pylon-report-"));
  const files = ["7", "8"].map((seed) => {
    const file = join(folder, `a-flight-with-quite-a-long-name-${seed}.csv`);
    execFileSync(pylon, ["simulate", join(root, "flights/quickstart.toml"), "--seed", seed, "-o", file], { stdio: "ignore" });
    return file;
  });
  execFileSync(pylon, ["report", ...files, "-o", join(folder, "report.html")], { stdio: "ignore" });
  address = pathToFileURL(join(folder, "report.html")).href;
});
after(async () => {
  await browser?.close();
  if (folder) rmSync(folder, { recursive: true, force: true });
});

async function opened(options) {
  const context = await browser.newContext({ viewport: DESK, ...options });
  const page = await context.newPage();
  const wrongs = watched(page, (url) => url === address);
  await page.goto(address);
  return { context, page, wrongs };
}

test("a report of two flights opens on the verdict, with a chart of each on its first screen", { skip: withoutPylon }, async () => {
  const { context, page, wrongs } = await opened({});
  const verdict = page.locator(".verdict");
  assert.match(await verdict.textContent(), /dynamic_pressure|static-port/);
  for (const place of [0, 1]) {
    const canvas = page.locator(".firsts canvas").nth(place);
    await canvas.waitFor();
    const { y, height } = await canvas.boundingBox();
    assert.ok(y > 0 && y + height <= DESK.height, `chart ${place} reaches from ${y} to ${y + height}`);
  }
  assert.ok(statSync(join(folder, "report.html")).size < 5e6);
  assert.ok(!(await page.content()).includes(folder), "file names, never paths");
  assert.deepEqual(await violations(page), []);
  await shoot(page, "report-1280");
  assert.deepEqual(wrongs, []);
  await context.close();
});

test("on a phone its header takes 60 px and nothing is cut", { skip: withoutPylon }, async () => {
  const { context, page, wrongs } = await opened({ viewport: { width: 390, height: 844 } });
  await page.locator(".firsts canvas").first().waitFor();
  const { height } = await page.locator("header").boundingBox();
  assert.ok(height <= 60, `${height} px`);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing beyond the sides");
  assert.ok((await page.locator(".verdict").boundingBox()).y < 200);
  await shoot(page, "report-390");
  assert.deepEqual(await violations(page), []);
  assert.deepEqual(wrongs, []);
  await context.close();
});

test("printed it keeps its bars, and without scripts its verdict", { skip: withoutPylon }, async () => {
  const paper = await opened({});
  await paper.page.emulateMedia({ media: "print" });
  const bar = paper.page.locator(".bar .length").first();
  assert.equal(await bar.evaluate((one) => getComputedStyle(one).printColorAdjust), "exact");
  assert.notEqual(await bar.evaluate((one) => getComputedStyle(one).backgroundColor), "rgba(0, 0, 0, 0)");
  await paper.context.close();
  const plain = await opened({ javaScriptEnabled: false });
  assert.ok(await plain.page.locator(".verdict").isVisible());
  assert.ok(await plain.page.locator(".finding").first().isVisible());
  await plain.context.close();
});
