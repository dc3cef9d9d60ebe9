// A browser of its own per test file, and pages that must not complain.
import assert from "node:assert/strict";
import {execFile} from "node:child_process";
import {createHash} from "node:crypto";
import {createRequire} from "node:module";
import {mkdtempSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {promisify} from "node:util";

const {chromium} = createRequire(join(process.env.LAMELLA_PACKAGES, "package.json"))("playwright-core");

export const folder = mkdtempSync(join(tmpdir(), "lamella-pages-"));

// Runs the program in the folder of this test; any status of `allowed` will do.
export async function lamella(...words) {
  try {
    await promisify(execFile)(process.env.LAMELLA, words, {cwd: folder, timeout: 1000 * (process.env.LAMELLA_TEST_TIMEOUT ?? 200)});
  } catch (error) {
    throw new Error(`lamella ${words.join(" ")}: ${error.code} ${error.stderr}`);
  }
}

export async function startBrowser() {
  const profile = mkdtempSync(join(tmpdir(), "lamella-browser-"));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: process.env.CHROMIUM, headless: true,
    args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
      "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  });
  return {context, async stop() {
    await context.close();
    for (const path of [profile, folder]) rmSync(path, {recursive: true, force: true, maxRetries: 5});
  }};
}

// Opens a page from its file. Whatever it prints to the console, throws or asks for from elsewhere
// is kept in `complaints`.
export async function open(context, name, {width = 1280, height = 900, scheme = "light"} = {}) {
  const page = await context.newPage();
  const complaints = [];
  page.on("console", (m) => complaints.push(`console ${m.type()}: ${m.text()}`));
  page.on("pageerror", (e) => complaints.push(`error: ${e.stack}`));
  page.on("request", (r) => { if (!/^(file|data):/.test(r.url())) complaints.push(`asks for ${r.url()}`); });
  await page.setViewportSize({width, height});
  await page.emulateMedia({colorScheme: scheme});
  await page.goto(`file://${join(folder, name)}`);
  await page.waitForSelector("html[data-ready]", {timeout: 30000});
  return {page, complaints};
}

// What identifies everything drawn.
export const drawn = async (page) => createHash("sha256").update(await page.evaluate(() => [...document.querySelectorAll(".chart svg")].map((s) => s.innerHTML)
  .concat([...document.querySelectorAll(".disc canvas")].map((c) => c.toDataURL())).join("\n"))).digest("hex");

// Chooses every option of every switch, and asserts that each changes what is drawn.
export async function everySwitchChangesThePlots(page, expected) {
  const names = await page.$$eval(".controls [data-switch]", (all) => all.map((f) => f.dataset.switch));
  for (const name of expected) assert.ok(names.includes(name), `no switch ${name} among ${names}`);
  for (const name of names) {
    const inputs = page.locator(`[data-switch="${name}"] input:not(:disabled)`);
    const values = await inputs.evaluateAll((all) => all.map((i) => i.value));
    assert.ok(values.length > 0);
    for (const value of [...values.slice(1), values[0]]) {
      const input = page.locator(`[data-switch="${name}"] input[value="${value}"]`);
      if (await input.isChecked()) continue;
      const before = name === "rows" ? await page.textContent("#numbers") : await drawn(page);
      await input.check({force: true});
      const after = name === "rows" ? await page.textContent("#numbers") : await drawn(page);
      assert.notEqual(after, before, `switch ${name} to ${value} changes nothing`);
    }
  }
}

export const embedded = (page, id) => page.evaluate((i) => JSON.parse(document.getElementById(i).textContent), id);

// The numbers of a table's cells, by data-field.
export const rowsOf = (page) => page.$$eval("#numbers tbody tr", (rows) => rows.map((row) => ({...row.dataset,
  fields: Object.fromEntries([...row.querySelectorAll("[data-field]")].map((c) => [c.dataset.field, c.dataset.value]))})));

// Nothing reaches beyond the window, but for what scrolls inside of a container of its own.
export async function fitsTheWidth(page) {
  const measure = () => page.evaluate(() => [document.documentElement.scrollWidth, innerWidth,
    [...document.body.querySelectorAll("*")].filter((e) => !e.closest(".scroll") && !e.closest("svg, script, details:not([open])")
      && e.getBoundingClientRect().right > innerWidth + .5).map((e) => `${e.tagName}.${e.className}: ${e.textContent.slice(0, 40)}`)]);
  // Plots follow the window's size a little later.
  let [content, window, beyond] = await measure();
  for (let tries = 0; beyond.length > 0 && tries < 50; ++tries) {
    await page.waitForTimeout(100);
    [content, window, beyond] = await measure();
  }
  assert.ok(content <= window, `the page is ${content} wide in a window of ${window}`);
  assert.deepEqual(beyond, []);
  for (const table of await page.$$("table")) assert.ok(await table.evaluate((t) => t.closest(".scroll") !== null), "a table scrolls by itself");
}
