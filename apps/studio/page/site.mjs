// Makes the single file: `node site.mjs ENGINE.wasm OUT.html [LOGS]`. The template gets what build.mjs
// bundles, the engine (gzip, base64) and its worker as data, and a Content-Security-Policy that lets nothing
// else run and nothing be fetched. The real flights of offered.json are included if the folder LOGS has them:
// the project itself has no copy of any.

import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { existsSync, mkdtempSync, readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { buildSync } from "esbuild";

const here = fileURLToPath(new URL(".", import.meta.url));
const [module, out, logs] = process.argv.slice(2);
if (module === undefined || out === undefined) {
  console.error("usage: node site.mjs ENGINE.wasm OUT.html [LOGS]");
  process.exit(2);
}

const folder = mkdtempSync(join(tmpdir(), "pylon-studio-"));
let page;
try {
  execFileSync(process.execPath, [join(here, "build.mjs"), folder], { stdio: "inherit" });
  page = (name) => readFileSync(join(folder, name), "utf8");
  page = { template: page("template.html"), script: page("studio.js"), style: page("studio.css") };
} finally {
  rmSync(folder, { recursive: true, force: true });
}
const worker = buildSync({
  absWorkingDir: here,
  entryPoints: ["src/engine/worker.ts"],
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "utf8",
  legalComments: "none",
  write: false,
}).outputFiles[0].text;
const engine = gzipSync(readFileSync(module), { level: 9 }).toString("base64");

const found = JSON.parse(readFileSync(join(here, "offered.json"), "utf8"))
  .map(({ log, ...said }) => ({ ...said, file: basename(log), path: logs === undefined ? "" : join(logs, log) }));
const offered = found.filter(({ path }) => existsSync(path))
  .map(({ path, ...said }) => ({ ...said, log: gzipSync(readFileSync(path), { level: 9 }).toString("base64") }));

/** The text of a script or a style, which must not end its element. */
function inside(text, tag) {
  if (new RegExp(`</${tag}|<!--`, "i").test(text)) throw new Error(`a ${tag} has the end of its own element inside`);
  return text;
}
const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;
const script = inside(page.script, "script");
const style = inside(page.style, "style");
const policy = [
  "default-src 'none'",
  `script-src ${hash(script)} 'wasm-unsafe-eval'`,
  `style-src ${hash(style)}`,
  "worker-src blob:",
  "img-src data: blob:",
  // `pylon studio` replaces this by 'self', because the page requests the flights from it.
  "connect-src 'none'",
  "base-uri 'none'",
  "form-action 'none'",
].join("; ");

/** Puts a text at a mark of the template, by a function, so that `$` in the text has no special meaning. */
function put(html, mark, text) {
  if (html.split(mark).length !== 2) throw new Error(`the template must have ${mark} once`);
  return html.replace(mark, () => text);
}
let html = page.template;
html = put(html, "<head>", `<head>\n<meta http-equiv="Content-Security-Policy" content="${policy}">`);
html = put(html, "</head>", `<style>${style}</style>\n</head>`);
html = put(
  html,
  "</body>",
  // The page is drawn before the engine, which is most of the file, has been read.
  `<script>${script}</script>\n<script type="text/plain" id="pylon-worker">${inside(worker, "script")}</script>\n` +
    `<script type="text/plain" id="pylon-offered">${inside(JSON.stringify(offered).replaceAll("<", "\\u003c"), "script")}</script>\n` +
    `<script type="text/plain" id="pylon-engine">${engine}</script>\n</body>`,
);
// Written whole or not at all.
writeFileSync(`${out}.part`, html);
renameSync(`${out}.part`, out);
const kilobytes = (bytes) => `${Math.round(bytes / 1000)} kB`;
console.log(
  `${out}: ${kilobytes(Buffer.byteLength(html))}, ${kilobytes(gzipSync(html, { level: 9 }).length)} compressed (engine ` +
    `${kilobytes(engine.length * 0.75)}, page ${kilobytes(gzipSync(script + style + worker, { level: 9 }).length)}); ` +
    (offered.length > 0 ? `${offered.length} of ${found.length} real flights inside` : `no real flights inside: none in ${logs ?? "no folder named"}`),
);
