// How long the page takes for an hour of flight, 720,000 rows: `npm run figures`, with PYLON_BIN naming a
// release build of pylon.

import { execFileSync, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join } from "node:path";
import { gzipSync } from "node:zlib";

import { choose, launch, open, pylon, revisions, revisionsAre, sentence, studio } from "./browser.mjs";

/**
 * Like `cargo xtask bench`'s long flight (xtask/src/bench/long_flight.rs): manoeuvre, seconds, parameters.
 */
const ROUND = [
  ["turn", 60, "bank_deg = 25.0"], ["straight", 20, ""], ["climb", 20, "flight_path_deg = 4.0"], ["level_off", 20, ""],
  ["dive", 20, "flight_path_deg = -4.0"], ["level_off", 20, ""], ["turn", 60, "bank_deg = -25.0"],
  ["accelerate", 40, "airspeed_mps = 34.0"], ["decelerate", 40, "airspeed_mps = 26.0"],
];
const scenario = `name = "an-hour"
source = "simulated to be measured"

[captive]
duration_s = 600.0
altitude_m = 1200.0
airspeed_mps = 28.0

[turbulence]
horizontal_sigma_mps = 0.8
vertical_sigma_mps = 0.5
length_m = 200.0
${Array.from({ length: 10 }, () => ROUND.map(([name, seconds, wanted]) => `
[[free_flight]]
manoeuvre = "${name}"
duration_s = ${seconds}.0
${wanted}
`).join("")).join("")}
[[effect]]
id = "baro.dynamic_pressure"
coefficient = 0.1

[[effect]]
id = "baro.warm_up"
coefficient = 6.0
time_constant_s = 400.0
`;

if (pylon === undefined) throw new Error("PYLON_BIN must name a release build of pylon");
/** The processes of this program's browser. */
function processes() {
  const parents = new Map();
  for (const pid of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      parents.set(Number(pid), Number(/\) \S (\d+)/.exec(readFileSync(`/proc/${pid}/stat`, "utf8"))?.[1]));
    } catch { /* It has ended. */ }
  }
  const isOwn = (pid) => { for (let at = pid; at; at = parents.get(at)) if (at === process.pid) return at !== pid; return false; };
  return [...parents.keys()].filter(isOwn);
}

/** Processor seconds that they have taken: what an idle machine needs to do one thing after the other. */
function processor() {
  let ticks = 0;
  for (const pid of processes()) {
    try {
      const fields = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ").at(-1).split(" ");
      ticks += Number(fields[11]) + Number(fields[12]);
    } catch { /* It has ended. */ }
  }
  return ticks / 100;
}

/** Memory of this browser, MB: of its pages with their workers, and in all. Shared pages count once (PSS). */
function memory() {
  const sum = { pages: 0, all: 0 };
  for (const pid of processes()) {
    try {
      const megabytes = Number(/^Pss:\s+(\d+)/m.exec(readFileSync(`/proc/${pid}/smaps_rollup`, "utf8"))?.[1] ?? 0) / 1000;
      sum.all += megabytes;
      if (readFileSync(`/proc/${pid}/cmdline`, "utf8").includes("--type=renderer")) sum.pages += megabytes;
    } catch { /* It has ended. */ }
  }
  return sum;
}

/** Frames during an action over the error's curve: intervals, and work of the page's thread for each, ms. */
async function frames(tab, name, act) {
  const box = await tab.locator(".chart.error .u-over").boundingBox();
  const session = await tab.context().newCDPSession(tab);
  await session.send("Performance.enable");
  const busy = async () => (await session.send("Performance.getMetrics")).metrics.find(({ name: of }) => of === "TaskDuration").value;
  await tab.evaluate(() => {
    globalThis.frameTimes = [];
    const next = (at) => { globalThis.frameTimes?.push(at); if (globalThis.frameTimes) requestAnimationFrame(next); };
    requestAnimationFrame(next);
  });
  const from = await busy();
  await act(box);
  const to = await busy();
  const times = await tab.evaluate(() => { const all = globalThis.frameTimes; globalThis.frameTimes = undefined; return all; });
  const gaps = times.slice(1).map((at, i) => at - times[i]).sort((one, other) => one - other);
  const at = (share) => gaps[Math.min(Math.floor(share * gaps.length), gaps.length - 1)].toFixed(1);
  console.log(`${name}: ${gaps.length} frames, ${at(0.5)} ms from one to the next (95 % within ${at(0.95)}, the longest ${at(1)}); ${((1000 * (to - from)) / gaps.length).toFixed(1)} ms of work for each`);
}

const folder = mkdtempSync(join(tmpdir(), "pylon-figures-"));
const browser = await launch();
const seconds = (milliseconds) => `${(milliseconds / 1000).toFixed(1)} s`;
try {
  const file = join(folder, "hour.csv");
  writeFileSync(join(folder, "hour.toml"), scenario);
  execFileSync(pylon, ["simulate", "hour.toml", "-o", "hour.csv"], { cwd: folder, stdio: "ignore" });
  const head = readFileSync(file, "utf8").slice(0, 10_000).split("\n").find((line) => line.startsWith("time_s"));
  const page = readFileSync(studio);
  console.log(`page: ${(gzipSync(page, { level: 9 }).length / 1e6).toFixed(2)} MB compressed`);
  console.log(`flight: ${(statSync(file).size / 1e6).toFixed(0)} MB, ${head.split(",").length} columns; load of the machine ${loadavg()[0].toFixed(1)}`);

  let most = { pages: 0, all: 0 };
  const watch = setInterval(() => {
    const now = memory();
    most = { pages: Math.max(most.pages, now.pages), all: Math.max(most.all, now.all) };
  }, 250);
  const { page: tab } = await open(browser);
  await tab.locator(".sample").first().waitFor();
  const begun = performance.now();
  let worked = processor();
  const work = () => { const now = processor(); const taken = now - worked; worked = now; return `${taken.toFixed(1)} s of processor`; };
  await choose(tab, file);
  const since = () => performance.now() - begun;
  await tab.locator(".flight:not(.failed) .used").first().waitFor();
  console.log(`opened: ${seconds(since())}, ${work()}`);
  await tab.locator(".chart.altitude canvas").first().waitFor();
  console.log(`first picture: ${seconds(since())} after the file was chosen, ${work()} more`);
  await tab.locator(".chart.error canvas").first().waitFor();
  console.log(`the error: ${seconds(since())}, ${work()} more`);
  const said = performance.now();
  await tab.waitForFunction(() => !document.querySelector(".progress") && document.querySelector(".effect"), undefined, { timeout: 600_000 });
  console.log(`the sentence: ${seconds(since())}, ${work()} more (all that is computed beside it included) (${await sentence(tab)})`);
  await revisionsAre(tab, 1);
  const native = performance.now();
  const timed = spawnSync("bash", ["-c", 'TIMEFORMAT="%U %S"; time taskset -c 0 "$0" diagnose hour.csv --json >/dev/null 2>&1', pylon], { cwd: folder, encoding: "utf8" });
  const nativeWork = timed.stderr.trim().split(" ").reduce((sum, part) => sum + Number(part), 0);
  const own = performance.now() - native;
  console.log(`diagnosis by one native core, reading included: ${seconds(own)}, ${nativeWork.toFixed(1)} s of processor; the page's, from the picture on: ${seconds(performance.now() - said - own)}`);
  const [[was]] = await revisionsAre(tab, 1);
  const adding = performance.now();
  work();
  await tab.locator('.effect[data-effect="baro.dynamic_pressure"] .add').click();
  const [, [is]] = await tab.waitForFunction(() => document.querySelectorAll(".revision").length === 2).then(() => revisions(tab));
  console.log(`Add to the new numbers: ${seconds(performance.now() - adding)}, ${work()} (${was} m to ${is} m: ${await sentence(tab)})`);
  await tab.locator(".chart.error .legend-entry", { hasText: "After" }).waitFor({ timeout: 300_000 });
  console.log(`Add to the new curve: ${seconds(performance.now() - adding)}, ${work()} more`);
  await revisionsAre(tab, 2);
  console.log(`Add to the next diagnosis: ${seconds(performance.now() - adding)}, ${work()} more`);
  await tab.waitForFunction(() => !document.querySelector(".progress"), undefined, { timeout: 600_000 });
  await tab.waitForTimeout(1000);
  const addingAnother = performance.now();
  work();
  await tab.locator('.effect[data-effect="baro.warm_up"] .add').click();
  const [, , [less]] = await tab.waitForFunction(() => document.querySelectorAll(".revision").length === 3).then(() => revisions(tab));
  console.log(`Add with a time constant to the new numbers: ${seconds(performance.now() - addingAnother)}, ${work()} (${is} m to ${less} m)`);
  await revisionsAre(tab, 3);
  await tab.waitForFunction(() => !document.querySelector(".progress"), undefined, { timeout: 600_000 });
  await tab.waitForTimeout(1000);
  await frames(tab, "zoom by the wheel", async (box) => {
    await tab.mouse.move(box.x + 0.4 * box.width, box.y + 40);
    for (let turn = 0; turn < 120; turn += 1) {
      await tab.mouse.wheel(0, turn % 40 < 20 ? -60 : 60);
      await tab.waitForTimeout(12);
    }
  });
  await tab.locator(".chart.error .u-over").dblclick();
  await frames(tab, "pan by dragging", async (box) => {
    await tab.mouse.wheel(0, -900);
    await tab.keyboard.down("Shift");
    await tab.mouse.move(box.x + 0.8 * box.width, box.y + 40);
    await tab.mouse.down();
    for (let step = 0; step < 120; step += 1) {
      await tab.mouse.move(box.x + (0.5 + 0.3 * Math.cos(step / 12)) * box.width, box.y + 40);
      await tab.waitForTimeout(12);
    }
    await tab.mouse.up();
    await tab.keyboard.up("Shift");
  });
  clearInterval(watch);
  console.log(`memory at most: ${most.pages.toFixed(0)} MB by the page and its workers, ${most.all.toFixed(0)} MB by all of the browser`);
} finally {
  await browser.close();
  rmSync(folder, { recursive: true });
}
