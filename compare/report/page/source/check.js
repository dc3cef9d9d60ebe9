// The page of `lamella check`: the battery of checks of a model, each with its worst case.
import {breakable, element, figure, scrolling} from "./dom.js";
import {axis, chart, tooltip} from "./charts.js";
import {degrees, short, thetaOf} from "./numbers.js";
import {heading} from "./heading.js";

const marks = {pass: "✓ pass", fail: "✗ fail", undecided: "? undecided", skipped: "– skipped"};
const looks = {pass: "pass", fail: "fail", undecided: "inconclusive", skipped: "inconclusive"};
const mark = (v) => element("span", {class: `mark ${looks[v]}`}, marks[v]);
const azimuth = ([x, y]) => (Math.atan2(y, x) * 180 / Math.PI + 360) % 360;
const direction = (name, w) => w ? [`${name}: θ ${degrees(thetaOf(w[2]))}, φ ${degrees(azimuth(w))}`] : [];

export function check(page, answer) {
  const failed = answer.checks.filter((c) => c.verdict === "fail").length;
  page.append(heading(answer, `Check of ${answer.request}`,
      [`${answer.configurations} of ${answer.configurations_planned} configurations`, answer.refused ? `${answer.refused} refused` : "",
        `${answer.samples} samples per direction`, answer.single_precision ? "values in single precision" : "",
        answer.ended_by_time ? "ended by time: cases are missing" : ""]),
    element("p", {class: "overall"}, mark(answer.verdict), " ", answer.verdict === "pass" ? "No check failed."
      : `${failed} of ${answer.checks.length} checks failed.`));
  const plot = element("div", {class: "chart tall"});
  page.append(figure("Worst case of each check", "what was found over what is allowed: above 1 it fails", [plot]));
  // "inf" and nothing at all keep to the ends of the scale.
  const ratio = (c) => !c.worst ? 1e-6 : typeof c.worst.found !== "number" ? 1e6
    : Math.max(1e-6, Math.min(1e6, c.worst.found / (c.worst.allowed || 1e-300)));
  const shown = [...answer.checks].reverse();
  chart(plot, "What was found over what is allowed, per check", (p) => ({
    grid: {left: 96, right: 24, top: 14, bottom: 48},
    tooltip: tooltip(p, {valueFormatter: (v) => short(v)}),
    xAxis: axis(p, "found / allowed", {type: "log", min: 1e-6, max: 1e6, axisLabel: {color: p.quiet, formatter: (v) => short(v, 1)}}),
    yAxis: axis(p, "", {type: "category", data: shown.map((c) => c.name), axisLabel: {color: p.text}}),
    series: [{type: "bar", name: "found / allowed", barWidth: "55%", data: shown.map((c) => ({value: ratio(c),
        itemStyle: {color: c.verdict === "fail" ? p.text : p.quiet, opacity: c.verdict === "skipped" ? .2 : .8, borderColor: p.text, borderWidth: 1}})),
      markLine: {silent: true, symbol: "none", lineStyle: {color: p.text, type: "solid", width: 1}, label: {show: false}, data: [{xAxis: 1}]}}]}));
  const number = (field, value) => element("td", {"data-field": field, "data-value": value}, short(value));
  page.append(element("h2", {}, "All checks"), scrolling("All checks", element("table", {id: "numbers"},
    element("thead", {}, element("tr", {}, ["Check", "Verdict", "What holds where it passes", "Cases", "Undecided", "Found", "Allowed", "Worst case"]
      .map((h) => element("th", {scope: "col", class: /Check|Verdict|What|Worst/.test(h) ? "text" : null}, h)))),
    element("tbody", {}, answer.checks.map((c, k) => element("tr", {"data-check": k},
      element("td", {class: "text name"}, c.name), element("td", {class: "text"}, mark(c.verdict)), element("td", {class: "text wrap"}, c.claim),
      element("td", {}, c.cases.toLocaleString("en")), element("td", {}, c.undecided.toLocaleString("en")),
      c.worst ? number("found", c.worst.found) : element("td", {}, "–"), c.worst ? number("allowed", c.worst.allowed) : element("td", {}, "–"),
      element("td", {class: "text wrap"}, breakable(c.worst
        ? [c.worst.text, ...direction("w_i", c.worst.wi), ...direction("w_o", c.worst.wo), c.worst.request].join("; ") : c.reason ?? ""))))))));
  const s = answer.sampler;
  if (s) page.append(element("p", {class: "quiet"}, breakable(`Samples' weights: variance up to ${short(s.variance)} (θ_o ${degrees(s.theta_o)}; ${s.request}), ` +
    `largest weight ${short(s.max_weight)}, ${short(s.lost)} of the samples without light.`)));
}
