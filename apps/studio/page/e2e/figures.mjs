// How long the page takes for an hour of flight, 720,000 rows: `npm run figures`, with PYLON_BIN naming a release build of pylon.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join } from "node:path";
import { gzipSync } from "node:zlib";

import { choose, launch, open, pylon, revisionsAre, sentence, studio } from "./browser.mjs";

/** As `cargo xtask bench` has its long flight (xtask/src/bench/long_flight.rs): manoeuvre, seconds, what it asks for. */
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
`;

if (pylon === undefined) throw new Error("PYLON_BIN must name a release build of pylon");
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

  const { page: tab } = await open(browser);
  await tab.locator(".sample").first().waitFor();
  const begun = performance.now();
  await choose(tab, file);
  const since = () => performance.now() - begun;
  await tab.locator(".flight:not(.failed) .used").first().waitFor();
  console.log(`opened: ${seconds(since())}`);
  await tab.locator(".chart.altitude canvas").first().waitFor();
  console.log(`first picture: ${seconds(since())} after the file was chosen`);
  await tab.locator(".chart.error canvas").first().waitFor();
  console.log(`the error: ${seconds(since())}`);
  const said = performance.now();
  await tab.waitForFunction(() => !document.querySelector(".progress") && document.querySelector(".effect"), undefined, { timeout: 600_000 });
  console.log(`the sentence: ${seconds(since())} (${await sentence(tab)})`);
  await revisionsAre(tab, 1);
  const native = performance.now();
  execFileSync("taskset", ["-c", "0", pylon, "diagnose", "hour.csv", "--json"], { cwd: folder, stdio: "ignore" });
  const own = performance.now() - native;
  console.log(`diagnosis by one native core, reading included: ${seconds(own)}; the page's, from the picture on: ${seconds(performance.now() - said - own)}`);
  const adding = performance.now();
  await tab.locator(".effect .add").first().click();
  await tab.locator(".chart.error .legend-entry", { hasText: "After" }).waitFor({ timeout: 300_000 });
  console.log(`Add to the new curve: ${seconds(performance.now() - adding)}`);
} finally {
  await browser.close();
  rmSync(folder, { recursive: true });
}
