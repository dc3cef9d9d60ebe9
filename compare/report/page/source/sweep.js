// The page of `lamella sweep`: how an error, or a furnace, depends on parameters.
import {breakable, element, choice, figure, scrolling} from "./dom.js";
import {axis, chart, legend, modelColor, modelDash, modelSymbol, tooltip} from "./charts.js";
import {degrees, luminance, luminanceName, percent, short, thetaOf} from "./numbers.js";
import {heading} from "./heading.js";
import {heatMap} from "./heat.js";
import {stackDrawing} from "./stack.js";

const orders = ["0", "1", "2", "3", "4+", "1+", "2+", "all"];
const marks = {agrees: "✓", differs: "✗", insufficient: "?", pass: "✓", fail: "✗", inconclusive: "?"};
const words = {reflect: "reflected", transmit: "transmitted"};

export function sweep(page, answer) {
  const {axes, points} = answer, ofFurnace = answer.of === "furnace";
  const first = points[0]?.answer;
  const title = `${answer.stack.name}: ${ofFurnace ? "white furnace" : "closed forms against ground truth"} over ${axes.map((a) => a.path).join(" × ")}`;
  page.append(heading(answer, title, [`${points.length} of ${axes.reduce((n, a) => n * a.values.length, 1)} points`]));
  if (!first) { page.append(element("p", {}, "No point is done yet: run the same command again.")); return; }
  const series = ofFurnace && !first.models ? [answer.stack.name] : first.models.map((m, k) => first.models.filter((o) => o.name === m.name).length > 1 ? `${m.name}_${k}` : m.name);
  const runs = ofFurnace ? (first.models ?? [first])[0].runs : uniqueRuns(first);
  const lobes = ofFurnace ? [] : first.models.flatMap((m) => m.lobes);
  const sides = [...new Set(lobes.map((l) => l.side))], hasOrders = orders.filter((o) => lobes.some((l) => l.order === o));
  const inColour = (ofFurnace ? runs[0]?.energy : lobes[0]?.energy_model)?.length === 3;
  const quantities = ofFurnace ? {miss: `energy − 1${inColour ? `, ${luminanceName}` : ""}`} : {error: "error without noise", energy: `energy of the model / truth − 1${inColour ? `, ${luminanceName}` : ""}`};
  const state = {model: 0, run: 0, side: sides[0], order: hasOrders.includes("all") ? "all" : hasOrders[0], quantity: Object.keys(quantities)[0],
    x: 0, y: Math.min(1, axes.length - 1), fixed: axes.map(() => 0)};

  function uniqueRuns(a) {
    const seen = new Map();
    for (const l of a.models.flatMap((m) => m.lobes)) seen.set(`${l.mu_i}/${l.phi_i}`, {mu_i: l.mu_i, phi_i: l.phi_i});
    return [...seen.values()];
  }
  function cellOf(point, model) {
    const run = runs[state.run];
    const same = (r) => Math.abs(r.mu_i - run.mu_i) < 1e-12 && Math.abs(r.phi_i - run.phi_i) < 1e-9;
    if (ofFurnace) {
      const r = (point.answer.models ? point.answer.models[model] : point.answer)?.runs.find(same);
      return r && {value: luminance(r.energy) - 1, verdict: r.verdict, mark: `${marks[r.verdict]}`};
    }
    const l = point.answer.models[model]?.lobes.find((e) => e.side === state.side && e.order === state.order && same(e));
    if (!l) return null;
    const error = l.relative_rmse_without_noise === "inf" ? Infinity : l.relative_rmse_without_noise;
    const value = state.quantity === "error" ? error : luminance(l.energy_model) / luminance(l.energy_truth) - 1;
    return {value, verdict: l.verdict, mark: marks[l.verdict]};
  }

  const controls = element("section", {class: "controls", "aria-label": "What is shown"});
  const plot = element("div", {class: "chart map"}), key = element("div"), drawing = element("div", {class: "stack panel"});
  const plotFigure = figure("Over the parameters", "", [plot, key]), table = element("div");
  page.append(controls, element("div", {class: "columns"}, element("section", {}, drawing), element("section", {}, plotFigure,
    element("p", {class: "quiet"}, ofFurnace ? "✓ pass, ✗ fail, ? inconclusive." : "✓ agrees within the noise, ✗ differs, ? too noisy to tell."))),
    element("h2", {}, "All numbers"), table);
  drawing.append(stackDrawing(answer.stack, thetaOf(runs[0].mu_i)), element("p", {class: "quiet"}, "The stack as given, before ", axes.map((a) => a.path).join(", "), " is set."));

  const inPlane = (p) => axes.every((a, k) => k === state.x || k === state.y || p.at[k] === state.fixed[k]);
  function show() {
    const shown = points.filter(inPlane), text = [quantities[state.quantity], `θ_i ${degrees(thetaOf(runs[state.run].mu_i))}`,
      ...(ofFurnace ? [] : [words[state.side], state.order === "all" ? "all orders" : `order ${state.order}`])].join(", ");
    plotFigure.querySelector("figcaption").replaceChildren(...breakable(axes.length > 1 ? `${series[state.model]} ` : ""), element("span", {class: "quiet"}, text));
    const asText = (v) => state.quantity === "error" ? percent(v) : short(v, 2);
    if (axes.length === 1) {
      key.replaceChildren(legend(series.map((name, k) => ({name, model: k}))));
      chart(plot, text, (p) => ({grid: {left: 64, right: 20, top: 16, bottom: 50}, tooltip: tooltip(p, {valueFormatter: (v) => asText(Array.isArray(v) ? v[1] : v)}),
        xAxis: axis(p, axes[0].path, {type: isLog(axes[0].values) ? "log" : "value", min: Math.min(...axes[0].values), max: Math.max(...axes[0].values), axisLabel: {color: p.quiet, formatter: (v) => short(v)}}),
        yAxis: axis(p, "", {type: "value", axisLabel: {color: p.quiet, formatter: (v) => asText(v)}}),
        series: series.map((name, k) => ({type: "line", name, symbol: modelSymbol(k), symbolSize: 9, itemStyle: {color: modelColor(k)},
          lineStyle: {color: modelColor(k), type: modelDash(k), width: 2.2},
          label: {show: true, formatter: ({data}) => data.mark, color: p.text, position: "top"},
          data: shown.map((q) => ({q, c: cellOf(q, k)})).filter(({c}) => c && Number.isFinite(c.value)).map(({q, c}) => ({value: [axes[0].values[q.at[0]], c.value], mark: c.mark}))}))}));
    } else {
      key.replaceChildren();
      const cells = shown.map((q) => ({q, c: cellOf(q, state.model)})).filter(({c}) => c);
      heatMap(plot, text, {x: {name: axes[state.x].path, values: axes[state.x].values.map((v) => short(v))},
        y: {name: axes[state.y].path, values: axes[state.y].values.map((v) => short(v))}, signed: state.quantity !== "error", asText,
        cells: cells.map(({q, c}) => ({i: q.at[state.x], j: q.at[state.y], value: c.value, mark: c.mark,
          tip: `${axes[state.x].path} ${short(axes[state.x].values[q.at[state.x]])}<br>${axes[state.y].path} ${short(axes[state.y].values[q.at[state.y]])}<br>${asText(c.value)} ${c.verdict}`}))});
    }
    table.replaceChildren(scrolling("All numbers", element("table", {id: "numbers"}, element("thead", {}, element("tr", {}, axes.map((a) => element("th", {scope: "col"}, breakable(a.path))),
      series.map((s) => element("th", {scope: "col"}, breakable(s))))), element("tbody", {}, points.map((q, i) => element("tr", {"data-point": i}, q.at.map((k, a) => element("td", {}, short(axes[a].values[k], 4))),
        series.map((_, m) => { const c = cellOf(q, m); return element("td", {"data-model": m, "data-value": c ? c.value : ""}, c ? element("span", {class: `mark ${c.verdict}`}, `${c.mark} ${asText(c.value)}`) : "–"); })))))));
  }
  const choose = (name, index) => (v) => { if (index === undefined) state[name] = v; else state[name][index] = v; show(); };
  const switches = [];
  if (axes.length > 1 && series.length > 1) switches.push(choice("model", "Model", series.map((s, k) => ({value: k, label: s})), 0, choose("model")));
  switches.push(choice("run", "Incident direction", runs.map((r, k) => ({value: k, label: degrees(thetaOf(r.mu_i)) + (r.phi_i ? `, ${degrees(r.phi_i)}` : "")})), 0, choose("run")));
  if (sides.length > 1) switches.push(choice("side", "Side", sides.map((s) => ({value: s, label: words[s]})), state.side, choose("side")));
  if (hasOrders.length > 1) switches.push(choice("order", "Scattering order", hasOrders.map((o) => ({value: o, label: o})), state.order, choose("order")));
  if (!ofFurnace) switches.push(choice("quantity", "Quantity", Object.entries(quantities).map(([value, label]) => ({value, label})), state.quantity, choose("quantity")));
  axes.forEach((a, k) => { if (k > 1) switches.push(choice(`fixed${k}`, a.path, a.values.map((v, i) => ({value: i, label: short(v)})), 0, choose("fixed", k))); });
  controls.append(...switches);
  show();
}

function isLog(values) {
  if (values.length < 3 || values.some((v) => !(v > 0))) return false;
  const ratio = values[1] / values[0];
  return values.every((v, k) => k === 0 || Math.abs(v / values[k - 1] / ratio - 1) < 1e-6);
}
