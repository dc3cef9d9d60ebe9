import {interpolateRdBu, interpolateViridis} from "d3-scale-chromatic";

const parts = (color) => {
  const hex = /^#(..)(..)(..)$/.exec(color);
  return hex ? hex.slice(1).map((h) => parseInt(h, 16)) : color.match(/[\d.]+/g).slice(0, 3).map(Number);
};
const table = (f) => Array.from({length: 512}, (_, k) => parts(f(k / 511)));
const viridis = table(interpolateViridis), diverging = table((t) => interpolateRdBu(1 - t));
const pick = (colors, t) => colors[Math.max(0, Math.min(511, Math.round(t * 511)))];

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
    return {ticks: [0, high / 2, high], color: (v) => pick(viridis, v / high), at: (t) => pick(viridis, t)};
  }
  const top = Math.ceil(Math.log10(high) - 1e-9), bottom = Math.max(Math.floor(Math.log10(least)), top - 6);
  return {ticks: [10 ** bottom, 10 ** ((top + bottom) / 2), 10 ** top], at: (t) => pick(viridis, t),
    color: (v) => pick(viridis, v > 0 ? (Math.log10(v) - bottom) / (top - bottom) : 0)};
}

// Symmetric about 0.
export function signedScale(map, limit) {
  let most = 0;
  if (limit === undefined) for (const v of map) if (Number.isFinite(v)) most = Math.max(most, Math.abs(v));
  const end = limit ?? roundUp(most);
  return {ticks: [-end, 0, end], at: (t) => pick(diverging, t), color: (v) => pick(diverging, .5 + v / end / 2)};
}

export function sequential(t) { return `rgb(${pick(viridis, t).join(",")})`; }
export const viridisStops = Array.from({length: 11}, (_, k) => sequential(k / 10));
export const divergingStops = Array.from({length: 11}, (_, k) => `rgb(${pick(diverging, k / 10).join(",")})`);
