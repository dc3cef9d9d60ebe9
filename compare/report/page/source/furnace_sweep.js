// The page of `lamella furnace --sweep`: closed forms over the range of their parameters.
import {breakable, element, choice, figure, scrolling} from "./dom.js";
import {degrees, short} from "./numbers.js";
import {heading} from "./heading.js";
import {heatMap} from "./heat.js";

const tolerance = 1e-3;  // what a closed form may miss, as for `lamella furnace --model`

export function furnaceSweep(page, answer) {
  const models = answer.sweep, state = {model: 0, fixed: []};
  const plot = element("div", {class: "chart map"}), plotFigure = figure("Energy − 1", "", [plot]);
  const controls = element("section", {class: "controls", "aria-label": "What is shown"});
  const passes = (e) => Math.abs(e - 1) <= tolerance;
  page.append(heading(answer, "White furnaces of closed forms over their parameters", [`${models.length} ${models.length === 1 ? "model" : "models"}`]),
    controls, plotFigure, element("p", {class: "quiet"}, `Energy that leaves less what came in, albedo and f0 at 1. ✓ within ${short(tolerance)}, ✗ energy is lost (below 0) or made (above).`),
    element("h2", {}, "All models"), table());

  function show() {
    const model = models[state.model], [axis, ...others] = model.axes, angles = answer.theta_i;
    const stride = model.axes.map((_, k) => model.axes.slice(0, k).reduce((n, a) => n * a.values.length, 1));
    const base = others.reduce((n, a, k) => n + (state.fixed[k] ?? 0) * stride[k + 1], 0);
    const named = others.map((a, k) => `${a.name} ${a.values[state.fixed[k] ?? 0]}`);
    plotFigure.querySelector("figcaption .quiet")?.remove();
    plotFigure.querySelector("figcaption").append(element("span", {class: "quiet"}, breakable([model.name, ...named].join(", "))));
    const nice = (v) => Number.isNaN(Number(v)) ? v : short(Number(v));
    const xs = axis ? axis.values.map(nice) : ["no parameters"];
    heatMap(plot, `Furnace of ${model.name}`, {x: {name: axis?.name ?? "", values: xs}, y: {name: "θ_i", values: angles.map((a) => degrees(a))},
      signed: true, asText: (v) => short(v, 2),
      cells: xs.flatMap((x, i) => angles.map((angle, j) => {
        const energy = model.energies[(base + i) * angles.length + j];
        return {i, j, value: energy - 1, mark: passes(energy) ? "✓" : "✗", tip: `${axis ? `${axis.name} ${x}<br>` : ""}θ_i ${degrees(angle)}<br>energy ${short(energy, 5)}`};
      }))});
  }
  function controlsNow() {
    const list = [];
    if (models.length > 1) list.push(choice("model", "Model", models.map((m, k) => ({value: k, label: m.name})), state.model, (v) => {
      state.model = Number(v);
      state.fixed = [];
      controlsNow();
      controls.querySelector("input:checked").focus();
      show();
    }));
    models[state.model].axes.slice(1).forEach((a, k) => list.push(choice(`fixed${k}`, a.name, a.values.map((v, i) => ({value: i, label: v})), state.fixed[k] ?? 0,
      (v) => { state.fixed[k] = Number(v); show(); })));
    controls.replaceChildren(...list);
  }
  function table() {
    const verdict = (m) => passes(m.least.energy) && passes(m.most.energy) ? ["pass", "✓ pass"] : ["fail", "✗ fail"];
    const where = (e) => `${degrees(e.theta_i)}${e.parameters ? `, ${e.parameters}` : ""}`;
    const number = (field, e) => element("td", {"data-field": field, "data-value": e.energy}, e.energy.toFixed(4));
    return scrolling("All models", element("table", {id: "numbers"}, element("thead", {}, element("tr", {},
      ["Model", "Configurations", "Least energy", "at", "Most energy", "at", "Verdict"].map((h) => element("th", {scope: "col", class: /Model|at|Verdict/.test(h) ? "text" : null}, h)))),
      element("tbody", {}, models.map((m, k) => element("tr", {"data-model": k}, element("td", {class: "text name"}, breakable(m.name)), element("td", {}, m.configurations),
        number("least", m.least), element("td", {class: "text wrap"}, breakable(where(m.least))), number("most", m.most), element("td", {class: "text wrap"}, breakable(where(m.most))),
        element("td", {class: "text"}, element("span", {class: `mark ${verdict(m)[0]}`}, verdict(m)[1])))))));
  }
  controlsNow();
  show();
}
