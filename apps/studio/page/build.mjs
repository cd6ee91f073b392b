// Bundles the page: `node build.mjs OUT_FOLDER` writes studio.js, studio.css and template.html there.
// `cargo xtask site` makes the single file from them.

import { copyFile, mkdir } from "node:fs/promises";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = fileURLToPath(new URL(".", import.meta.url));
const out = process.argv[2];
if (out === undefined) {
  console.error("usage: node build.mjs OUT_FOLDER");
  process.exit(2);
}
await mkdir(out, { recursive: true });
await build({
  absWorkingDir: here,
  entryPoints: { studio: "src/main.tsx" },
  outdir: out,
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "utf8",
  legalComments: "none",
  logLevel: "warning",
});
await copyFile(join(here, "src/template.html"), join(out, "template.html"));
