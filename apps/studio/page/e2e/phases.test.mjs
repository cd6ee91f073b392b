// Calibration, take-off and landing, moved by mouse and keys: all is computed again, as by the command line.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";

import { choose, launch, open, pylon, sentence, withoutPylon } from "./browser.mjs";
import { igc } from "./igc.mjs";

let browser;
before(async () => { browser = await launch(); });
after(async () => browser.close());

const at = async (page, name) => Number(await page.getByRole("slider", { name }).getAttribute("aria-valuenow"));
/** Waits until what is shown belongs to the newest times. */
const settled = async (page) => { await page.waitForTimeout(400); await sentence(page); };

test("take-off and landing are dragged, and moved by keys", { skip: withoutPylon }, async () => {
  const folder = mkdtempSync(join(tmpdir(), "pylon-phases-"));
  const { context, page, wrongs } = await open(browser);
  try {
    const file = join(folder, "glider.igc");
    writeFileSync(file, igc("Ann", "D-1234"));
    await choose(page, file);
    await sentence(page);
    const [takeOff, landing] = [await at(page, /^Take-off/), await at(page, /^Landing/)];
    assert.ok(takeOff < landing, `${takeOff} to ${landing} s`);

    const grip = await page.getByRole("slider", { name: /^Landing/ }).boundingBox();
    await page.mouse.move(grip.x + grip.width / 2, grip.y + grip.height / 2);
    await page.mouse.down();
    await page.mouse.move(grip.x + grip.width / 2 - 120, grip.y + grip.height / 2, { steps: 5 });
    await page.mouse.up();
    await settled(page);
    const dragged = await at(page, /^Landing/);
    assert.ok(dragged < landing - 60, `landing at ${landing}, dragged to ${dragged}`);
    await page.locator(".notes summary").click();
    assert.match(await page.locator(".notes").textContent(), /take-off and landing are those given/);

    const slider = page.getByRole("slider", { name: /^Take-off/ });
    await slider.focus();
    for (let press = 0; press < 3; press += 1) await page.keyboard.press("Shift+ArrowRight");
    await page.keyboard.press("Enter");
    await settled(page);
    const moved = await at(page, /^Take-off/);
    assert.ok(Math.abs(moved - takeOff - 30) < 0.2, `${takeOff} + 30 s is not ${moved}`);

    // The page computes the same as the command line with the same times.
    const download = page.waitForEvent("download");
    await page.getByText("Export").click();
    await page.getByRole("button", { name: "Comparison (JSON)" }).click();
    const own = readFileSync(await (await download).path(), "utf8");
    const given = (await page.evaluate(() => new Promise((done) => {
      indexedDB.open("pylon-studio").onsuccess = ({ target }) => {
        target.result.transaction("session").objectStore("session").getAll().onsuccess = ({ target: found }) => done(found.result[0].flights[0].times.airborne);
      };
    })));
    assert.ok(given.take_off_s > 0 && given.landing_s < landing, JSON.stringify(given));
    const line = execFileSync(pylon, ["compare", "glider.igc", "--airborne", `${given.take_off_s}..${given.landing_s}`, "--json"], { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
    // Only the model's name differs: the page has a file's, the command line a preset's.
    const { model: _, ...page_ } = JSON.parse(own);
    const { model: __, ...line_ } = JSON.parse(line);
    assert.deepEqual(page_, line_);
    const plain = execFileSync(pylon, ["compare", "glider.igc", "--json"], { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
    assert.notDeepEqual(JSON.parse(plain).sensors, line_.sensors, "the times make a difference");

    await page.reload();
    await sentence(page);
    assert.ok(Math.abs(await at(page, /^Landing/) - dragged) < 0.2, "kept over a reload");
    await page.getByRole("button", { name: "reset" }).click();
    await settled(page);
    await page.getByRole("button", { name: "All", exact: true }).click();
    assert.equal(await at(page, /^Landing/), landing);
    assert.equal(await at(page, /^Take-off/), takeOff);
    assert.deepEqual(wrongs, []);
  } finally {
    await context.close();
    rmSync(folder, { recursive: true, force: true });
  }
});
