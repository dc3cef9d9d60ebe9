// Builds the page's template: one HTML file with its style, its script and the licences of what the
// script contains. `node build.mjs FILE`; equal sources and locked packages give equal bytes.
import {build} from "esbuild";
import {readFileSync, writeFileSync} from "node:fs";
import {fileURLToPath} from "node:url";

const here = fileURLToPath(new URL(".", import.meta.url));
const source = (name) => readFileSync(`${here}source/${name}`, "utf8");
const packageFile = (name) => readFileSync(`${here}node_modules/${name}`, "utf8");
const version = (name) => JSON.parse(packageFile(`${name}/package.json`)).version;

const bundle = async (name) => {
  const result = await build({
    entryPoints: [`${here}source/${name}`],
    absWorkingDir: here,
    bundle: true,
    minify: true,
    write: false,
    charset: "utf8",
    target: ["chrome100", "firefox100", "safari15"],
    legalComments: "none",
    logLevel: "warning",
  });
  return result.outputFiles[0].text.trim();
};

const licences = [
  ["Apache ECharts", "echarts", [["NOTICE"], ["LICENSE"]]],
  ["zrender", "zrender", [["LICENSE"]]],
  ["tslib", "tslib", [["LICENSE.txt"]]],
  ["d3-scale-chromatic", "d3-scale-chromatic", [["LICENSE"]]],
  ["d3-interpolate", "d3-interpolate", [["LICENSE"]]],
  ["d3-color", "d3-color", [["LICENSE"]]],
].map(([title, name, files]) =>
  `${title} ${version(name)}\n\n` +
  files.map(([file]) => packageFile(`${name}/${file}`).trim()).join("\n\n")).join("\n\n\n");

const escapeHtml = (text) => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
const fill = {
  STYLE: await bundle("style.css"),
  SCRIPT: (await bundle("main.js")).replaceAll("</script", "<\\/script"),
  LICENCES: escapeHtml(licences),
};
let page = source("shell.html");
for (const [name, text] of Object.entries(fill)) page = page.replace(`[[${name}]]`, () => text);
for (const mark of ["{{TITLE}}", "{{ANSWER}}", "{{DETAILS}}"])
  if (page.split(mark).length !== 2) throw new Error(`${mark} must stand once in the page`);
writeFileSync(process.argv[2] ?? `${here}page.html`, page);
