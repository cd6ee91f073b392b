// The page as `pylon studio` serves it: the named files are open, and Save writes the model on the disk.

import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { after, before, test } from "node:test";

import { launch, pylon, root, revisionsAre, sentence, studio, watched, withoutPylon } from "./browser.mjs";

let browser;
let folder;
before(async () => {
  browser = await launch();
  folder = mkdtempSync(join(tmpdir(), "pylon-served-"));
});
after(async () => {
  await browser.close();
  rmSync(folder, { recursive: true });
});

test("a served flight is open at once; Save writes the model, but not over another's change", { skip: withoutPylon }, async () => {
  execFileSync(pylon, ["simulate", join(root, "flights/hidden-static-port.toml"), "-o", "flight.csv"], { cwd: folder, stdio: "ignore" });
  const file = join(folder, "ours.toml");
  writeFileSync(file, "# ours\n");
  const server = spawn(pylon, ["studio", "--no-browser", "flight.csv", "--model", "ours.toml"], { cwd: folder, env: { ...process.env, PYLON_STUDIO: studio } });
  try {
    const [address] = await createInterface({ input: server.stdout })[Symbol.asyncIterator]().next().then(({ value }) => [value.trim()]);
    const { origin } = new URL(address);
    const context = await browser.newContext({ viewport: { width: 1280, height: 720 } });
    context.setDefaultTimeout(60_000);
    const page = await context.newPage();
    const wrongs = watched(page, (url) => url.startsWith(`${origin}/`));
    await page.goto(address);
    assert.match(await sentence(page), /static-port error/);
    await revisionsAre(page, 1);
    await page.locator(".effect.suspect .add").first().click();
    await revisionsAre(page, 2);
    assert.equal(readFileSync(file, "utf8"), "# ours\n", "nothing is written without Save");
    await page.getByRole("button", { name: "Save" }).click();
    await page.locator(".notice", { hasText: "ours.toml is written" }).waitFor();
    const written = readFileSync(file, "utf8");
    assert.match(written, /^# ours\n[\s\S]*id = "baro\.dynamic_pressure"/);
    // The command line reads what the page wrote.
    const ladder = JSON.parse(execFileSync(pylon, ["ladder", "flight.csv", "--model", "ours.toml", "--json"], { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] }));
    assert.equal(ladder.revisions.length, 2);

    // What the page shows is what flies: the whole image in the emulator, each tick compared with the host's.
    await page.getByRole("button", { name: "Fly in QEMU" }).click();
    await page.locator(".notice", { hasText: "Flown in QEMU" }).waitFor({ timeout: 600_000 });
    assert.match(await page.locator(".notice").textContent(), /: [1-9]\d{3,} ticks .* each bit for bit the host's/);
    await page.getByRole("button", { name: "Dismiss" }).click();

    // Another program changes the file: the file is not overwritten, and its new model is shown.
    writeFileSync(file, `${written}\n# by hand\n`);
    await page.getByRole("button", { name: "Undo" }).click();
    await revisionsAre(page, 1);
    await page.getByRole("button", { name: "Save" }).click();
    await page.locator(".notice", { hasText: "was changed by another program" }).waitFor();
    assert.match(readFileSync(file, "utf8"), /# by hand/);
    assert.deepEqual(wrongs.filter((text) => !text.includes("412")), []);
    await context.close();
  } finally {
    server.kill();
  }
});
