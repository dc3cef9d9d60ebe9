import assert from "node:assert/strict";
import {readFileSync, statSync, writeFileSync} from "node:fs";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {drawn, embedded, everySwitchChangesThePlots, fitsTheWidth, folder, lamella, open, rowsOf, startBrowser}
  from "./browser.mjs";
import {short} from "../../compare/report/page/source/numbers.js";

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
  const {page, complaints} = await open(browser.context, "large/report.html");
  const size = statSync(join(folder, "large/report.html")).size;
  // By the browser's own clock, from the start of the navigation; told, not asserted: machines
  // differ.
  const [load, ready] = await page.evaluate(() => [performance.getEntriesByType("navigation")[0].loadEventEnd,
    performance.getEntriesByName("ready")[0].startTime]);
  console.log(`${(size / 2 ** 20).toFixed(2)} MiB; plots drawn after ${(ready / 1000).toFixed(2)} s, load event after ${(load / 1000).toFixed(2)} s`);
  assert.ok(size < 6 * 2 ** 20);
  assert.equal(await page.locator(".model").count(), 3);
  assert.equal(await page.locator(".chart svg").count(), 3);
  assert.deepEqual(complaints, []);
  await page.close();
});

test("the truth's error band is drawn whatever is chosen, be it walks' or the solver's", async () => {
  await lamella("compare", "lambert_sphere_halfspace", "--wi", "60", "--model", "lambert_sphere", "--quiet", "-o", "solved");
  for (const name of ["grey", "solved"]) {
    const {page} = await open(browser.context, `${name}/report.html`);
    for (const order of ["1", "2", "all"]) for (const scale of ["linear", "log"]) {
      await page.locator(`[data-switch=order] input[value="${order}"]`).check({force: true});
      await page.locator(`[data-switch=scale] input[value="${scale}"]`).check({force: true});
      // In the polar plot and in the one along the plane: a filled path with an edge, both half
      // transparent.
      const bands = await page.evaluate(() => [...document.querySelectorAll(".chart.tall")].map((chart) => [...chart.querySelectorAll("svg path")]
        .filter((path) => /^rgb\(0,0,0\)$/.test(path.getAttribute("fill")) && path.getAttribute("fill-opacity") === "0.18"
          && path.getAttribute("stroke-opacity") === "0.45" && path.getBoundingClientRect().width > 50).length));
      assert.deepEqual(bands, [1, 1], `${name}, order ${order}, ${scale}`);
    }
    await page.close();
  }
});

test("the errors of a bounded truth are shown over their bounds, in decades", async () => {
  await lamella("compare", "lambert_sphere_halfspace", "--wi", "60", "--model", "lambert_sphere", "--quiet", "-o", "bounded");
  const {page, complaints} = await open(browser.context, "bounded/report.html");
  const answer = json("bounded/report.json"), details = await embedded(page, "details");
  assert.equal(answer.estimator, "deterministic");
  const disc = page.locator(".disc").nth(3);
  assert.match(await disc.locator("figcaption").textContent(), /Error over bound.*logarithmic/);
  // The scale ends at the decade at or above the largest ratio.
  const truth = floats(details.truth["0/reflect/all"].f), bound = floats(details.truth["0/reflect/all"].se), model = floats(details.models[0]["0/reflect/all"]);
  const ratios = [...truth].map((v, k) => Math.abs(model[k] - v) / bound[k]), most = Math.max(...ratios);
  assert.ok(most > 100, `errors far beyond the bound: ${most}`);
  const ticks = await disc.locator(".bar span").allTextContents();
  assert.equal(ticks[0], "0.1");
  assert.equal(ticks[2], short(10 ** Math.ceil(Math.log10(most))));
  // Not one dark disc: many colours where the errors differ.
  const colors = await disc.locator("canvas").first().evaluate((c) => {
    const {data} = c.getContext("2d").getImageData(0, 0, c.width, c.height), seen = new Set();
    for (let k = 0; k < data.length; k += 4) if (data[k + 3] === 255) seen.add(`${data[k]},${data[k + 1]},${data[k + 2]}`);
    return seen.size;
  });
  assert.ok(colors > 20, `${colors} colours`);
  assert.deepEqual(complaints, []);
  await page.close();
});

test("the one number of a colour is its luminance, and is called that", async () => {
  const {page} = await open(browser.context, "colour/report.html");
  const answer = json("colour/report.json");
  for (const row of await rowsOf(page)) {
    const lobe = answer.models[row.model].lobes[row.lobe];
    for (const field of ["energy_truth", "energy_standard_error", "energy_model"]) {
      const [r, g, b] = lobe[field];
      assert.ok(Math.abs(Number(row.fields[field]) - (.2126 * r + .7152 * g + .0722 * b)) < 1e-12, field);
    }
  }
  const head = await page.$$eval("#numbers th", (all) => all.map((e) => e.textContent));
  assert.ok(head.includes("Energy, truth, luminance (Rec. 709)"), head.join("; "));
  assert.ok((await page.textContent("[data-switch=channel]")).includes("luminance (Rec. 709)"));
  await page.close();
});

test("closed forms that are timed by themselves have a plot", async () => {
  await lamella("bench", "--quick", "--only", "models", "--html", "models_only.html", "--json", "models_only.json", "--quiet");
  const {page, complaints} = await open(browser.context, "models_only.html");
  const answer = json("models_only.json"), judged = new Set(answer.rows.filter((r) => r.error_on).map((r) => r.what.replace(/^.*\//, "")));
  assert.ok(judged.size > 3);
  assert.equal(await page.locator(".chart svg").count(), 1);
  assert.equal(await page.locator("#front tbody tr").count(), judged.size);
  const legend = await page.locator(".legend").first().textContent();
  for (const name of judged) assert.ok(legend.includes(name), name);
  for (const width of [390, 1100, 1280]) {
    await page.setViewportSize({width, height: 800});
    await fitsTheWidth(page);
    // No label is cut off at the edge.
    const cut = await page.evaluate(() => [...document.querySelectorAll(".chart svg")].flatMap((svg) => [...svg.querySelectorAll("text")]
      .filter((t) => t.getBoundingClientRect().right > svg.getBoundingClientRect().right + .5).map((t) => t.textContent)));
    assert.deepEqual(cut, []);
  }
  assert.deepEqual(complaints, []);
  await page.close();
});

test("names break at their underscores where they would not fit", async () => {
  const {page} = await open(browser.context, "colour/report.html", {width: 390});
  const unbroken = await page.evaluate(() => [...document.querySelectorAll("h1, .legend li span, .options span, td.name, .name strong")]
    .filter((e) => e.textContent.includes("_") && e.querySelectorAll("wbr").length < e.textContent.split("_").length - 1).map((e) => e.textContent));
  assert.deepEqual(unbroken, []);
  const name = page.locator(".name strong").filter({hasText: "single_scattering"});
  assert.equal((await name.evaluate((e) => { e.style.display = "block"; e.style.width = "5.5em"; return e.innerText.length && e.getClientRects()[0].height; })) >
    await name.evaluate((e) => { e.style.width = "30em"; return e.getClientRects()[0].height; }), true);
  await page.close();
});

test("maps of truth and model share a printed scale, and every verdict has a sign besides its colour", async () => {
  const {page} = await open(browser.context, "grey/report.html");
  const ticks = await page.$$eval(".disc .bar", (bars) => bars.map((b) => [...b.querySelectorAll("span")].map((s) => s.textContent)));
  assert.equal(ticks.length, 4);
  assert.deepEqual(ticks[0], ticks[1]);
  assert.deepEqual(ticks[3], ["−4", "0", "4"]);
  for (const [verdict, sign] of [["agrees", "✓"], ["differs", "✗"], ["insufficient", "?"]]) {
    const texts = await page.$$eval(`.mark.${verdict}`, (all) => all.map((e) => e.textContent));
    assert.ok(texts.every((t) => t.startsWith(sign)), `${verdict}: ${texts}`);
  }
  const head = await page.$$eval("#numbers th", (all) => all.map((e) => e.textContent));
  for (const column of ["z verdict", "Without noise", "Maximum", "ns / eval", "Energy, truth", "Energy, model"]) assert.ok(head.includes(column), column);
  await page.close();
});

test("a preview inside of the report shows sphere and plane, truth, models and their difference",
    {skip: process.env.LAMELLA_CAIRO === "OFF" && "built without Cairo"}, async () => {
  await lamella("compare", "lambert_sphere_halfspace", "--wi", "60", "--model", "lambert_sphere", "--model", "hapke_lambert_sphere", "--preview", "--quiet", "-o", "preview");
  const {page, complaints} = await open(browser.context, "preview/report.html");
  const answer = json("preview/report.json");
  assert.deepEqual(answer.previews.map((v) => `${v.scene} ${v.light}`), ["sphere lamp", "sphere environment", "plane lamp", "plane environment"]);
  const shots = await page.$$eval(".shot", (all) => all.map((s) => ({name: s.dataset.picture, mean: Number(s.querySelector("[data-field]").dataset.value),
    images: [...s.querySelectorAll("img")].map((i) => [i.complete && i.naturalWidth, i.naturalHeight, i.src])})));
  assert.deepEqual(shots.map((s) => [s.name, s.mean]), answer.previews.flatMap((v) => v.pictures.map((p) => [p.name, p.mean_luminance])));
  for (const [k, shot] of shots.entries()) {
    assert.equal(shot.images.length, shot.name === "truth" ? 1 : 2);
    for (const [width, height] of shot.images) assert.deepEqual([width, height], [192, k < 6 ? 192 : 96]);
  }
  // No two pictures are the same, though the models' differ little.
  const all = shots.flatMap((s) => s.images.map(([, , src]) => src));
  assert.equal(new Set(all).size, all.length);
  for (const view of answer.previews) for (const end of ["exr", "png"])
    assert.ok(statSync(join(folder, `preview/preview_${view.scene}_${view.light}.${end}`)).size > 1000);
  for (const width of [390, 640]) {
    await page.setViewportSize({width, height: 800});
    await fitsTheWidth(page);
  }
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
  await lamella("furnace", "sggx_slab", "--html", "furnace.html", "--json", "furnace.json", "--quiet");
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

test("a check of a model has a row per check with its worst case, and marks its verdict by more than colour", async () => {
  for (const [name, model, overall] of [["right", "eon", /✓ pass/], ["wrong", "hapke_lambert_sphere", /✗ fail/]]) {
    const words = ["check", model, "--quick", "--configurations", "2", "--html", `${name}.html`, "--json", `${name}.json`, "--quiet"];
    await lamella(...words).catch((error) => assert.match(error.message, /: 1 /));
    const {page, complaints} = await open(browser.context, `${name}.html`);
    const answer = json(`${name}.json`);
    assert.deepEqual(await embedded(page, "answer"), answer);
    assert.match(await page.textContent(".overall"), overall);
    const rows = await rowsOf(page);
    assert.equal(rows.length, answer.checks.length);
    for (const row of rows) {
      const {worst} = answer.checks[row.check];
      if (worst) assert.deepEqual(row.fields, {found: String(worst.found), allowed: String(worst.allowed)});
    }
    assert.equal(await page.locator(".chart svg").count(), 1);
    await page.setViewportSize({width: 390, height: 800});
    await fitsTheWidth(page);
    assert.deepEqual(complaints, []);
    await page.close();
  }
});

test("the furnaces of models over their parameters are heat maps with marks", async () => {
  await lamella("furnace", "--sweep", "--model", "oren_nayar", "--model", "fon", "--html", "ranges.html", "--json", "ranges.json", "--quiet");
  const {page, complaints} = await open(browser.context, "ranges.html");
  const answer = json("ranges.json");
  assert.deepEqual(await embedded(page, "answer"), answer);
  const texts = await page.$$eval(".chart svg text", (all) => all.map((t) => t.textContent).filter((t) => /^[✓✗]/.test(t)));
  const [first] = answer.sweep, count = (sign) => texts.filter((t) => t.startsWith(sign)).length;
  assert.equal(first.energies.length, first.configurations * answer.theta_i.length);
  assert.equal(count("✓"), first.energies.filter((e) => Math.abs(e - 1) <= 1e-3).length);
  assert.equal(count("✗"), first.energies.filter((e) => Math.abs(e - 1) > 1e-3).length);
  for (const row of await rowsOf(page)) for (const field of ["least", "most"])
    assert.equal(Number(row.fields[field]), answer.sweep[row.model][field].energy);
  await everySwitchChangesThePlots(page, ["model"]);
  await page.setViewportSize({width: 390, height: 800});
  await fitsTheWidth(page);
  assert.deepEqual(complaints, []);
  await page.close();
  // A second parameter, which models that have one take minutes over: a switch.
  const two = {...answer, sweep: [{...first, axes: [...first.axes, {name: "second", values: ["a", "b"]}],
    energies: [...first.energies, ...first.energies.map((e) => .9 * e)]}]};
  writeFileSync(join(folder, "two.html"), readFileSync(join(folder, "ranges.html"), "utf8").replace(/(id="answer">)[^<]*/, (_, tag) => tag + JSON.stringify(two)));
  const opened = await open(browser.context, "two.html");
  await everySwitchChangesThePlots(opened.page, ["fixed0"]);
  assert.deepEqual(opened.complaints, []);
  await opened.page.close();
});

test("the bench page draws a front that nothing beats", async () => {
  await lamella("bench", "--quick", "--only", "walks", "--only", "models", "--only", "tradeoff", "--html", "bench.html", "--json", "bench.json", "--quiet");
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
  for (const method of ["analog", "next-event", "deterministic"]) assert.ok(points.filter((r) => r.method === method).length > 0);
  // One line of dashes and symbols per method, bars or arrows for all, and the front's own.
  assert.ok(points.filter((r) => r.kind === "deterministic").every((r) => r.bound));
  for (const choose of await page.locator("[data-switch=stack] input").all()) {
    await choose.check({force: true});
    const boxes = await page.$$eval(".chart svg text", (all) => all.filter((t) => /^[a-z][a-z_-]+$/.test(t.textContent)).map((t) => {
      const {left, right, top, bottom} = t.getBoundingClientRect();
      return {text: t.textContent, left, right, top: top + 2, bottom: bottom - 2};
    }));
    assert.ok(boxes.length > 3);
    for (const [k, a] of boxes.entries()) for (const b of boxes.slice(k + 1))
      assert.ok(a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top, `${a.text} overlaps ${b.text}`);
  }
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
