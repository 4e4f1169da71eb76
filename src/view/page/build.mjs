// Makes page.js of src/, and THIRD-PARTY.txt of what is in it. `npm ci && npm run build`; both are committed, so that
// building taut needs no Node. `node build.mjs FOLDER` writes them there, to compare.

import { build } from "esbuild";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? here;

const loader = (name) => `three/examples/jsm/loaders/${name}.js`;
const made = await build({
  absWorkingDir: here,
  entryPoints: ["src/main.js"],
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "utf8",
  legalComments: "none",
  // Meshes come with the page; the loaders of files would only make it larger.
  alias: { [loader("STLLoader")]: "./src/no_loader.js", [loader("ColladaLoader")]: "./src/no_loader.js" },
  write: false,
  metafile: true,
});
writeFileSync(join(out, "page.js"), made.outputFiles[0].contents);

const own = (folder) => readFileSync(join(folder, "LICENSE"), "utf8");
// Its package leaves the text out, and says whose it is in its README.
const apache = (folder) => {
  const readme = readFileSync(join(folder, "README.md"), "utf8");
  const notice = readme.slice(readme.indexOf("Copyright ©"));
  return `${notice.trim()}\n\n${readFileSync(join(here, "../../../LICENSE-APACHE"), "utf8")}`;
};
const files = { "Apache-2.0": apache };

const packages = new Set();
for (const input of Object.keys(made.metafile.inputs)) {
  const found = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
  if (found) packages.add(found[1]);
}
const notices = [...packages].sort().map((name) => {
  const folder = join(here, "node_modules", name);
  const { version, license } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
  const text = (files[license] ?? own)(folder).trim();
  return `${name} ${version} (${license})\n\n${text}\n`;
});
const head = "What page.js holds besides taut's own code; made by build.mjs.\n\n";
writeFileSync(join(out, "THIRD-PARTY.txt"), head + notices.join(`\n${"-".repeat(80)}\n\n`));
