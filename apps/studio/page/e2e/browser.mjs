// A page of the studio in headless Chromium, and functions that wait for its content.

import { existsSync, mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const here = dirname(fileURLToPath(import.meta.url));
export const root = resolve(here, "../../../..");
export const realLogs = resolve(root, "../shared/flights/real");
/** The studio's page, made by `cargo xtask site`. */
export const studio = process.env.PYLON_STUDIO ?? join(root, "target/studio/studio.html");
/** The command line's program, named by `cargo xtask test studio`. */
export const pylon = process.env.PYLON_BIN ?? ["debug", "release"].map((profile) => join(root, "target", profile, "pylon")).find(existsSync);
export const withoutPylon = pylon === undefined ? "no pylon is built: cargo build --bin pylon, or PYLON_BIN" : false;
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
/** Folder for screenshots, if one is named. */
const shots = process.env.PYLON_SHOTS;
/** Long, because the machine may also be building. */
const PATIENCE_MS = 60_000;

export const DESK = { width: 1280, height: 720 };

export async function launch() {
  if (!existsSync(studio)) throw new Error(`${studio} is missing: cargo xtask site`);
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--disable-background-networking"],
  });
}

/** Opens a page. `wrongs` collects everything that it does wrong, and must be empty at the end. */
export async function open(browser, { viewport = DESK, colorScheme = "light", before = async () => undefined } = {}) {
  const context = await browser.newContext({ viewport, colorScheme, acceptDownloads: true });
  context.setDefaultTimeout(PATIENCE_MS);
  const page = await context.newPage();
  await before(page);
  const wrongs = watched(page, (url) => url === pathToFileURL(studio).href);
  await page.goto(pathToFileURL(studio).href);
  return { context, page, wrongs };
}

/** Collects what a page does wrong from now on; it may request some addresses. */
export function watched(page, isAllowed) {
  const wrongs = [];
  page.on("console", (message) => {
    if (message.type() === "error" || message.type() === "warning") wrongs.push(`console: ${message.text()}`);
  });
  page.on("pageerror", (error) => wrongs.push(`error: ${error.message}`));
  page.on("request", (request) => {
    const url = request.url();
    if (!isAllowed(url) && !/^(blob|data):/.test(url)) wrongs.push(`request: ${url}`);
  });
  return wrongs;
}

export async function openSample(page, name) {
  await page.locator(`[data-sample="${name}"]`).click();
}

/** Chooses files by the button, as a user does. */
export async function choose(page, files) {
  // The page may replace the button while it starts: a click on the old one is repeated.
  const [chooser] = await Promise.all([
    page.waitForEvent("filechooser"),
    page.getByRole("button", { name: /^(Choose a log|Open)…$/ }).first().click(),
  ]).catch(() => Promise.all([
    page.waitForEvent("filechooser"),
    page.getByRole("button", { name: /^(Choose a log|Open)…$/ }).first().click(),
  ]));
  await chooser.setFiles(files);
}

/** Drops a file on the page. */
export async function drop(page, name, text) {
  const transfer = await page.evaluateHandle(([file, content]) => {
    const made = new DataTransfer();
    made.items.add(new File([content], file));
    return made;
  }, [name, text]);
  await page.dispatchEvent("body", "drop", { dataTransfer: transfer });
}

/** The sentence at the top, once it reports what was found. */
export async function sentence(page) {
  await page.waitForFunction(() => {
    const text = document.querySelector("h1")?.textContent ?? "";
    return text !== "" && !text.endsWith("…") && !text.includes("Drop a flight log") && !document.querySelector(".progress");
  });
  return (await page.locator("h1").textContent()).replace(/^[✓!✕]/, "").trim();
}

/** The rms errors at the bottom, metres: for each revision, learned and held out. */
export async function revisions(page) {
  const rows = await page.locator(".revision").evaluateAll((list) =>
    list.map((revision) => [...revision.querySelectorAll(".revision-bar .number")].map((value) => Number.parseFloat(value.textContent ?? ""))));
  return rows;
}

export async function revisionsAre(page, count) {
  await page.waitForFunction((wanted) => document.querySelectorAll(".revision").length === wanted && !document.querySelector(".progress"), count);
  return revisions(page);
}

/** Violations that axe finds, as lines. */
export async function violations(page) {
  await page.evaluate(axe);
  const found = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  return found.violations.flatMap(({ id, nodes }) => nodes.map(({ html, failureSummary }) => `${id}: ${html.slice(0, 160)} ${failureSummary ?? ""}`));
}

/** Takes a screenshot, if PYLON_SHOTS names a folder for them. */
export async function shoot(page, name) {
  if (!shots) return;
  mkdirSync(shots, { recursive: true });
  await page.screenshot({ path: join(shots, `${name}.png`), fullPage: true });
}
