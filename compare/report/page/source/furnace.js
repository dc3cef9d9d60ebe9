// The page of `lamella furnace`: the energy that leaves, per incident direction.
import {breakable, element, choice, figure, scrolling} from "./dom.js";
import {axis, chart, errorBars, legend, modelColor, modelDash, modelSymbol, tooltip} from "./charts.js";
import {degrees, short, thetaOf} from "./numbers.js";
import {heading} from "./heading.js";
import {stackDrawing} from "./stack.js";

const marks = {pass: "✓ pass", fail: "✗ fail", inconclusive: "? inconclusive"};
const fate = {loss: "loss", gain: "gain", both: "loss and gain"};
const symbols = {pass: "circle", fail: "rect", inconclusive: "diamond"};
export const verdictMark = (v) => element("span", {class: `mark ${v}`}, marks[v]);

export function furnace(page, answer, details) {
  const bound = answer.estimator === "deterministic";
  const models = answer.models, channels = (models ?? [answer])[0].runs[0].energy.length;
  const series = (models ?? [{name: answer.stack.name, runs: answer.runs}]);
  const grey = series.every((s) => s.runs.every((r) => r.energy.every((e) => e === r.energy[0])));
  const names = channels === 1 || grey ? ["energy"] : ["R", "G", "B"];
  const state = {channel: names[0]};
  const index = () => Math.max(0, names.indexOf(state.channel));
  const energies = element("div", {class: "chart tall"}), energyKey = element("div");
  const ledger = element("div", {class: "chart tall"}), ledgerKey = element("div");
  const energyFigure = figure("Energy that leaves", "1 = all that came in", [energies, energyKey]);
  const controls = element("section", {class: "controls", "aria-label": "What is shown"});
  const drawing = element("div", {class: "stack panel"});

  // Most closed forms know of no stack.
  const hasStack = !models || details?.needs_stack;
  page.append(heading(answer, `${hasStack ? `${answer.stack.name}: w` : "W"}hite furnace${models ? ` of ${models.map((m) => m.name).join(", ")}` : ""}`,
      [answer.estimator ? `${answer.estimator} estimator` : "", answer.tolerance !== undefined ? `tolerance ${short(answer.tolerance)}` : "",
        answer.interrupted ? "interrupted: what was done until then" : ""]),
    element("p", {class: "overall"}, verdictMark(answer.verdict), " ", answer.verdict === "pass"
      ? "No energy is lost or made." : answer.verdict === "fail" ? "Energy is lost or made, beyond the noise."
      : "What was cut off, or the noise, is more than the furnace may miss."),
    element("p", {class: "quiet"}, answer.criterion));
  if (names.length > 1) page.append(controls);
  page.append(element("div", {class: hasStack ? "columns" : null},
      hasStack ? element("section", {}, element("h2", {}, "Stack"), drawing) : null,
      element("section", {}, element("h2", {}, "Energy"), energyFigure)));
  if (!models) page.append(element("h2", {}, "Where the light goes"), figure("Ledger", "shares of the light that came in", [ledger, ledgerKey]));
  const table = element("div");
  page.append(element("h2", {}, "All numbers"), table);
  if (hasStack) drawing.append(stackDrawing(answer.stack, thetaOf(series[0].runs[Math.floor(series[0].runs.length / 2)].mu_i)));

  const parts = ["reflected", "transmitted", "uncollided", "absorbed", "unresolved",
    ...(!models && answer.runs.some((r) => r.lost) ? ["lost"] : [])];
  function show() {
    const c = index();
    energyKey.replaceChildren(legend([...series.map((s, m) => ({name: s.name, model: m, symbol: "none"})),
      ...(models ? [] : [{name: bound ? "± error bound" : "± 2 standard errors", color: "currentColor", symbol: "none"}]),
      {name: "pass", color: "currentColor", symbol: "circle", lineless: true}, {name: "fail", color: "currentColor", symbol: "rect", lineless: true},
      {name: "inconclusive", color: "currentColor", symbol: "diamond", lineless: true}]));
    chart(energies, "Energy that leaves against the incident angle", (p) => ({
      grid: {left: 70, right: 16, top: 18, bottom: 48},
      tooltip: tooltip(p, {valueFormatter: (v) => short(Array.isArray(v) ? v[1] : v, 6)}),
      xAxis: axis(p, "θ_i [degrees]", {type: "value", min: 0, max: series.some((s) => s.runs.some((r) => r.mu_i < 0)) ? 180 : 90}),
      yAxis: axis(p, "", {type: "value", scale: true, axisLabel: {color: p.quiet, formatter: (v) => short(v, 6), showMinLabel: false, showMaxLabel: false},
        min: ({min, max}) => Math.min(min, 1) - Math.max(1e-4, .15 * (Math.max(max, 1) - Math.min(min, 1))),
        max: ({min, max}) => Math.max(max, 1) + Math.max(1e-4, .15 * (Math.max(max, 1) - Math.min(min, 1)))}),
      series: series.flatMap((s, m) => {
        const points = s.runs.map((r) => ({value: [thetaOf(r.mu_i), r.energy[c] ?? r.energy[0]], r})).sort((a, b) => a.value[0] - b.value[0]);
        const line = {type: "line", name: s.name, z: 5, lineStyle: {color: modelColor(m), type: modelDash(m), width: 1.6},
          data: points.map(({value, r}) => ({value, symbol: symbols[r.verdict], symbolSize: r.verdict === "pass" ? 9 : 13})),
          itemStyle: {color: modelColor(m), borderColor: p.text, borderWidth: 1},
          markLine: {silent: true, symbol: "none", lineStyle: {color: p.text, type: "solid", width: 1}, label: {show: false}, data: [{yAxis: 1}]}};
        return models ? [line] : [line, errorBars("error", points.map(({value: [x, y], r}) =>
          [x, y - (bound ? 1 : 2) * r.energy_standard_error[c], y + (bound ? 1 : 2) * r.energy_standard_error[c]]), modelColor(m))];
      })}));
    if (!models) {
      ledgerKey.replaceChildren(legend(parts.map((name, k) => ({name, model: k, symbol: "rect", lineless: true}))));
      const runs = [...answer.runs].sort((a, b) => b.mu_i - a.mu_i);
      const of = (r, name) => name === "reflected" || name === "transmitted" ? r[name].total[c] : r[name][c];
      chart(ledger, "Shares of the light per incident direction", (p) => ({
        grid: {left: 70, right: 16, top: 14, bottom: 48}, tooltip: tooltip(p, {valueFormatter: (v) => short(v, 5)}),
        xAxis: axis(p, "share", {type: "value", min: 0, max: 1}),
        yAxis: axis(p, "", {type: "category", inverse: true, data: runs.map((r) => `θ_i ${degrees(thetaOf(r.mu_i))}`), axisLabel: {color: p.text}}),
        series: parts.map((name, k) => ({type: "bar", stack: "all", name, barWidth: "55%", data: runs.map((r) => of(r, name)),
          itemStyle: {color: modelColor(k), borderColor: p.back, borderWidth: 1}}))}));
    }
    const number = (field, value, digits) => element("td", {"data-field": field, "data-value": value},
      digits ? value.toFixed(digits) : short(value, 2));
    const head = models ? ["θ_i", "Energy", "Energy − 1", "Verdict"]
      : ["θ_i", "Energy", "±", "Reflected", "Transmitted", "Uncollided", "Absorbed", "Unresolved",
        ...(answer.runs?.some((r) => r.thinned) ? ["Thinned"] : []), "Walks", "Verdict"];
    const radiance = answer.runs?.some((r) => r.radiance), listed = head.includes("Thinned") ? [...parts, "thinned"] : parts;
    if (radiance && !models) head.splice(-1, 0, "Radiance", "Predicted");
    table.replaceChildren(scrolling("All numbers", element("table", {id: "numbers"},
      element("thead", {}, element("tr", {}, models ? element("th", {class: "text"}, "Model") : null,
        head.map((h) => element("th", {scope: "col", class: h === "Verdict" ? "text" : null}, h)))),
      element("tbody", {}, series.flatMap((s, m) => s.runs.map((r, k) => element("tr", {"data-model": m, "data-run": k},
        models ? element("td", {class: "text name"}, breakable(s.name)) : null,
        number("mu_i", r.mu_i, 0), number("energy", r.energy[c], 6),
        models ? element("td", {}, `${short(r.energy[c] - 1, 2)}${r.energy_error[c] > 1e-9 ? ` ± ${short(r.energy_error[c], 2)}` : ""}`) : [number("energy_standard_error", r.energy_standard_error[c]),
          ...listed.map((name) => number(name, name === "reflected" || name === "transmitted" ? r[name].total[c] : r[name][c], 6)),
          element("td", {}, r.walks.toLocaleString("en")),
          ...(radiance ? [element("td", {}, r.radiance ? `${r.radiance.measured.toFixed(4)} ± ${short(r.radiance.standard_error, 1)}` : "–"),
            element("td", {}, r.radiance ? `${r.radiance.predicted.toFixed(4)} ± ${short(r.radiance.predicted_standard_error, 1)}` : "–")] : [])],
        element("td", {class: "text"}, verdictMark(r.verdict), r.loss_or_gain === "none" ? "" : `: ${fate[r.loss_or_gain]}`))))))));
    for (const cell of table.querySelectorAll("[data-field=mu_i]")) cell.textContent = degrees(thetaOf(Number(cell.dataset.value)));
  }
  if (names.length > 1) controls.append(choice("channel", "Channel", names.map((n) => ({value: n, label: n})), state.channel,
    (v) => { state.channel = v; show(); }));
  show();
}
