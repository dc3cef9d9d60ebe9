// A hemisphere seen along z as a disc of radius sin theta_o: equal cells have equal areas. phi = 0,
// the side of the light, is on the right, and phi runs counter-clockwise.
import {breakable, element} from "./dom.js";
import {short} from "./numbers.js";
import {onScheme, palette} from "./charts.js";

// The cell at a place of the unit disc, or -1 outside.
export function cellAt(grid, x, y) {
  const r2 = x * x + y * y;
  if (r2 >= 1) return -1;
  let phi = Math.atan2(y, x);
  if (grid.folded) phi = Math.abs(phi);
  else if (phi < 0) phi += 2 * Math.PI;
  const columns = grid.folded ? grid.phi_cells / 2 : grid.phi_cells;
  const row = Math.min(grid.mu_cells - 1, Math.floor(r2 * grid.mu_cells));
  return row * columns + Math.min(columns - 1, Math.floor(phi / (2 * Math.PI) * grid.phi_cells));
}

export class Disc {
  constructor(title, onRead) {
    this.title = title;
    this.canvas = element("canvas", {role: "img", tabindex: "0"});
    this.note = element("span", {class: "quiet"});
    this.barCanvas = element("canvas", {"aria-hidden": "true", width: 256, height: 1});
    this.ticks = element("div");
    this.caption = element("span", {}, title);
    this.node = element("figure", {class: "panel disc"},
      element("figcaption", {}, this.caption, " ", this.note), this.canvas,
      element("div", {class: "bar"}, this.barCanvas, this.ticks));
    this.canvas.addEventListener("pointermove", (event) => {
      const box = this.canvas.getBoundingClientRect();
      onRead(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
    });
    new ResizeObserver(() => { if (this.size() !== this.canvas.width) this.draw(); }).observe(this.canvas);
    onScheme(() => this.draw());
  }

  size() { return Math.max(64, Math.min(1024, Math.round((this.canvas.clientWidth || 220) * devicePixelRatio))); }

  show(state) { this.state = state; this.draw(); }

  draw() {
    if (!this.state) return;
    const {grid, values, scale, light, label, note, title} = this.state;
    this.caption.replaceChildren(...breakable(title ?? this.title));
    this.note.textContent = note ?? "";
    const size = this.size();
    if (this.canvas.width !== size) this.canvas.width = this.canvas.height = size;
    const context = this.canvas.getContext("2d"), image = context.createImageData(size, size);
    for (let j = 0; j < size; ++j) for (let i = 0; i < size; ++i) {
      const x = (2 * i + 1) / size - 1, y = 1 - (2 * j + 1) / size;
      const margin = 1.012, cell = cellAt(grid, x * margin, y * margin);
      if (cell < 0) continue;
      const v = values ? values[cell] : NaN;
      // A cell without a value is hatched.
      const [r, g, b] = Number.isNaN(v) ? ((i + j) % 8 < 4 ? [150, 150, 150] : [190, 190, 190]) : scale.color(v);
      const at = 4 * (j * size + i);
      image.data[at] = r; image.data[at + 1] = g; image.data[at + 2] = b; image.data[at + 3] = 255;
    }
    context.clearRect(0, 0, size, size);
    context.putImageData(image, 0, 0);
    const unit = size / 2 / 1.012, middle = size / 2, p = palette();
    context.lineWidth = Math.max(1, size / 260);
    context.strokeStyle = p.line;
    context.beginPath(); context.arc(middle, middle, unit, 0, 7); context.stroke();
    if (light) {
      const x = middle + unit * light.x, y = middle - unit * light.y, r = size / 45;
      for (const [color, width] of [["#000", 5], ["#fff", 2.2]]) {
        context.strokeStyle = color; context.lineWidth = width * size / 400;
        context.beginPath(); context.arc(x, y, r, 0, 7);
        if (light.behind) { context.moveTo(x - r, y - r); context.lineTo(x + r, y + r);
          context.moveTo(x - r, y + r); context.lineTo(x + r, y - r); }
        context.stroke();
      }
    }
    const bar = this.barCanvas.getContext("2d"), strip = bar.createImageData(256, 1);
    for (let k = 0; k < 256; ++k) strip.data.set([...scale.at(k / 255), 255], 4 * k);
    bar.putImageData(strip, 0, 0);
    this.ticks.replaceChildren(...scale.ticks.map((t) => element("span", {}, short(t))));
    this.canvas.setAttribute("aria-label", label);
  }
}
