// The page against the command line, on one file: exports are equal to the last byte, and what is shown has
// the same digits.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";

import { choose, launch, open, openSample, pylon, revisionsAre, sentence, withoutPylon } from "./browser.mjs";

let browser;
let folder;
before(async () => {
  browser = await launch();
  folder = mkdtempSync(join(tmpdir(), "pylon-numbers-"));
});
after(async () => {
  await browser.close();
  rmSync(folder, { recursive: true });
});

const ran = (...words) => execFileSync(pylon, words, { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "ignore"], maxBuffer: 1 << 28 });

async function exported(page, name) {
  await page.getByText("Export").click();
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name }).click()]);
  return readFileSync(await download.path(), "utf8");
}

/** A shown number is the other one, rounded to the digits that are shown. */
function shows(text, value) {
  const plain = text.replace("−", "-");
  const digits = (/\.(\d+)/.exec(plain)?.[1] ?? "").length;
  assert.equal(Number.parseFloat(plain), Number(value.toFixed(digits)), `${text} shown for ${value}`);
}

test("the page's numbers are the command line's, digit for digit", { skip: withoutPylon }, async () => {
  const { context, page, wrongs } = await open(browser);
  await openSample(page, "hidden-static-port");
  await sentence(page);
  writeFileSync(join(folder, "flight.csv"), await exported(page, "Flight (CSV)"));
  writeFileSync(join(folder, "model.toml"), "");
  await page.getByRole("button", { name: /^Close hidden-static-port/ }).click();
  await choose(page, join(folder, "flight.csv"));
  await sentence(page);
  await revisionsAre(page, 1);

  const flight = ["flight.csv", "--model", "model.toml", "--json"];
  assert.equal(await exported(page, "Comparison (JSON)"), ran("compare", ...flight));
  const diagnosis = ran("diagnose", ...flight);
  assert.equal(await exported(page, "Diagnosis (JSON)"), diagnosis);
  const ladder = () => ran("ladder", "flight.csv", "--model", "model.toml", "--json");
  const before = ladder();
  assert.equal(await exported(page, "Revisions (JSON)"), before);

  // What the screen shows.
  const candidates = JSON.parse(diagnosis).sensors.baro.candidates;
  const found = candidates.find(({ effect }) => effect === "baro.dynamic_pressure");
  const row = page.locator('.effect[data-effect="baro.dynamic_pressure"]');
  const [, coefficient, sigma] = /(−?[\d.]+) ± ([\d.]+)/.exec(await row.locator(".effect-facts").textContent());
  shows(coefficient, found.coefficient);
  shows(sigma, found.sigma);
  shows(await row.locator(".effect-head .number").textContent(), found.size_m);
  const rms = (text, at) => JSON.parse(text).revisions[at].flights[0].sensors.baro.free_flight_rms_m;
  const bars = page.locator(".revision-bar .number");
  shows(await bars.first().textContent(), rms(before, 0));

  // The model that Add makes is the one that `pylon add` writes.
  await row.locator(".add").click();
  await revisionsAre(page, 2);
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Save" }).click()]);
  ran("add", "baro.dynamic_pressure", "--model", "model.toml", "--from", "flight.csv");
  assert.equal(readFileSync(await download.path(), "utf8"), readFileSync(join(folder, "model.toml"), "utf8"));
  const after = ladder();
  assert.equal(await exported(page, "Revisions (JSON)"), after);
  shows(await bars.last().textContent(), rms(after, 1));
  assert.deepEqual(wrongs, []);
  await context.close();
});
