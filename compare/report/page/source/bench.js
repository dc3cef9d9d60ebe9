// The page of `lamella bench`: speed against error.
import {breakable, element, choice, figure, scrolling} from "./dom.js";
import {axis, chart, legend, modelColor, modelDash, modelSymbol, tooltip} from "./charts.js";
import {percent, short} from "./numbers.js";
import {heading} from "./heading.js";

const kinds = {walk: "random walk", deterministic: "deterministic", closed_form: "closed form"};

// The points that no other point beats in both cost and error, by rising cost.
export function paretoFront(points) {
  const front = [];
  for (const p of [...points].sort((a, b) => a.ns_per_eval - b.ns_per_eval || a.error - b.error))
    if (!front.length || p.error < front.at(-1).error) front.push(p);
  return front;
}

// Closed forms that were timed by themselves: each has its error on a stack of its own, so that
// none is on a front.
const everyForm = "closed forms, each on a stack that it claims";
const closedForms = (rows) => rows.filter((r) => r.error_on && r.ns_per_eval > 0 && r.error > 0).map((r) =>
  ({...r, stack: everyForm, method: r.what.replace(/^eval(_batch)?\//, ""), batched: r.what.startsWith("eval_batch/")}));

export function bench(page, answer) {
  const points = [...answer.rows.filter((r) => r.stack && r.ns_per_eval > 0 && r.error > 0), ...closedForms(answer.rows)];
  const stacks = [...new Set(points.map((r) => r.stack))];
  const state = {stack: stacks[0], rows: "all"};
  const plot = element("div", {class: "chart map"}), key = element("div");
  const controls = element("section", {class: "controls", "aria-label": "What is shown"});
  const plotFigure = figure("Speed against error", "", [plot, key]);
  const front = element("div"), frontHead = element("h2", {}, "The front"), table = element("div");
  page.append(heading(answer, "Speed against error", [answer.quick ? "quick: noisy" : "", `${answer.threads} threads`,
    answer.interrupted ? "interrupted: what was done until then" : ""]));
  if (stacks.length) page.append(controls, plotFigure, element("p", {class: "quiet"}, "Lower left is better. Cost: nanoseconds " +
    "of one core per value of the BSDF; for estimators, the time of the run over the cells it fills. Error: relative RMSE of " +
    "the reflected lobe of all orders at θ_i = 60°: for closed forms without the truth's noise, for walks the standard error, for the " +
    "deterministic solver its bound (an arrow points down: the error is no larger). Bars: 95 % of the error, and the spread of the timing. " +
    "The line joins what nothing beats in both. Closed forms that were timed by themselves, in single calls and in batches, have their errors " +
    "on different stacks: they are compared in cost alone."),
    frontHead, front);
  page.append(element("h2", {}, "All rows"), element("p", {class: "quiet"},
    "Ratio: above 1 is faster than the baseline of the same run."), table);

  function show() {
    const shown = points.filter((r) => r.stack === state.stack), forms = state.stack === everyForm, best = forms ? [] : paretoFront(shown);
    frontHead.textContent = forms ? "The closed forms" : "The front";
    const methods = [...new Set(shown.map((r) => r.method))];
    plotFigure.querySelector("figcaption .quiet")?.remove();
    plotFigure.querySelector("figcaption").append(element("span", {class: "quiet"}, state.stack));
    const lines = (m) => shown.filter((r) => r.method === m).length > 1;
    key.replaceChildren(legend([...methods.map((m, k) => ({name: m, model: k, lineless: !lines(m)})),
      ...(forms ? [] : [{name: "Pareto front", color: "currentColor", symbol: "none"}])]));
    const decades = (values) => [10 ** Math.floor(Math.log10(Math.min(...values)) - 1e-9), 10 ** Math.ceil(Math.log10(Math.max(...values)) + 1e-9)];
    const [left, right] = decades(shown.flatMap((r) => [r.ns_low ?? r.ns_per_eval, r.ns_high ?? r.ns_per_eval]).filter((v) => v > 0));
    const [bottom, top] = decades(shown.flatMap((r) => [r.error, r.error_high ?? r.error]).filter((v) => v > 0));
    const within = (v, low, high) => Math.max(low, Math.min(high, v));
    const power = (v) => Math.abs(v) >= 1e4 || Math.abs(v) < 1e-3 ? short(v, 1) : String(v);
    chart(plot, `Speed against error on ${state.stack}`, (p, {width, height}) => { const layout = apart(shown.map((r) => [66 + (width - 94) * share(r.ns_per_eval, left, right),
        height - 50 - (height - 74) * share(r.error, bottom, top)]), width); return ({
      grid: {left: 66, right: 28, top: 24, bottom: 50},
      tooltip: tooltip(p, {trigger: "item", formatter: ({data, seriesName}) => data?.row
        ? `${data.row.method}<br>${short(data.row.ns_per_eval)} ns per value<br>error ${data.row.bound ? "at most " : ""}${percent(data.row.error)}` +
          (forms ? ` on ${data.row.error_on}<br>${data.row.batched ? `${data.row.batch} values at a time` : "one value at a time"}` : "") : seriesName}),
      xAxis: axis(p, "cost [ns per value]", {type: "log", min: left, max: right, axisLabel: {color: p.quiet, formatter: power, hideOverlap: true}}),
      yAxis: axis(p, "relative error", {type: "log", min: bottom, max: top, nameGap: 48, axisLabel: {color: p.quiet, formatter: power}}),
      series: [
        {type: "line", name: "Pareto front", data: stairs(best, right), showSymbol: false, silent: true,
          lineStyle: {color: p.text, width: 1.6, opacity: .8}, z: 2},
        ...methods.flatMap((m, k) => {
          const mine = shown.filter((r) => r.method === m).sort((a, b) => a.ns_per_eval - b.ns_per_eval);
          return [bars(mine.map((r) => [r.ns_per_eval, r.error, within(r.ns_low ?? r.ns_per_eval, left, right), within(r.ns_high ?? r.ns_per_eval, left, right),
              within(r.error_low ?? r.error, bottom, top), within(r.error_high ?? r.error, bottom, top), r.bound ? 1 : 0]), modelColor(k)),
            {type: "line", name: m, symbol: modelSymbol(k), symbolSize: 11, z: 5,
              // Names stand beside each method's cheapest point, and move apart; where there is no
              // room the legend has them.
              data: mine.map((r, i) => ({value: [r.ns_per_eval, r.error], row: r,
                label: {show: i === 0 && width > 560, position: share(r.ns_per_eval, left, right) > .75 ? "left" : "right"}})),
              lineStyle: {color: modelColor(k), type: modelDash(k), width: mine.length > 1 ? 2 : 0}, itemStyle: {color: modelColor(k)},
              label: {formatter: m, position: "right", distance: 9, color: p.text, textBorderColor: p.back, textBorderWidth: 2},
              labelLayout: layout}];
        })],
    }); });
    front.replaceChildren(forms ? formTable(shown) : scrolling("The Pareto front", element("table", {id: "front"}, element("thead", {}, element("tr", {},
      ["Method", "ns per value", "Error"].map((h, k) => element("th", {class: k ? null : "text", scope: "col"}, h)))),
      element("tbody", {}, best.map((r) => element("tr", {}, element("td", {class: "text name"}, breakable(r.method), (r.walks ? `, ${r.walks.toLocaleString("en")} walks` : "") +
        (r.tolerance ? `, tolerance ${short(r.tolerance)}` : "")),
        element("td", {}, short(r.ns_per_eval)), element("td", {}, percent(r.error))))))));
  }
  // One row per model: single calls, and batches on lanes.
  function formTable(shown) {
    const of = (m, batched) => shown.find((r) => r.method === m && r.batched === batched);
    return scrolling("The closed forms", element("table", {id: "front"}, element("thead", {}, element("tr", {},
      ["Model", "ns per value", "in batches", "Error", "on the stack"].map((h, k) => element("th", {class: k % 4 ? null : "text", scope: "col"}, h)))),
      element("tbody", {}, [...new Set(shown.map((r) => r.method))].map((m) => element("tr", {}, element("td", {class: "text name"}, breakable(m)),
        [of(m, false), of(m, true)].map((r) => element("td", {}, short(r?.ns_per_eval))),
        element("td", {}, percent((of(m, false) ?? of(m, true)).error)), element("td", {class: "text name"}, breakable((of(m, false) ?? of(m, true)).error_on)))))));
  }
  const share = (v, low, high) => Math.log(v / low) / Math.log(high / low);
  // Labels beside their points, moved up or down from other labels and points, to the left at the
  // right edge.
  function apart(points, width) {
    const placed = new Map();
    const marks = points.map(([x, y]) => ({x: x - 6, y: y - 6, width: 12, height: 12}));
    const meet = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
    return ({seriesIndex, labelRect: r}) => {
      if (placed.has(seriesIndex)) placed.clear();
      const dx = r.x + r.width > width - 4 ? -r.width - 26 : 0;
      const steps = Array.from({length: 80}, (_, k) => (k % 2 ? 1 : -1) * (11 + Math.floor(k / 2) * 4)).filter((dy) => r.y + dy > 2);
      const at = (dy) => ({x: r.x + dx, y: r.y + dy, width: r.width, height: r.height});
      // Where there is no room beside all points, at least beside other labels.
      const free = (taken) => steps.find((d) => !taken.some((b) => meet(at(d), b)));
      const labels = [...placed.values()], dy = free([...labels, ...marks]) ?? free(labels) ?? 0;
      placed.set(seriesIndex, at(dy));
      return {dx, dy};
    };
  }
  // The front as a line: its error holds for every higher cost, until a better point.
  function stairs(best, right) {
    return best.flatMap((r, k) => [[r.ns_per_eval, r.error], [best[k + 1]?.ns_per_eval ?? right, r.error]]);
  }
  function bars(data, color) {
    return {type: "custom", name: "bars", silent: true, clip: true, data, z: 4, tooltip: {show: false}, encode: {x: [0, 2, 3], y: [1, 4, 5]},
      renderItem: (params, api) => {
        const v = (k) => api.value(k), line = (a, b) => {
          const [x1, y1] = api.coord(a), [x2, y2] = api.coord(b);
          return {type: "line", shape: {x1, y1, x2, y2}, style: {stroke: color, lineWidth: 1.5}};
        };
        if (v(6)) {
          const [x, y] = api.coord([v(0), v(1)]), stroke = (x1, y1, x2, y2) => ({type: "line", shape: {x1, y1, x2, y2}, style: {stroke: color, lineWidth: 1.5}});
          return {type: "group", children: [stroke(x, y, x, y + 24), stroke(x, y + 24, x - 4, y + 18), stroke(x, y + 24, x + 4, y + 18)]};
        }
        return {type: "group", children: [line([v(2), v(1)], [v(3), v(1)]), line([v(0), v(4)], [v(0), v(5)])]};
      }};
  }

  const known = new Set(["what", "kind", "seconds", "collisions_per_second_per_core", "ns_per_eval", "error", "baseline", "ratio_to_baseline"]);
  function showTable() {
    const rows = answer.rows.filter((r) => state.rows === "all" || r.kind === state.rows);
    const head = ["What", "Kind", "Seconds", "Collisions / s", "ns / value", "Error", "Ratio", "Baseline"], text = new Set([0, 1, 7]);
    const number = (row, field, shown) => element("td", {"data-field": field, "data-value": row[field] ?? ""}, shown ?? short(row[field]));
    table.replaceChildren(scrolling("All rows", element("table", {id: "numbers"},
      element("thead", {}, element("tr", {}, head.map((h, k) => element("th", {scope: "col", class: text.has(k) ? "text" : null}, h)))),
      element("tbody", {}, rows.map((r) => element("tr", {"data-row": answer.rows.indexOf(r)}, element("td", {class: "text name"}, breakable(r.what)),
        element("td", {class: "text"}, kinds[r.kind] ?? r.kind), number(r, "seconds"), number(r, "collisions_per_second_per_core"),
        number(r, "ns_per_eval"), number(r, "error", r.error === null ? "–" : percent(r.error)),
        number(r, "ratio_to_baseline"), element("td", {class: "text wrap", title: Object.entries(r).filter(([k]) => !known.has(k)).map(([k, v]) => `${k} ${v}`).join(", ")},
          String(r.baseline ?? "") + (r.extrapolated ? " extrapolated" : ""))))))));
  }
  const choose = (name, f) => (v) => { state[name] = v; f(); };
  if (stacks.length) {
    controls.append(choice("stack", "Stack", stacks.map((s) => ({value: s, label: s})), state.stack, choose("stack", show)));
    show();
  }
  table.before(element("section", {class: "controls", style: "position: static"}, choice("rows", "Rows", ["all", ...new Set(answer.rows.map((r) => r.kind))].map((k) =>
    ({value: k, label: kinds[k] ?? k})), "all", choose("rows", showTable))));
  showTable();
}
