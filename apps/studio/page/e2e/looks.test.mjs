// Sizes, themes, accessibility, and the keyboard alone.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { launch, open, openSample, revisionsAre, sentence, shoot, violations } from "./browser.mjs";

let browser;
before(async () => { browser = await launch(); });
after(async () => browser.close());

const isWhole = async (page) => page.evaluate(() => {
  const { scrollWidth, scrollHeight } = document.documentElement;
  return { across: scrollWidth <= innerWidth, down: innerWidth < 700 || scrollHeight <= innerHeight };
});

/** Elements that extend beyond the sides of the screen. */
const cut = async (page) => page.locator("button, select, h1, h2, .legend-entry").evaluateAll((all) => all
  .filter((one) => one.checkVisibility() && one.getBoundingClientRect().width > 1)
  .filter((one) => one.getBoundingClientRect().right > innerWidth + 1 || one.getBoundingClientRect().left < -1)
  .map((one) => one.outerHTML.slice(0, 120)));

for (const [width, height] of [[1280, 720], [1920, 1080], [390, 844]]) {
  test(`${width} x ${height}, light and dark: nothing is cut, nothing that axe objects to`, async () => {
    const { context, page, wrongs } = await open(browser, { viewport: { width, height } });
    const inBoth = async (name) => {
      for (const colorScheme of ["light", "dark"]) {
        await page.emulateMedia({ colorScheme });
        await shoot(page, `${width}-${colorScheme}-${name}`);
        assert.deepEqual(await isWhole(page), { across: true, down: true });
        assert.deepEqual(await cut(page), []);
        assert.deepEqual(await violations(page), []);
      }
    };
    await page.locator(".sample").first().waitFor();
    await inBoth("first");
    await openSample(page, "hidden-static-port");
    await sentence(page);
    await page.locator(".effect.suspect .add").first().click();
    await revisionsAre(page, 2);
    await page.locator(".chart.error .legend-entry", { hasText: "After" }).waitFor();
    await inBoth("flight");
    if (width < 700) assert.ok((await page.locator("header").boundingBox()).height <= 60);
    assert.deepEqual(wrongs, []);
    await context.close();
  });
}

test("by the keyboard alone", async () => {
  const { context, page, wrongs } = await open(browser);
  await page.locator(".sample").first().waitFor();
  const reach = async (selector) => {
    for (let presses = 0; presses < 80; presses += 1) {
      if (await page.evaluate((wanted) => document.activeElement?.matches(wanted) ?? false, selector)) return;
      await page.keyboard.press("Tab");
    }
    assert.fail(`Tab does not reach ${selector}`);
  };
  await reach(".sample");
  await page.keyboard.press("Enter");
  await sentence(page);
  await reach(".chart.error .plot.time");
  await page.keyboard.press("+");
  assert.ok(await page.getByRole("button", { name: "All", exact: true }).isEnabled(), "+ zooms in");
  await page.keyboard.press("0");
  assert.ok(await page.getByRole("button", { name: "All", exact: true }).isDisabled(), "0 shows all");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("[");
  await page.locator(".brushed").waitFor();
  await page.keyboard.press("Escape");
  assert.equal(await page.locator(".brushed").count(), 0);
  await reach(".effect.suspect .add");
  await page.keyboard.press("Enter");
  await revisionsAre(page, 2);
  await page.evaluate(() => { if (document.activeElement instanceof HTMLElement) document.activeElement.blur(); });
  await reach("header button:not(:disabled)");
  await page.keyboard.press("Enter");
  await revisionsAre(page, 1);
  assert.deepEqual(wrongs, []);
  await context.close();
});

test("the tour has five steps and ends", async () => {
  const { context, page, wrongs } = await open(browser);
  await page.getByRole("button", { name: /Show me around/ }).click();
  for (let step = 1; step <= 5; step += 1) {
    await page.getByRole("dialog", { name: new RegExp(`step ${step} of 5`) }).waitFor();
    await page.getByRole("button", { name: step < 5 ? "Next" : "Done" }).click();
  }
  assert.equal(await page.getByRole("dialog").count(), 0);
  assert.deepEqual(wrongs, []);
  await context.close();
});
