// A log of each format is opened and drawn, and gets a sentence.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { after, before, test } from "node:test";

import { choose, launch, open, openSample, pylon, realLogs, root, revisionsAre, sentence, withoutPylon } from "./browser.mjs";

let browser;
before(async () => { browser = await launch(); });
after(async () => browser.close());

async function opens(file) {
  const { context, page, wrongs } = await open(browser);
  await choose(page, file);
  const said = await sentence(page);
  assert.ok(said.length > 20, said);
  assert.equal(await page.locator(".flight.failed").count(), 0, said);
  // The page shows a file's name, never its path.
  assert.ok(!(await page.locator("body").innerText()).includes("/shared/flights"));
  if (await page.locator(".chart.error canvas").count()) {
    assert.ok(await page.locator(".chart.error canvas").first().evaluate(isDrawn), "the error is drawn");
  }
  assert.deepEqual(wrongs, []);
  await context.close();
  return said;
}

/** Whether a canvas has more than one colour. */
function isDrawn(canvas) {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const colours = new Set();
  for (let i = 0; i < data.length; i += 4) colours.add(`${data[i]} ${data[i + 1]} ${data[i + 2]} ${data[i + 3]}`);
  return colours.size > 4;
}

for (const file of [
  "igc/goigc_short1.igc",
  "igc/igclib_new_zealand.igc",
  "ulog/frrs_motor_failure.ulg",
  "dataflash/pymav_test.BIN",
  "tlog/dronekit_flight_replay.tlog",
  "rocket/prometheus_2022-06-24-serial-6583-flight-0003-TeleMega.csv",
]) {
  const path = join(realLogs, file);
  test(`opens ${file}`, { skip: !existsSync(path) && `skipped: ${path} is not there` }, async () => { await opens(path); });
}

test("offers the real flights that were there when it was built, and opens each as the log on disk", { skip: !existsSync(realLogs) && `skipped: ${realLogs} is not there` }, async () => {
  const listed = JSON.parse(readFileSync(join(root, "apps/studio/page/offered.json"), "utf8"));
  for (const { log, from } of listed) {
    const { context, page, wrongs } = await open(browser);
    const button = page.locator(`[data-offered="${basename(log)}"]`);
    await button.waitFor();
    assert.equal(await page.locator("[data-offered]").count(), listed.length);
    assert.ok((await button.innerText()).includes(from), "it says whose log it is");
    assert.ok(await page.evaluate(() => document.querySelector(".first").scrollHeight <= document.querySelector(".first").clientHeight), "nothing to scroll to");
    await button.click();
    const offered = await sentence(page);
    await context.close();
    assert.deepEqual(wrongs, []);
    assert.equal(offered, await opens(join(realLogs, log)), log);
  }
});

test("judges by a second flight of `pylon simulate flights/quickstart.toml`", { skip: withoutPylon }, async () => {
  const folder = mkdtempSync(join(tmpdir(), "pylon-e2e-"));
  const { context, page, wrongs } = await open(browser);
  try {
    const files = ["7", "8"].map((seed) => {
      const file = join(folder, `seed-${seed}.csv`);
      execFileSync(pylon, ["simulate", join(root, "flights/quickstart.toml"), "--seed", seed, "-o", file], { stdio: "ignore" });
      return file;
    });
    await choose(page, files);
    await page.getByLabel("What seed-8.csv is for").selectOption("hold_out");
    assert.match(await sentence(page), /static|dynamic/i, "the hidden cause is named");
    assert.ok(!(await page.locator("body").innerText()).includes(folder), "a file's name, never its path");
    const [[learned, heldOut]] = await revisionsAre(page, 1);
    await page.locator(".effect.suspect .add").first().click();
    const [, [lessLearned, lessHeldOut]] = await revisionsAre(page, 2);
    assert.ok(lessLearned < learned && lessHeldOut < heldOut, `${learned} to ${lessLearned} m, held out ${heldOut} to ${lessHeldOut} m`);
    assert.deepEqual(wrongs, []);
  } finally {
    await context.close();
    rmSync(folder, { recursive: true, force: true });
  }
});

for (const name of ["paper-reconstruction", "clean"]) {
  test(`opens the flight '${name}' that comes with Pylon`, async () => {
    const { context, page, wrongs } = await open(browser);
    await openSample(page, name);
    assert.ok((await sentence(page)).length > 20);
    assert.match(await page.locator(".flights").innerText(), /simulat|reconstruct/i, "a simulated flight is called simulated");
    assert.deepEqual(wrongs, []);
    await context.close();
  });
}
