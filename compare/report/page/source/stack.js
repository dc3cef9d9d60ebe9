// The stack as a cross-section with its parameters.
import {element} from "./dom.js";
import {short} from "./numbers.js";

const width = 340, left = 8, inner = 132;

// Evenly spread numbers in [0, 1): the same drawing every time.
const spread = (k, base) => { let f = 1, r = 0; for (let i = k + 1; i > 0; i = Math.floor(i / base)) { f /= base; r += f * (i % base); } return r; };

const colorOf = (albedo) => {
  const [r, g, b] = Array.isArray(albedo) ? albedo : [albedo, albedo, albedo];
  return `rgb(${[r, g, b].map((v) => Math.round(255 * Math.max(0, Math.min(1, v)) ** (1 / 2.2))).join(",")})`;
};
const list = (v) => Array.isArray(v) ? v.map((x) => short(x, 3)).join(", ") : short(v, 4);

// What is drawn in a layer: flakes as strokes tilted as far as they are rough, particles as dots.
function grains(layer, top, height) {
  const depth = layer.thickness === "inf" ? 8 : layer.thickness * layer.density;
  const count = Math.round(Math.max(8, Math.min(56, 18 * Math.sqrt(depth) * height / 60)));
  const round = /sphere|henyey/.test(layer.medium), color = colorOf(layer.albedo);
  const rough = layer.roughness ?? (layer.alpha === "inf" ? 1 : layer.alpha) ?? 1;
  const axis = layer.axis ?? [0, 0, 1];
  // A surface's flakes lie across their mean normal; a fiber's strokes run along it.
  const lean = layer.shape === "fiber" ? Math.atan2(axis[2], axis[0]) : Math.atan2(axis[0], axis[2]);
  return Array.from({length: count}, (_, k) => {
    const x = left + 6 + spread(k, 2) * (inner - 12), y = top + 6 + spread(k, 3) * (height - 12);
    if (round) return element("circle", {cx: x, cy: y, r: 2.6, fill: color, stroke: "currentColor", "stroke-width": .7});
    const wide = layer.shape === "fiber" ? rough / 2 : rough;
    const tilt = lean + (spread(k, 5) - .5) * Math.PI * Math.min(1, wide);
    const dx = 5 * Math.cos(tilt), dy = 5 * Math.sin(tilt);
    const place = {x1: x - dx, y1: y + dy, x2: x + dx, y2: y - dy, "stroke-linecap": "round"};
    return element("g", {}, element("line", {...place, stroke: "currentColor", "stroke-width": 4.4}),
      element("line", {...place, stroke: color, "stroke-width": 2.6}));
  });
}

// An interface: a line, as wavy as it is rough.
function boundary(y, roughness) {
  const alpha = Array.isArray(roughness) ? roughness[0] : roughness ?? 0, steps = 48, high = 5 * Math.min(1, alpha);
  const points = Array.from({length: steps + 1}, (_, k) => `${left + k * inner / steps},${y + 3 + (k % 2 ? 1 : -1) * high * (.4 + .6 * spread(k, 2))}`);
  return element("polyline", {points: points.join(" "), fill: "none", stroke: "var(--accent)", "stroke-width": 2});
}

export function stackDrawing(stack, theta) {
  const top = 76, parts = [], texts = [];
  const depths = stack.layer.map((l) => l.interface ? 0 : l.thickness === "inf" ? Infinity : l.thickness * l.density);
  let y = top;
  stack.layer.forEach((layer, k) => {
    if (layer.interface) {
      const lines = Object.entries(layer).filter(([name]) => name !== "interface").map(([name, value]) => `${name} ${typeof value === "string" ? value : list(value)}`);
      parts.push(boundary(y, layer.roughness));
      texts.push(element("text", {x: left + inner + 14, y: y + 12, "font-weight": 600}, `${layer.interface} interface`),
        ...lines.map((t, i) => element("text", {class: "small", x: left + inner + 14, y: y + 27 + 15 * i}, t)));
      // The text needs room; what lies below is drawn as far as the next entry.
      const height = 16 + 15 * lines.length, last = k + 1 === stack.layer.length || stack.layer[k + 1].interface;
      parts.push(element("rect", {x: left, y: y + 5, width: inner, height: height - 5, fill: "var(--accent)", "fill-opacity": .08, stroke: last ? "none" : "var(--line)"}));
      y += height;
      return;
    }
    const lines = [], known = new Set(["medium", "albedo", "thickness", "density"]);
    const shape = [layer.shape, layer.flake].filter(Boolean).join(", ");
    if (shape) lines.push(shape);
    for (const [name, value] of Object.entries(layer))
      if (!known.has(name) && !["shape", "flake"].includes(name)) lines.push(`${name} ${list(value)}`);
    lines.push(`albedo ${list(layer.albedo)}`);
    lines.push(Number.isFinite(depths[k]) ? `depth ${short(depths[k])} (${short(layer.thickness)} mm × ${short(layer.density)}/mm)` : "half space");
    const height = Math.max(22 + 15 * lines.length, 40 + 12 * Math.log2(1 + Math.min(16, depths[k])));
    parts.push(element("rect", {x: left, y, width: inner, height, fill: "var(--page)", stroke: "var(--line)"}), ...grains(layer, y, height));
    if (!Number.isFinite(depths[k])) parts.push(element("path", {fill: "none", stroke: "var(--panel)", "stroke-width": 5,
      d: `M${left},${y + height} ` + Array.from({length: 11}, (_, i) => `L${left + (i + 1) * inner / 11},${y + height - (i % 2 ? 0 : 7)}`).join(" ")}));
    texts.push(element("text", {x: left + inner + 14, y: y + 16, "font-weight": 600}, `${layer.medium}`),
      ...lines.map((t, i) => element("text", {class: "small", x: left + inner + 14, y: y + 32 + 15 * i}, t)));
    y += height;
  });
  if (stack.substrate) {
    const surface = Object.entries(stack.substrate).filter(([name]) => name !== "bsdf").map(([name, value]) => `${name} ${typeof value === "string" ? value : list(value)}`);
    parts.push(element("rect", {x: left, y, width: inner, height: 26, fill: colorOf(stack.substrate.albedo ?? .6), stroke: "currentColor"}),
      ...Array.from({length: 12}, (_, k) => element("line", {x1: left + k * inner / 11, y1: y + 26, x2: left + (k + 1) * inner / 11, y2: y,
        stroke: "currentColor", "stroke-width": .6, "clip-path": "inset(0)"})));
    texts.push(element("text", {x: left + inner + 14, y: y + 12, "font-weight": 600}, `substrate: ${stack.substrate.bsdf}`),
      ...surface.map((t, i) => element("text", {class: "small", x: left + inner + 14, y: y + 27 + 15 * i}, t)));
    y += 19 + 15 * Math.max(1, surface.length);
  }
  // The light, and the normal. phi = 0 is on the right.
  const below = theta > 90, middle = left + inner / 2, angle = theta * Math.PI / 180;
  const foot = below ? y : top, length = 58;
  const ex = middle + length * Math.sin(angle), ey = foot - length * Math.cos(angle);
  const ux = -Math.sin(angle), uy = Math.cos(angle), bottom = below ? y + 66 : y + 8;
  const arrow = [
    element("line", {x1: middle, y1: foot, x2: middle, y2: below ? foot + 62 : foot - 62, stroke: "var(--quiet)", "stroke-dasharray": "3 3"}),
    element("line", {x1: ex, y1: ey, x2: middle - 7 * ux, y2: foot - 7 * uy, stroke: "var(--accent)", "stroke-width": 2.5}),
    element("polygon", {fill: "var(--accent)", points: [[0, 0], [-11, 5], [-11, -5]].map(([a, b]) =>
      `${middle + a * ux - b * uy},${foot + a * uy + b * ux}`).join(" ")}),
    element("text", {x: Math.min(ex + 8, width - 90), y: ey + (below ? 14 : 4)}, `light, ${Number(theta.toFixed(2))}°`)];
  const label = `Cross-section of ${stack.name}: ` + stack.layer.map((l) => l.medium ?? `${l.interface} interface`).join(" over ") + (stack.substrate ? " over a substrate" : "");
  return element("svg", {viewBox: `0 0 ${width} ${bottom}`, role: "img", "aria-label": label}, parts, texts, arrow);
}
