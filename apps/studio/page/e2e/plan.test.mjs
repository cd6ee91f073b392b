// The next flight: planned, looked at, saved as a scenario that `pylon simulate` flies, and printed as a card.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";

import { launch, open, openSample, pylon, sentence, shoot, violations, withoutPylon } from "./browser.mjs";

let browser;
before(async () => { browser = await launch(); });
after(async () => browser.close());

async function planned(page) {
  await page.locator(".plan-intervals tbody tr").first().waitFor();
  await page.waitForFunction(() => document.querySelector(".plan-outlook")?.getAttribute("aria-busy") === "false");
}

async function opened(options) {
  const one = await open(browser, options);
  await openSample(one.page, "hidden-static-port");
  await sentence(one.page);
  await one.page.getByRole("button", { name: /^Plan( the next flight…)?$/ }).first().click();
  await planned(one.page);
  return one;
}

/** An effect's sigma with the planned flight, as it is written. */
const sigma = async (page, effect) => Number(/± ([\d.e−-]+)/.exec(await page.locator(`.plan-intervals [data-effect="${effect}"] td`).last().textContent())[1]);

test("a plan is suggested, changed, and what it would tell follows", async () => {
  const { context, page, wrongs } = await opened();
  assert.ok(await page.locator(".plan-leg").count() >= 1, "something is suggested");
  assert.equal(await page.locator(".plan-offer").count(), 7);
  assert.ok(!(await page.locator(".plan-offer").first().textContent()).includes("can't be flown"));
  // The worst plan, straight and level; then with a speed sweep added.
  await page.getByRole("button", { name: /^\+ Straight and level/ }).click();
  for (let left = await page.locator(".plan-leg").count(); left > 1; left -= 1) await page.getByRole("button", { name: /^Leave out/ }).first().click();
  await page.waitForTimeout(300);
  await planned(page);
  const level = await sigma(page, "baro.propwash");
  await page.getByRole("button", { name: /^\+ Speed sweep/ }).click();
  await page.waitForTimeout(300);
  await planned(page);
  const swept = await sigma(page, "baro.propwash");
  assert.ok(swept < 0.95 * level, `${level} level, ${swept} with a sweep`);
  // A plan that cannot be flown is reported, and the last one that could stays.
  await page.getByLabel("Speed sweep: ±").fill("90");
  await page.locator(".plan-problem").waitFor();
  assert.match(await page.locator(".plan-problem").textContent(), /90: expected 1 to/);
  await page.getByLabel("Speed sweep: ±").fill("5");
  await page.locator(".plan-problem").waitFor({ state: "detached" });
  await planned(page);
  assert.ok(await sigma(page, "baro.propwash") > swept, "less of a sweep tells less");
  // Closed by the keyboard, and unchanged when it is opened again.
  await page.keyboard.press("Escape");
  assert.equal(await page.locator(".plan[open]").count(), 0);
  await page.getByRole("button", { name: "Plan the next flight…" }).first().click();
  assert.equal(await page.getByLabel("Speed sweep: ±").inputValue(), "5");
  assert.deepEqual(wrongs, []);
  await context.close();
});

test("the scenario is one that pylon simulate flies, and the card has what it flies", { skip: withoutPylon }, async () => {
  const folder = mkdtempSync(join(tmpdir(), "pylon-plan-"));
  const { context, page, wrongs } = await opened();
  try {
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Save as a scenario (TOML)" }).click()]);
    assert.equal(download.suggestedFilename(), "next-flight.toml");
    copyFileSync(await download.path(), join(folder, "next-flight.toml"));
    execFileSync(pylon, ["simulate", "next-flight.toml", "-o", "next.csv"], { cwd: folder, stdio: "ignore" });
    const scenario = readFileSync(join(folder, "next-flight.toml"), "utf8");
    const segments = scenario.split("[[free_flight]]").length - 1;
    await page.evaluate(() => { globalThis.print = () => { globalThis.printed = document.documentElement.className; }; });
    await page.getByRole("button", { name: "Print the flight card" }).click();
    assert.equal(await page.evaluate(() => globalThis.printed), "prints-card");
    await page.emulateMedia({ media: "print" });
    assert.ok(await page.locator(".flight-card").isVisible());
    assert.ok(!(await page.locator(".middle").isVisible()) && !(await page.locator(".plan").isVisible()), "nothing but the card");
    // One row for the calibration, and one for each segment.
    assert.equal(await page.locator(".flight-card tbody tr").count(), segments + 1);
    await shoot(page, "flight-card");
    await page.evaluate(() => dispatchEvent(new Event("afterprint")));
    assert.equal(await page.evaluate(() => document.documentElement.className), "");
    assert.deepEqual(wrongs, []);
  } finally {
    await context.close();
    rmSync(folder, { recursive: true, force: true });
  }
});

for (const [width, height] of [[1280, 720], [390, 844]]) {
  test(`the plan at ${width} x ${height}, light and dark: nothing is cut, nothing that axe objects to`, async () => {
    const { context, page, wrongs } = await opened({ viewport: { width, height } });
    for (const colorScheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme });
      await shoot(page, `${width}-${colorScheme}-plan`);
      const cut = await page.locator(".plan button, .plan input, .plan h2, .plan th").evaluateAll((all) => all
        .filter((one) => one.checkVisibility())
        .filter((one) => one.getBoundingClientRect().right > innerWidth + 1 || one.getBoundingClientRect().left < -1)
        .map((one) => one.outerHTML.slice(0, 120)));
      assert.deepEqual(cut, []);
      assert.deepEqual(await violations(page), []);
    }
    assert.deepEqual(wrongs, []);
    await context.close();
  });
}
