// A heat map over two parameters, each cell with its value and a mark that needs no colour.
import {axis, chart, tooltip} from "./charts.js";
import {divergingStops, viridisStops} from "./colors.js";

// x, y: {name, values (texts)}; cells: {i, j, value, mark, tip}; asText: of a value, for labels and
// scale.
export function heatMap(node, label, {x, y, cells, signed, asText}) {
  const most = Math.max(1e-12, ...cells.map((c) => Math.abs(c.value)).filter(Number.isFinite));
  const longest = Math.max(0, ...cells.map((c) => asText(c.value).length));
  chart(node, label, (p, {width}) => {
    const narrow = width < 520, left = 26 + 8 * Math.max(...y.values.map((v) => v.length)) + 22, right = narrow ? 62 : 96;
    // Where a value does not fit into its cell the mark stands alone.
    const fits = (width - left - right) / x.values.length > 7 * (longest + 2) + 6;
    return {grid: {left, right, top: 16, bottom: 54},
      tooltip: tooltip(p, {trigger: "item", formatter: ({data}) => data?.tip}),
      xAxis: axis(p, x.name, {type: "category", data: x.values, axisLabel: {color: p.text, hideOverlap: true}}),
      yAxis: axis(p, y.name, {type: "category", data: y.values, nameGap: left - 26, axisLabel: {color: p.text}}),
      visualMap: {type: "continuous", min: signed ? -most : 0, max: most, calculable: false, orient: "vertical", right: 0, top: "middle",
        itemHeight: 150, itemWidth: narrow ? 12 : 18, textStyle: {color: p.text}, dimension: 2,
        inRange: {color: signed ? divergingStops : viridisStops}, text: [asText(most), asText(signed ? -most : 0)]},
      series: [{type: "heatmap", itemStyle: {borderColor: p.back, borderWidth: 1},
        data: cells.map((c) => ({value: [c.i, c.j, Math.max(-most, Math.min(most, c.value))], tip: c.tip, mark: c.mark, text: asText(c.value)})),
        label: {show: true, formatter: ({data}) => fits ? `${data.mark} ${data.text}` : data.mark, color: "#fff", textBorderColor: "#000",
          textBorderWidth: 2.5, fontSize: 12}}]};
  });
}
