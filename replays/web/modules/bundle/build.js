// Writes vendor.js, vendor.css and VENDOR_LICENSES.txt anew: `npm ci && npm run vendor`.

import { readFile, writeFile } from "node:fs/promises";
import { build } from "esbuild";

const here = (path) => new URL(path, import.meta.url);
const NAMES = ["three", "uplot"];

/** The package's name, version and licence, as its own files tell them. */
async function licence(name) {
  const told = JSON.parse(await readFile(here(`../node_modules/${name}/package.json`), "utf8"));
  const text = await readFile(here(`../node_modules/${name}/LICENSE`), "utf8");
  return `${told.name} ${told.version} (${told.license})\n\n${text.trim()}\n`;
}

const licences = await Promise.all(NAMES.map(licence));
const heads = licences.map((text) => text.split("\n")[0]).join(", ");
await build({
  entryPoints: [here("entry.js").pathname],
  outfile: here("../vendor.js").pathname,
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  legalComments: "none",
  banner: { js: `// ${heads}: made by bundle/build.js; licences in VENDOR_LICENSES.txt` },
});
const style = await readFile(here("../node_modules/uplot/dist/uPlot.min.css"), "utf8");
await writeFile(here("../vendor.css"), `/* ${heads.split(", ").at(-1)} */\n${style.trim()}\n`);
await writeFile(here("../VENDOR_LICENSES.txt"), licences.join(`\n${"-".repeat(72)}\n\n`));
