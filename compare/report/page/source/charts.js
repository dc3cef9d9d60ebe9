// ECharts with what these pages use of it, and the look that all their charts share.
import {CustomChart, HeatmapChart, LineChart, ScatterChart, BarChart} from "echarts/charts";
import {GridComponent, PolarComponent, TooltipComponent, VisualMapContinuousComponent,
  MarkLineComponent, AriaComponent} from "echarts/components";
import {init, use} from "echarts/core";
import {LabelLayout} from "echarts/features";
import {SVGRenderer} from "echarts/renderers";
import {breakable, element} from "./dom.js";

use([CustomChart, HeatmapChart, LineChart, ScatterChart, BarChart, GridComponent,
  PolarComponent, TooltipComponent, VisualMapContinuousComponent, MarkLineComponent, AriaComponent,
  LabelLayout, SVGRenderer]);

// Okabe and Ito's colours, told apart in every kind of colour vision; dashes and symbols differ
// too.
const light = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b08800", "#3b9ccc", "#6a4c93", "#8c4a2f", "#5f6b2d", "#777777"];
const dark = ["#56b4e9", "#ff9a4d", "#2fd0a0", "#e6a4c8", "#f0e442", "#8fd0f5", "#b79be6", "#d9a080", "#b9c76b", "#aaaaaa"];
const dashes = ["solid", [8, 4], [2, 3], [10, 3, 2, 3], [5, 2], [12, 4], [3, 6]];
const symbols = ["circle", "triangle", "diamond", "rect", "roundRect", "pin", "arrow"];

const printing = matchMedia("print"), darkScheme = matchMedia("(prefers-color-scheme: dark)");
let forPrint = false;
export const isDark = () => darkScheme.matches && !printing.matches && !forPrint;
export const modelColor = (k) => (isDark() ? dark : light)[k % light.length];
export const modelDash = (k) => dashes[k % dashes.length];
export const modelSymbol = (k) => symbols[k % symbols.length];

export function palette() {
  return isDark() ? {text: "#e7e9ee", quiet: "#a3abba", line: "#5a6270", grid: "#30353f", back: "#1d2026",
    truth: "#ffffff", band: "rgba(255,255,255,.22)", edge: "rgba(255,255,255,.5)"}
                  : {text: "#1b1f27", quiet: "#586070", line: "#9aa1ad", grid: "#e3e6eb", back: "#ffffff",
    truth: "#000000", band: "rgba(0,0,0,.18)", edge: "rgba(0,0,0,.45)"};
}

const drawn = new Map();

// A chart in a node; `option` is asked for again when the scheme changes or the page is printed.
export function chart(node, label, option) {
  let entry = drawn.get(node);
  if (!entry) {
    const instance = init(node, null, {renderer: "svg"});
    entry = {instance, node};
    drawn.set(node, entry);
    let width = node.clientWidth;
    new ResizeObserver(() => {
      if (node.clientWidth === width) return;
      width = node.clientWidth;
      instance.resize();
      redraw(entry);
    }).observe(node);
  }
  entry.option = option;
  node.setAttribute("role", "img");
  node.setAttribute("aria-label", label);
  redraw(entry);
}

function redraw({instance, node, option}) {
  const p = palette();
  instance.setOption({animation: false, backgroundColor: "transparent",
    textStyle: {color: p.text, fontFamily: getComputedStyle(node).fontFamily, fontSize: 12},
    ...option(p, {width: instance.getWidth(), height: instance.getHeight()})}, {notMerge: true});
}

const listeners = [() => drawn.forEach(redraw)];
export function onScheme(f) { listeners.push(f); }
const changed = () => listeners.forEach((f) => f());
darkScheme.addEventListener("change", changed);
printing.addEventListener("change", changed);
// Paper is narrower than the window: the page takes its width before the charts are drawn for it.
function print(on) {
  forPrint = on;
  document.documentElement.classList.toggle("paper", on);
  drawn.forEach((e) => e.instance.resize());
  changed();
}
addEventListener("beforeprint", () => print(true));
addEventListener("afterprint", () => print(false));

export function axis(p, name, more = {}) {
  return {name, nameLocation: "middle", nameGap: 30, nameTextStyle: {color: p.text},
    axisLine: {show: true, lineStyle: {color: p.line}}, axisTick: {lineStyle: {color: p.line}},
    axisLabel: {color: p.quiet, hideOverlap: true}, splitLine: {lineStyle: {color: p.grid}},
    minorSplitLine: {show: false}, ...more};
}

// The legend of a chart as text of the page: it wraps, grows and prints as text does. `entries`:
// {name, model} for a model by its number, {name, truth: true}, or {name, color, symbol}.
export function legend(entries) {
  const node = element("ul", {class: "legend"});
  const draw = () => node.replaceChildren(...entries.map((e) => {
    const p = palette(), color = e.truth || e.band ? p.truth : e.color ?? modelColor(e.model);
    const dash = e.model === undefined || modelDash(e.model) === "solid" ? null : modelDash(e.model).join(" ");
    const sign = e.band ? element("rect", {x: 2, y: 1, width: 28, height: 10, fill: p.band, stroke: p.edge})
      : element("g", {}, e.lineless ? [] : element("line", {x1: 1, y1: 6, x2: 31, y2: 6, stroke: color, "stroke-width": 2.4,
        "stroke-dasharray": dash}), symbolPath(e.truth ? "circle" : e.symbol ?? modelSymbol(e.model), color));
    return element("li", {}, element("svg", {width: 32, height: 12, viewBox: "0 0 32 12", "aria-hidden": "true"}, sign), element("span", {}, breakable(e.name)));
  }));
  draw();
  onScheme(() => { if (node.isConnected) draw(); });
  return node;
}

function symbolPath(symbol, color) {
  const shapes = {none: "", circle: "M16,2a4,4 0 1 0 .01,0z", triangle: "M16,1l5,9h-10z", diamond: "M16,0l5,6l-5,6l-5,-6z",
    rect: "M11.5,1.5h9v9h-9z", roundRect: "M12,2h8v8h-8z", pin: "M16,12l-4,-8a4,4 0 1 1 8,0z", arrow: "M16,0l5,12l-5,-4l-5,4z"};
  return element("path", {d: shapes[symbol] ?? shapes.circle, fill: color});
}

export function tooltip(p, more = {}) {
  return {trigger: "axis", backgroundColor: p.back, borderColor: p.line, confine: true,
    textStyle: {color: p.text}, ...more};
}

// The band between two curves as one polygon; works on cartesian and polar axes.
// Its edge is drawn too: a band thinner than a pixel is still there.
export function band(name, points, color, edge, more = {}) {
  return {type: "custom", name, silent: true, clip: true, data: [[0, 0]], z: 1, tooltip: {show: false},
    encode: {x: -1, y: -1},
    renderItem: (params, api) => {
      const place = ([x, low, high], value) => api.coord(more.coordinateSystem === "polar" ? [value, x] : [x, value]);
      return {type: "polygon", silent: true, shape: {points: [...points.map((q) => place(q, q[2])),
        ...[...points].reverse().map((q) => place(q, q[1]))]}, style: {fill: color, stroke: edge, lineWidth: 1}};
    }, ...more};
}

// Vertical error bars at [x, low, high].
export function errorBars(name, points, color, more = {}) {
  return {type: "custom", name, silent: true, clip: true, data: points, z: 3, tooltip: {show: false},
    encode: {x: 0, y: [1, 2]},
    renderItem: (params, api) => {
      const x = api.value(0), low = api.coord([x, api.value(1)]), high = api.coord([x, api.value(2)]);
      const bar = (x1, y1, x2, y2) => ({type: "line", shape: {x1, y1, x2, y2}, style: {stroke: color, lineWidth: 1.5}});
      return {type: "group", children: [bar(low[0], low[1], high[0], high[1]),
        bar(low[0] - 4, low[1], low[0] + 4, low[1]), bar(high[0] - 4, high[1], high[0] + 4, high[1])]};
    }, ...more};
}
