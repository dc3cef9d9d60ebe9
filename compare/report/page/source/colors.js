// The same colours as in the program's pictures: 256 entries each of viridis and of RdBu, whose 11
// classes of ColorBrewer are linear in between (compare/drawing/color_map.h).
import {interpolateViridis, schemeRdBu} from "d3-scale-chromatic";

const parts = (color) => {
  const hex = /^#(..)(..)(..)$/.exec(color);
  return hex ? hex.slice(1).map((h) => parseInt(h, 16)) : color.match(/[\d.]+/g).slice(0, 3).map(Number);
};
const viridis = Array.from({length: 256}, (_, k) => parts(interpolateViridis(k / 255)));
const classes = schemeRdBu[11].map(parts).reverse();
const blueRed = Array.from({length: 256}, (_, k) => {
  const x = 10 * k / 255, i = Math.min(9, Math.floor(x));
  return classes[i].map((a, c) => Math.round(a + (x - i) * (classes[i + 1][c] - a)));
});
const unit = (t) => Math.max(0, Math.min(1, t));

// t in [0, 1].
export const viridisAt = (t) => viridis[Math.min(255, Math.floor(256 * unit(t)))];
// t in [0, 1], neutral at 1/2.
export function divergingAt(t) {
  const s = 2 * unit(t) - 1, step = Math.min(127, Math.floor(128 * Math.abs(s)));
  return s === 0 ? classes[5] : blueRed[s > 0 ? 128 + step : 127 - step];
}

const roundUp = (x) => {
  if (!(x > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(x));
  const step = [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((s) => s * power >= x * (1 - 1e-9));
  return step * power;
};

// One scale for all maps of magnitudes that are to be compared.
export function magnitudeScale(maps, logarithmic) {
  let high = 0, least = Infinity;
  for (const map of maps) for (const v of map) {
    if (Number.isFinite(v)) high = Math.max(high, v);
    if (v > 0) least = Math.min(least, v);
  }
  high = roundUp(high);
  if (!logarithmic || !(least < high)) {
    return {ticks: [0, high / 2, high], color: (v) => viridisAt(v / high), at: viridisAt};
  }
  const top = Math.ceil(Math.log10(high) - 1e-9), bottom = Math.max(Math.floor(Math.log10(least)), top - 6);
  return decades(bottom, top);
}

const decades = (bottom, top) => ({ticks: [10 ** bottom, 10 ** ((top + bottom) / 2), 10 ** top], at: viridisAt,
  color: (v) => viridisAt(v > 0 ? (Math.log10(v) - bottom) / (top - bottom) : 0)});

// Logarithmic, for errors over their bounds: whole decades, from 0.1 to at least the largest and to
// 10.
export function ratioScale(map) {
  const most = map.reduce((m, v) => Number.isFinite(v) ? Math.max(m, v) : m, 10);
  return decades(-1, Math.ceil(Math.log10(most) - 1e-9));
}

// Symmetric about 0.
export function signedScale(map, limit) {
  let most = 0;
  if (limit === undefined) for (const v of map) if (Number.isFinite(v)) most = Math.max(most, Math.abs(v));
  const end = limit ?? roundUp(most);
  return {ticks: [-end, 0, end], at: divergingAt, color: (v) => divergingAt(.5 + v / end / 2)};
}

export function sequential(t) { return `rgb(${viridisAt(t).join(",")})`; }
export const viridisStops = Array.from({length: 11}, (_, k) => sequential(k / 10));
export const divergingStops = Array.from({length: 11}, (_, k) => `rgb(${divergingAt(k / 10).join(",")})`);
