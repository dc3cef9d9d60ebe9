// The page of `lamella compare`: truth against closed forms, lobe by lobe.
import {breakable, element, choice, figure, scrolling} from "./dom.js";
import {axis, band, chart, errorBars, legend, modelColor, modelDash, modelSymbol, tooltip} from "./charts.js";
import {magnitudeScale, ratioScale, signedScale} from "./colors.js";
import {cellAt, Disc} from "./disc.js";
import {degrees, floats, luminance, luminanceName, percent, short, thetaOf} from "./numbers.js";
import {heading} from "./heading.js";
import {previews} from "./previews.js";
import {stackDrawing} from "./stack.js";

const allOrders = ["0", "1", "2", "3", "4+", "1+", "2+", "all"];
const orderText = (o) => o === "all" ? "all orders" : `order ${o}`;
const sideText = {reflect: "reflected", transmit: "transmitted"};
const ledgerSide = {reflect: "reflected", transmit: "transmitted"};
const marks = {agrees: "✓", differs: "✗", insufficient: "?"};

const isCut = (lobe) => (lobe.energy_missing ?? []).some((e) => e > 0);

// The relative RMSE without noise, as a range where walks were cut; nothing where there is no truth
// to be relative to.
function rmseText(lobe) {
  const by = lobe.relative_rmse_without_noise;
  if (typeof by !== "number") return "";
  if (!isCut(lobe)) return by > 0 ? percent(by) : "";
  const [least, most] = lobe.relative_rmse_range.map(percent);
  return least === most ? least : `${least.replace(" %", "")}–${most}`;
}

export function verdictText(lobe) {
  if (lobe.verdict !== "differs") return `${marks[lobe.verdict]} ${lobe.verdict}`;
  return rmseText(lobe) ? `✗ differs by ${rmseText(lobe)}` : "✗ differs";
}

const shortVerdict = (lobe) => lobe.verdict === "agrees" ? "✓" : lobe.verdict === "insufficient" ? isCut(lobe) ? "? cut" : "? noise" :
  rmseText(lobe) ? `✗ ${rmseText(lobe)}` : "✗ differs";

export function compare(page, answer, details) {
  const {grid, channels, runs} = details;
  const columns = grid.folded ? grid.phi_cells / 2 : grid.phi_cells, cells = grid.mu_cells * columns;
  // What interfaces make, order 0 and the sum of the others, is there where they do.
  const orders = allOrders.filter((o) => Object.keys(details.truth).some((key) => key.endsWith(`/${o}`)));
  const sides = ["reflect", "transmit"].filter((s) => runs.some((r, k) => details.truth[`${k}/${s}/all`]));
  const names = answer.models.map((m, k) => nameOf(answer.models, k));
  const state = {run: Math.min(runs.length - 1, Math.floor(runs.length / 2)), side: "reflect", order: "all",
    channel: channels === 1 ? "Y" : "luminance", model: 0, plane: 0, scale: "linear"};
  if (answer.models[0]?.lobes.length && !lobeOf(0)) state.order = answer.models[0].lobes[0].order;

  const bound = answer.estimator === "deterministic";
  const errorName = bound ? "error bound" : "standard error", bandText = bound ? "± error bound" : "± 2 standard errors";
  const bandWidth = bound ? 1 : 2;
  const cut = answer.models.some((m) => m.lobes.some(isCut));

  function sameRun(lobe, run) {
    return Math.abs(lobe.mu_i - run.mu_i) < 1e-12 && Math.abs(lobe.phi_i - run.phi_i) < 1e-9;
  }
  function lobeOf(model, run = state.run, side = state.side, order = state.order) {
    return answer.models[model]?.lobes.find((l) => l.side === side && l.order === order && sameRun(l, runs[run]));
  }

  const cache = new Map();
  // One channel (or luminance) of a map; `spread`: of errors, which add up where channels share
  // walks.
  function map(text) {
    if (!text) return null;
    const key = `${state.channel}:${text.length}:${text}`;
    if (!cache.has(key)) {
      const all = floats(text);
      const c = {Y: 0, R: 0, G: 1, B: 2}[state.channel];
      cache.set(key, c === undefined ? Float64Array.from({length: cells}, (_, k) =>
        luminance([all[k], all[cells + k], all[2 * cells + k]]))
        : all.subarray(c * cells, (c + 1) * cells));
      if (cache.size > 400) cache.delete(cache.keys().next().value);
    }
    return cache.get(key);
  }
  const key = () => `${state.run}/${state.side}/${state.order}`;
  const truthMap = () => map(details.truth[key()]?.f), errorMap = () => map(details.truth[key()]?.se);
  const modelMap = (m) => map(details.models[m]?.[key()]);
  const ofChannel = (list) => list.length === 1 || state.channel === "luminance" ? luminance(list) : list["RGB".indexOf(state.channel)];
  const channelText = () => channels === 1 ? "" : `, ${state.channel === "luminance" ? luminanceName : state.channel}`;

  // The cells on both sides of a direction phi, [column, ...].
  function columnsAt(phi) {
    const at = ((phi / 360 * grid.phi_cells) % grid.phi_cells + grid.phi_cells) % grid.phi_cells;
    const near = Math.abs(at - Math.round(at)) < 1e-9
      ? [Math.round(at) - 1, Math.round(at)] : [Math.floor(at)];
    return [...new Set(near.map((k) => {
      const wrapped = (k + grid.phi_cells) % grid.phi_cells;
      return grid.folded && wrapped >= columns ? grid.phi_cells - 1 - wrapped : wrapped;
    }))];
  }
  // [theta, value, error] along the plane, from the far side's horizon to the near side's.
  function slice(values, errors) {
    const points = [];
    const half = (phi, sign) => {
      const at = columnsAt(phi);
      for (let row = 0; row < grid.mu_cells; ++row) {
        let sum = 0, square = 0;
        for (const k of at) {
          sum += values[row * columns + k] / at.length;
          square += errors ? (errors[row * columns + k] / at.length) ** 2 : 0;
        }
        points.push([sign * thetaOf(Math.sqrt(1 - (row + .5) / grid.mu_cells)), sum, Math.sqrt(square)]);
      }
    };
    half(state.plane + 180, -1);
    points.reverse();
    half(state.plane, 1);
    return points;
  }

  const controls = element("section", {class: "controls", "aria-label": "What is shown"});
  const polar = element("div", {class: "chart tall"}), plane = element("div", {class: "chart tall"});
  const albedo = element("div", {class: "chart"});
  const polarKey = element("div"), planeKey = element("div"), albedoKey = element("div");
  const polarFigure = figure("Polar", "", [polar, polarKey]), planeFigure = figure("Along the plane", "", [plane, planeKey]);
  const albedoFigure = figure("Albedo", "", [albedo, albedoKey]);
  const reading = element("p", {class: "reading", "aria-live": "off"});
  const read = (x, y) => {
    const cell = cellAt(grid, x, y), truth = truthMap(), se = errorMap(), model = modelMap(state.model);
    if (cell < 0 || !truth) { reading.textContent = ""; return; }
    const row = Math.floor(cell / columns), column = cell % columns, step = 360 / grid.phi_cells;
    const edge = (k) => thetaOf(Math.sqrt(1 - k / grid.mu_cells)).toFixed(1);
    reading.textContent = `θ_o ${edge(row)}–${edge(row + 1)}°, φ ${grid.folded ? "±" : ""}(${column * step}–` +
      `${(column + 1) * step})°: truth ${short(truth[cell])} ± ${short(se[cell], 2)}` +
      (model ? `, ${names[state.model]} ${short(model[cell])}, difference ${short(model[cell] - truth[cell])}` +
        (se[cell] > 0 ? `, ${bound ? "over its bound" : "z"} ${short((model[cell] - truth[cell]) / se[cell])}` : "") : "") + " sr⁻¹";
  };
  const discs = [new Disc("Truth", read), new Disc("Model", read), new Disc("Signed error", read), new Disc(bound ? "Error over bound" : "z", read)];
  const matrices = element("div", {class: "models"}), table = element("div");
  const drawing = element("div", {class: "stack panel"});

  page.append(heading(answer, `${answer.stack.name}: closed forms against ground truth`, [
      `${answer.estimator} estimator`, answer.walks ? `${answer.walks.toLocaleString("en")} walks per direction` : "",
      bound ? `tolerance ${short(answer.tolerance)}` : "", answer.estimator_asked === "auto" ? `auto: ${answer.estimator_reason}` : "",
      answer.interrupted ? "interrupted: what was done until then" : ""]),
    element("div", {class: "columns"},
      element("section", {}, element("h2", {}, "Stack"), drawing),
      element("section", {}, element("h2", {}, "Verdicts"),
        element("p", {class: "quiet"}, bound
          ? `✓ agrees: no difference beyond the truth's bound, which could hide none above ${percent(answer.agrees_within)}; ✗ differs, by the relative RMSE; ? the bound is too wide to tell. Choose a cell to look at that lobe.`
          : `✓ agrees: no difference beyond the noise, which could hide none above ${percent(answer.agrees_within)}; ✗ differs, by the relative RMSE without the noise; ? too noisy to tell. Choose a cell to look at that lobe.`),
        cut ? element("p", {class: "quiet", id: "cut"}, "Walks were cut: the truth's energies may be too low by what stands under “Missing”, all lobes together, and a cell's f by that over its projected solid angle. Verdicts hold wherever that light belongs: ✗ with a range of the relative RMSE, “? cut” where it decides.") : null, matrices)),
    element("h2", {}, "Lobes"), controls,
    element("div", {class: "halves"}, polarFigure, planeFigure),
    element("h2", {}, "Hemisphere"),
    element("div", {class: "maps"}, discs.map((d) => d.node)), reading,
    element("p", {class: "quiet"}, "Each disc is the hemisphere seen along z: the normal in the middle, the horizon at " +
      "the rim, radius sin θ_o, φ = 0 (the side of the light) on the right. The ring marks w_i; with a cross, the " +
      "straight-through direction −w_i. f in sr⁻¹ without the cosine, mean over each cell."),
    element("h2", {}, "Albedo"), albedoFigure,
    ...previews(answer.previews, details.previews), ...sideBySide(answer.side_by_side, channels),
    element("h2", {}, "All numbers"), element("p", {class: "quiet"}, bound
      ? "z verdict: whether every cell is within the truth's bound; p is then 1 or 0."
      : "z verdict: whether the differences in units of their standard errors could be chance, p the probability of larger ones; 1 % chance of any false ✗ in a page of true models."), table);
  function controlsNow() {
    const choose = (name) => (value) => { state[name] = value; show(name); };
    const list = [
      choice("run", "Incident direction", runs.map((r, k) => ({value: k, label: degrees(r.theta_i) +
        (r.phi_i ? `, ${degrees(r.phi_i)}` : "")})), state.run, choose("run")),
      choice("side", "Side", ["reflect", "transmit"].map((s) => ({value: s, label: sideText[s],
        disabled: !sides.includes(s)})), state.side, choose("side")),
      choice("order", "Scattering order", orders.map((o) => ({value: o, label: o})), state.order, choose("order")),
    ];
    if (channels === 3) list.push(choice("channel", "Channel", ["luminance", "R", "G", "B"].map((c) =>
      ({value: c, label: c === "luminance" ? luminanceName : c})), state.channel, choose("channel")));
    if (names.length) list.push(choice("model", "Model in maps", names.map((n, k) => ({value: k, label: n})),
      state.model, choose("model")));
    list.push(choice("plane", "Plane of the plots", [0, 45, 90, 135].filter((p) => !(grid.folded && p === 135)).map((p) => ({value: p, label: `φ ${p}°`})), state.plane,
      choose("plane")),
      choice("scale", "Scale", ["linear", "log"].map((s) => ({value: s, label: s})), state.scale, choose("scale")));
    controls.replaceChildren(...list);
  }

  function showPlots() {
    const truth = truthMap();
    const text = `θ_i ${degrees(runs[state.run].theta_i)}, ${sideText[state.side]}, ${orderText(state.order)}` +
      (channels === 3 ? `, ${state.channel}` : "");
    for (const f of [polarFigure, planeFigure]) f.querySelector("figcaption .quiet")?.remove();
    polarFigure.querySelector("figcaption").append(element("span", {class: "quiet"}, `f [sr⁻¹], ${text}`));
    planeFigure.querySelector("figcaption").append(element("span", {class: "quiet"}, `f [sr⁻¹], ${text}`));
    const points = truth ? slice(truth, errorMap()) : [];
    const curves = names.map((name, m) => modelMap(m) && {name, m, points: slice(modelMap(m))}).filter(Boolean);
    const log = state.scale === "log";
    let high = 0, least = Infinity;
    for (const [, v] of [...points, ...curves.flatMap((c) => c.points)]) {
      high = Math.max(high, v);
      if (v > 0) least = Math.min(least, v);
    }
    if (!(least < Infinity)) least = high = 1;
    const bottom = 10 ** Math.max(Math.floor(Math.log10(least)), Math.ceil(Math.log10(high)) - 6);
    const floor = log ? bottom : 0;
    const top = log ? 10 ** Math.ceil(Math.log10(high) + 1e-9) : undefined;
    const kept = (list) => list.map(([x, v]) => [x, v >= floor || !log ? v : null]);
    const envelope = points.map(([x, v, e]) => [x, Math.max(floor, v - bandWidth * e),
      Math.max(floor, v + bandWidth * e)]);
    const bandName = `truth ${bandText}`;
    const lobes = (p, polarAxes) => {
      const at = (list) => polarAxes ? kept(list).map(([x, v]) => [v, x]) : kept(list);
      const where = polarAxes ? {coordinateSystem: "polar"} : {};
      return [
        ...(points.length ? [band(bandName, envelope, p.band, p.edge, where),
          {type: "line", name: "truth", data: at(points), symbol: "circle", symbolSize: 5, z: 5, ...where,
            lineStyle: {color: p.truth, width: 1.6}, itemStyle: {color: p.truth}}] : []),
        ...curves.map(({name, m, points: q}) => ({type: "line", name, data: at(q), showSymbol: false, z: 4,
          symbol: modelSymbol(m), ...where, itemStyle: {color: modelColor(m)},
          lineStyle: {color: modelColor(m), width: 2.4, type: modelDash(m)}}))];
    };
    const key = () => legend([...(points.length ? [{name: "truth", truth: true}, {name: bandText, band: true}] : []),
      ...curves.map((c) => ({name: c.name, model: c.m}))]);
    polarKey.replaceChildren(key());
    planeKey.replaceChildren(key());
    const up = state.side === "reflect";
    chart(plane, `In-plane plot: ${text}`, (p) => ({
      grid: {left: 62, right: 16, top: 14, bottom: 48},
      tooltip: tooltip(p, {valueFormatter: (v) => v === null ? "–" : short(Array.isArray(v) ? v[1] : v, 4)}),
      xAxis: axis(p, `θ_o [degrees], ${state.plane ? `φ ${state.plane}° on the right` : "the light's side on the right"}`,
        {type: "value", min: -90, max: 90, interval: 30}),
      yAxis: axis(p, "", {type: log ? "log" : "value", min: log ? bottom : 0, max: top,
        axisLabel: {color: p.quiet, formatter: (v) => short(v, 3)}}),
      series: lobes(p, false),
    }));
    chart(polar, `Polar plot: ${text}`, (p, {width, height}) => ({
      polar: {center: ["50%", up ? height - 28 : 24], radius: Math.max(40, Math.min(width / 2 - 34, height - 56))},
      angleAxis: {type: "value", min: -90, max: 90, interval: 30, startAngle: up ? 180 : 180, endAngle: up ? 0 : 360,
        clockwise: up, axisLine: {lineStyle: {color: p.line}}, axisTick: {lineStyle: {color: p.line}},
        axisLabel: {color: p.quiet, formatter: (v) => `${Math.abs(v)}°`}, splitLine: {lineStyle: {color: p.grid}}},
      radiusAxis: {type: log ? "log" : "value", min: log ? bottom : 0, max: top, axisLine: {lineStyle: {color: p.line}},
        axisLabel: {color: p.quiet, formatter: (v) => short(v, 2), hideOverlap: true, showMinLabel: false},
        splitNumber: 4, splitLine: {lineStyle: {color: p.grid}}},
      series: [...lobes(p, true),
        {type: "line", coordinateSystem: "polar", name: "w_i", silent: true, showSymbol: true, symbol: ["none", "arrow"],
          data: state.plane === 0 ? incidentRay(log ? [bottom, top] : null, high) : [], z: 6,
          lineStyle: {color: p.quiet, width: 1.5, type: "dotted"}, itemStyle: {color: p.quiet},
          symbolSize: 0}],
    }));
  }

  function incidentRay(decades, high) {
    const theta = runs[state.run].theta_i, from = Math.min(theta, 180 - theta);
    const angle = state.side === "reflect" ? from : -from;
    return [[decades ? decades[0] : 0, angle], [decades ? decades[1] : high, angle]];
  }

  function showDiscs() {
    const truth = truthMap(), se = errorMap(), model = modelMap(state.model), name = names[state.model] ?? "model";
    const run = runs[state.run], sine = Math.sin(run.theta_i * Math.PI / 180);
    const light = {x: state.side === "reflect" ? sine : -sine, y: 0, behind: state.side !== "reflect"};
    const every = [truth, ...names.map((n, m) => modelMap(m))].filter(Boolean);
    const magnitude = magnitudeScale(every, state.scale === "log");
    const difference = truth && model ? model.map((v, k) => v - truth[k]) : null;
    const z = difference ? Float64Array.from(difference, (d, k) => se[k] > 0 ? d / se[k] : NaN) : null;
    const blank = {grid, light, values: null};
    const most = (list) => list ? list.reduce((a, b) => Number.isNaN(b) ? a : Math.max(a, Math.abs(b)), 0) : 0;
    const none = truth ? "has no lobe of this order" : "no light on this side";
    discs[0].show({...blank, values: truth, scale: magnitude, label: `Map of the truth, at most ${short(most(truth))}`,
      note: "f [sr⁻¹]"});
    discs[1].show({...blank, values: model, scale: magnitude, title: names.length ? name : "Model",
      note: model ? "f [sr⁻¹]" : none, label: `Map of ${name}, at most ${short(most(model))}`});
    discs[2].show({...blank, values: difference, scale: signedScale(difference ?? []), note: "model − truth [sr⁻¹]",
      label: `Map of the signed error, at most ${short(most(difference))}`});
    // Errors are many times the solver's bounds, or far below them: decades show how many.
    const ratio = bound && z ? z.map(Math.abs) : z, end = bound ? 1 : 4;
    const beyond = ratio ? ratio.filter((v) => Math.abs(v) > end).length : 0;
    discs[3].show({...blank, values: ratio, scale: bound ? ratioScale(ratio ?? []) : signedScale([], end),
      note: !z ? "" : bound ? `|error| / ${errorName}, logarithmic; ${beyond} of ${cells} cells beyond 1`
        : `error / ${errorName}; ${beyond} of ${cells} cells beyond ±${end}`,
      label: bound ? `Map of the error over its bound, at most ${short(most(z))}` : `Map of z, at most ${short(most(z))}`});
  }

  function showAlbedo() {
    const text = `share of the light ${sideText[state.side]}, ${orderText(state.order)}${channelText()}`;
    albedoFigure.querySelector("figcaption .quiet")?.remove();
    albedoFigure.querySelector("figcaption").append(element("span", {class: "quiet"}, text));
    const energy = (r) => {
      const side = r[ledgerSide[state.side]];
      const part = state.order === "all" ? side : state.order === "2+" ? side.multiple : side.orders[state.order];
      return [Math.abs(r.mu_i), ofChannel(part.total), ofChannel(part.standard_error)];
    };
    const points = runs.map(energy).sort((a, b) => a[0] - b[0]);
    const curves = names.map((name, m) => ({name, m, points: runs.map((r, k) => [lobeOf(m, k), r]).filter(([l]) => l)
      .map(([l, r]) => [Math.abs(r.mu_i), ofChannel(l.energy_model)]).sort((a, b) => a[0] - b[0])}))
      .filter((c) => c.points.length);
    albedoKey.replaceChildren(legend([{name: `truth ${bandText}`, truth: true}, ...curves.map((c) => ({name: c.name, model: c.m}))]));
    chart(albedo, `Albedo against mu: ${text}`, (p) => ({
      grid: {left: 62, right: 16, top: 14, bottom: 48},
      tooltip: tooltip(p, {valueFormatter: (v) => short(Array.isArray(v) ? v[1] : v, 5)}),
      xAxis: axis(p, "μ_i = cos θ_i", {type: "value", min: 0, max: 1}),
      yAxis: axis(p, "", {type: "value", scale: true, axisLabel: {color: p.quiet, formatter: (v) => short(v, 4)}}),
      series: [errorBars("truth error", points.map(([x, v, e]) => [x, v - bandWidth * e, v + bandWidth * e]), p.truth),
        {type: "line", name: "truth", data: points.map(([x, v]) => [x, v]), z: 5, symbol: "circle", symbolSize: 7,
          lineStyle: {color: p.truth, width: 1.2}, itemStyle: {color: p.truth}},
        ...curves.map(({name, m, points: q}) => ({type: "line", name, data: q, symbol: modelSymbol(m), symbolSize: 8,
          itemStyle: {color: modelColor(m)}, lineStyle: {color: modelColor(m), type: modelDash(m), width: 2.4}}))],
    }));
  }

  function showMatrices() {
    // "key = value (where it comes from)"
    const told = (m) => details.parameters[m];
    const rowsOf = (model, m) => {
      const rows = [];
      for (const side of ["reflect", "transmit"]) for (const order of orders) {
        if (!model.lobes.some((l) => l.side === side && l.order === order)) continue;
        rows.push(element("tr", {}, element("th", {scope: "row"}, `${sideText[side]} ${order}`),
          runs.map((r, k) => {
            const lobe = lobeOf(m, k, side, order);
            if (!lobe) return element("td");
            const chosen = m === state.model && k === state.run && side === state.side && order === state.order;
            return element("td", {}, element("button", {class: `mark ${lobe.verdict}`, type: "button",
              "aria-pressed": String(chosen), title: `${names[m]}, θ_i ${degrees(r.theta_i)}, ${side} ${order}: ` +
                `${verdictText(lobe)}; energy${channelText()} ${short(ofChannel(lobe.energy_model), 4)}, truth ${short(ofChannel(lobe.energy_truth), 4)}; maximum ${short(lobe.max_error)} sr⁻¹`, onclick: () => {
                Object.assign(state, {model: m, run: k, side, order});
                show("cell");
              }}, shortVerdict(lobe)));
          })));
      }
      return rows;
    };
    matrices.replaceChildren(answer.models.length ? scrolling("Verdicts", element("table", {class: "matrix"},
      element("thead", {}, element("tr", {}, element("td", {}, "θ_i"), runs.map((r) =>
        element("th", {scope: "col"}, degrees(r.theta_i) + (r.phi_i ? `, ${degrees(r.phi_i)}` : ""))))),
      answer.models.map((model, m) => element("tbody", {class: "model", "data-model": names[m]},
        element("tr", {}, element("th", {class: "name", scope: "rowgroup", colspan: runs.length + 1}, element("strong", {}, breakable(names[m])),
          element("span", {class: "quiet"}, breakable([model.ns_per_eval ? `${short(model.ns_per_eval)} ns per evaluation` : "", ...told(m)].filter(Boolean).join(", "))))),
        rowsOf(model, m)))))
      : element("p", {}, "No closed form applies to this stack: name one with --model."));
  }

  function showTable() {
    const head = ["Model", "θ_i", "Side", "Order", "z verdict", `Energy, truth${channelText()}`, "±", ...(cut ? ["Missing"] : []), `Energy, model${channelText()}`, "Rel. RMSE",
      "Without noise", "Maximum", "p", "ns / eval"];
    const text = new Set([0, 2, 3, 4]);
    const rows = answer.models.flatMap((model, m) => model.lobes.map((l, k) => {
      const chosen = m === state.model && l === lobeOf(m);
      const number = (field, value, shown) => element("td", {"data-field": field, "data-value": value}, shown);
      return element("tr", {class: chosen ? "chosen" : null, "data-model": m, "data-lobe": k},
        element("td", {class: "text name"}, breakable(names[m])),
        number("mu_i", l.mu_i, degrees(thetaOf(l.mu_i))),
        element("td", {class: "text"}, sideText[l.side]), element("td", {class: "text"}, l.order),
        element("td", {class: "text"}, element("span", {class: `mark ${l.verdict}`}, verdictText(l))),
        number("energy_truth", ofChannel(l.energy_truth), ofChannel(l.energy_truth).toFixed(5)),
        number("energy_standard_error", ofChannel(l.energy_standard_error), short(ofChannel(l.energy_standard_error), 2)),
        cut ? number("energy_missing", ofChannel(l.energy_missing), isCut(l) ? `≤ ${short(ofChannel(l.energy_missing), 2)}` : "none") : null,
        number("energy_model", ofChannel(l.energy_model), ofChannel(l.energy_model).toFixed(5)),
        number("relative_rmse", l.relative_rmse, percent(l.relative_rmse)),
        number("relative_rmse_without_noise", l.relative_rmse_without_noise, percent(l.relative_rmse_without_noise)),
        number("max_error", l.max_error, short(l.max_error)),
        number("p_value", l.p_value, short(l.p_value, 2)), number("ns_per_eval", model.ns_per_eval, short(model.ns_per_eval)));
    }));
    table.replaceChildren(scrolling("All numbers", element("table", {id: "numbers"},
      element("thead", {}, element("tr", {}, head.map((h, k) => element("th", {scope: "col", class: text.has(k) ? "text" : null}, h)))),
      element("tbody", {}, rows))));
  }

  function show(changed) {
    // The chosen radio button keeps the focus: the controls are made anew only when something else
    // moved them.
    if (changed === undefined || changed === "cell") controlsNow();
    drawing.replaceChildren(stackDrawing(answer.stack, runs[state.run].theta_i));
    const active = document.activeElement?.closest?.(".matrix button");
    const place = active ? [...matrices.querySelectorAll("button")].indexOf(active) : -1;
    showMatrices();
    if (place >= 0) matrices.querySelectorAll("button")[place]?.focus();
    showPlots();
    showDiscs();
    showAlbedo();
    showTable();
  }
  show();
}

// Explicit geometry against the media that stand for it, and those against their closed forms.
function sideBySide(rows, channels) {
  if (!rows?.length) return [];
  const head = ["θ_i", "Order", "Medium", "Energy, geometry", "Energy, medium", "Medium off the geometry by", "Closed form", "Energy, model", "off the medium by", "off the geometry by"];
  return [element("h2", {}, "Geometry, medium, closed form"), channels === 1 ? "" : element("p", {class: "quiet"}, `Energies: ${luminanceName}.`),
    element("p", {class: "quiet"}, "“Off A by” is the relative RMSE of the cells without noise, over the root mean square of A: the same as “Without noise” below, where A is the truth."), scrolling("Geometry, medium, closed form", element("table", {}, element("thead", {}, element("tr", {},
    head.map((h) => element("th", {scope: "col"}, h)))), element("tbody", {}, rows.map((r) => element("tr", {}, [degrees(thetaOf(r.mu_i)), r.order, breakable(r.medium),
      r.energy_geometry.toFixed(5), r.energy_medium.toFixed(5), percent(r.relative_rmse_of_medium), breakable(r.model ?? "–"), r.model ? r.energy_model.toFixed(5) : "–",
      percent(r.relative_rmse_of_model), percent(r.relative_rmse_of_both)].map((t) => element("td", {}, t)))))))];
}

// Two requests of one model are told apart by what differs.
function nameOf(models, k) {
  return models[k].label ?? models[k].name;
}
