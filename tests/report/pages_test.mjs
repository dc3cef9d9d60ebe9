import assert from "node:assert/strict";
import {readFileSync, statSync, writeFileSync} from "node:fs";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {drawn, embedded, everySwitchChangesThePlots, fitsTheWidth, folder, lamella, open, rowsOf, startBrowser}
  from "./browser.mjs";

const json = (name) => JSON.parse(readFileSync(join(folder, name), "utf8"));
const floats = (text) => {
  const bytes = Buffer.from(text, "base64");
  return new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
};
let browser;
before(async () => {
  // Every channel, side, order and azimuth differs.
  writeFileSync(join(folder, "colour.toml"), '[[layer]]\nmedium = "sggx"\nshape = "fiber"\naxis = [1, 1, 1]\nroughness = 0.3\n' +
    "albedo = [0.9, 0.5, 0.2]\nthickness = 1\n");
  await lamella("compare", "colour.toml", "--walks", "20000", "--wi", "30,20", "--wi", "60", "--model",
    "single_scattering", "--model", "lambert,albedo=0.9,0.5,0.2", "--quiet", "-o", "colour");
  await lamella("compare", "lambert_sphere_halfspace", "--walks", "20000", "--quiet", "-o", "grey");
  browser = await startBrowser();
});
after(() => browser?.stop());

test("a comparison opens from its file without a complaint, and every switch changes the plots", async () => {
  const {page, complaints} = await open(browser.context, "colour/report.html");
  assert.equal(await page.locator(".chart svg").count(), 3);
  await everySwitchChangesThePlots(page, ["run", "side", "order", "channel", "model", "plane", "scale"]);
  const before = await drawn(page);
  await page.locator(".matrix button[aria-pressed=false]").first().click();
  assert.notEqual(await drawn(page), before);
  assert.deepEqual(complaints, []);
  await page.close();
});

test("numbers in the page of a comparison equal its JSON, and its maps sum to the energies", async () => {
  for (const name of ["grey", "colour"]) {
    const {page, complaints} = await open(browser.context, `${name}/report.html`);
    const answer = json(`${name}/report.json`);
    assert.deepEqual(await embedded(page, "answer"), answer);
    if (name === "colour") await page.locator('[data-switch=channel] input[value="G"]').check({force: true});
    const rows = await rowsOf(page), lobes = answer.models.flatMap((m) => m.lobes);
    assert.equal(rows.length, lobes.length);
    for (const row of rows) {
      const lobe = answer.models[row.model].lobes[row.lobe], c = name === "colour" ? 1 : 0;
      for (const field of ["energy_truth", "energy_standard_error", "energy_model"])
        assert.equal(Number(row.fields[field]), lobe[field][c], field);
      for (const field of ["mu_i", "relative_rmse", "relative_rmse_without_noise", "max_error", "p_value"])
        assert.equal(row.fields[field], String(lobe[field]), field);
    }
    // Cells have equal projected solid angles, pi in all: float32 keeps six digits of their mean.
    const details = await embedded(page, "details");
    for (const [m, model] of answer.models.entries()) for (const lobe of model.lobes) {
      const run = details.runs.findIndex((r) => Math.abs(r.mu_i - lobe.mu_i) < 1e-12);
      const map = floats(details.models[m][`${run}/${lobe.side}/${lobe.order}`]), cells = map.length / details.channels;
      lobe.energy_model.forEach((energy, c) => {
        const sum = map.subarray(c * cells, (c + 1) * cells).reduce((a, b) => a + b, 0) * Math.PI / cells;
        assert.ok(Math.abs(sum - energy) <= 1e-5 * Math.abs(energy) + 1e-9, `${sum} ${energy}`);
      });
    }
    assert.deepEqual(complaints, []);
    await page.close();
  }
});

test("a comparison can be used by keyboard, with the focus to be seen", async () => {
  const {page} = await open(browser.context, "colour/report.html");
  const before = await drawn(page);
  await page.locator("[data-switch=order] input:checked").focus();
  await page.keyboard.press("ArrowLeft");
  assert.notEqual(await drawn(page), before);
  const outline = await page.evaluate(() => {
    const input = document.activeElement;
    return [input.name, getComputedStyle(input.nextElementSibling).outlineStyle];
  });
  assert.deepEqual(outline, ["order", "solid"]);
  // Every place that takes the focus has a name.
  const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, [tabindex]")].filter((e) =>
    !(e.getAttribute("aria-label") || e.textContent.trim() || e.labels?.[0]?.textContent.trim())).length);
  assert.equal(nameless, 0);
  await page.close();
});

test("a comparison fits narrow and zoomed windows, is dark where that is asked for, and prints light", async () => {
  for (const name of ["colour", "grey"]) for (const width of [390, 640, 1280]) {
    const {page} = await open(browser.context, `${name}/report.html`, {width});
    await fitsTheWidth(page);
    await page.close();
  }
  const {page} = await open(browser.context, "grey/report.html", {scheme: "dark"});
  const back = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const brightness = (color) => Math.max(...color.match(/\d+/g).slice(0, 3).map(Number));
  assert.ok(brightness(await back()) < 64);
  const dark = await page.locator(".chart svg").first().innerHTML();
  await page.emulateMedia({colorScheme: "light"});
  await page.waitForFunction((d) => document.querySelector(".chart svg").innerHTML !== d, dark);
  assert.equal(brightness(await back()), 255);
  await page.emulateMedia({colorScheme: "dark", media: "print"});
  assert.equal(brightness(await back()), 255);
  assert.equal(await page.locator("[data-switch=order] label:visible").count(), 1);
  await page.close();
});

test("a page of 8 directions, 10 lobes and 3 models is below 6 MiB", async () => {
  await lamella("compare", "spongecake_window_shade", "--walks", "2000", ...[0, 10, 20, 30, 40, 50, 60, 70].flatMap((t) => ["--wi", `${t}`]),
    "--model", "single_scattering", "--model", "spongecake", "--model", "lambert", "--quiet", "-o", "large");
  const start = Date.now();
  const {page, complaints} = await open(browser.context, "large/report.html");
  const seconds = (Date.now() - start) / 1000, size = statSync(join(folder, "large/report.html")).size;
  console.log(`${(size / 2 ** 20).toFixed(2)} MiB, drawn ${seconds.toFixed(2)} s after it was asked for`);
  assert.ok(size < 6 * 2 ** 20);
  assert.equal(await page.locator(".model").count(), 3);
  assert.deepEqual(complaints, []);
  await page.close();
});

test("a comparison without closed forms still shows the truth", async () => {
  await lamella("compare", "lambert_sphere_halfspace", "--walks", "2000", "--model", "lambert", "--wi", "45", "--quiet", "-o", "one");
  const page = readFileSync(join(folder, "one/report.html"), "utf8");
  const answer = {...json("one/report.json"), models: []};
  const bare = page.replace(/(id="answer">)[^<]*/, (_, tag) => tag + JSON.stringify(answer))
    .replace(/"models":\[\{[^\]]*\]/, '"models":[]');
  writeFileSync(join(folder, "bare.html"), bare);
  const opened = await open(browser.context, "bare.html");
  assert.equal(await opened.page.locator(".chart svg").count(), 3);
  assert.deepEqual(opened.complaints, []);
  await opened.page.close();
});

test("the furnaces of a stack and of models mark their verdicts by more than colour", async () => {
  await lamella("furnace", "spongecake_sheen", "--walks", "5000", "--html", "furnace.html", "--json", "furnace.json", "--quiet");
  await lamella("furnace", "--model", "eon,albedo=0.9", "--model", "lambert", "--html", "models.html", "--json", "models.json", "--quiet");
  for (const name of ["furnace", "models"]) {
    const {page, complaints} = await open(browser.context, `${name}.html`);
    const answer = json(`${name}.json`);
    assert.deepEqual(await embedded(page, "answer"), answer);
    assert.match(await page.textContent(".overall"), /✓ pass/);
    for (const row of await rowsOf(page)) {
      const run = (answer.models ? answer.models[row.model] : answer).runs[row.run];
      assert.equal(Number(row.fields.energy), run.energy[0]);
      assert.equal(Number(row.fields.mu_i), run.mu_i);
    }
    await everySwitchChangesThePlots(page, []);
    await page.setViewportSize({width: 390, height: 800});
    await fitsTheWidth(page);
    assert.deepEqual(complaints, []);
    await page.close();
  }
});

test("the bench page draws a front that nothing beats", async () => {
  await lamella("bench", "--quick", "--html", "bench.html", "--json", "bench.json", "--quiet");
  const {page, complaints} = await open(browser.context, "bench.html");
  const answer = json("bench.json");
  assert.deepEqual(await embedded(page, "answer"), answer);
  const rows = await rowsOf(page);
  assert.equal(rows.length, answer.rows.length);
  for (const row of rows) for (const [field, value] of Object.entries(row.fields))
    assert.equal(value, String(answer.rows[row.row][field] ?? ""));
  await everySwitchChangesThePlots(page, ["stack", "rows"]);
  const stack = await page.locator("[data-switch=stack] input:checked").getAttribute("value");
  const points = answer.rows.filter((r) => r.stack === stack);
  const front = points.filter((r) => !points.some((o) => o !== r && o.ns_per_eval <= r.ns_per_eval && o.error <= r.error));
  assert.equal(await page.locator("#front tbody tr").count(), front.length);
  for (const method of ["analog", "next-event"]) assert.ok(points.filter((r) => r.method === method).length > 0);
  await page.setViewportSize({width: 390, height: 800});
  await fitsTheWidth(page);
  assert.deepEqual(complaints, []);
  await page.close();
});

test("the page of a sweep shows every model over the parameter plane", async () => {
  await lamella("sweep", "sggx_slab", "--set", "layer.0.roughness=0.2:1:3", "--set", "layer.0.albedo=0.5,1", "--wi", "30", "--wi", "60",
    "--walks", "2000", "--grid", "4x8", "--model", "single_scattering", "--model", "lambert", "--quiet", "-o", "sweep");
  await lamella("sweep", "sggx_slab", "--of", "furnace", "--set", "layer.0.roughness=0.2:1:3", "--walks", "2000", "--quiet", "-o", "line");
  for (const [name, expected] of [["sweep", ["model", "run", "side", "order", "quantity"]], ["line", ["run"]]]) {
    const {page, complaints} = await open(browser.context, `${name}/report.html`);
    const answer = json(`${name}/report.json`);
    assert.deepEqual(await embedded(page, "answer"), answer);
    assert.equal(await page.locator("#numbers tbody tr").count(), answer.points.length);
    await everySwitchChangesThePlots(page, expected);
    if (name === "sweep") {
      await page.locator('[data-switch=quantity] input[value="error"]').check({force: true});
      const chosen = (s) => page.locator(`[data-switch=${s}] input:checked`).getAttribute("value");
      const run = [30, 60][await chosen("run")], side = await chosen("side"), order = await chosen("order");
      const shown = await page.$$eval("#numbers tbody tr", (rows) => rows.map((r) => [...r.querySelectorAll("[data-value]")].map((c) => c.dataset.value)));
      answer.points.forEach((point, i) => point.answer.models.forEach((model, m) => {
        const lobe = model.lobes.find((l) => l.side === side && l.order === order && Math.abs(Math.cos(run * Math.PI / 180) - l.mu_i) < 1e-9);
        assert.equal(Number(shown[i][m]), lobe ? lobe.relative_rmse_without_noise : 0);
      }));
    }
    await page.setViewportSize({width: 390, height: 800});
    await fitsTheWidth(page);
    assert.deepEqual(complaints, []);
    await page.close();
  }
});
