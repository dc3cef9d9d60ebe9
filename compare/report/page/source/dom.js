// Elements from tags, attributes and children; strings become text, never markup.
const svgTags = new Set(["svg", "g", "rect", "line", "path", "circle", "ellipse", "text", "defs",
  "pattern", "clipPath", "title", "polygon"]);

export function element(tag, attributes = {}, ...children) {
  const node = svgTags.has(tag) ? document.createElementNS("http://www.w3.org/2000/svg", tag)
                                : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat().filter((c) => c !== null && c !== undefined));
  return node;
}

// A text that may be broken after its underscores, slashes and equals signs: names of models,
// stacks and parameters.
export const breakable = (text) => String(text).split(/([_/=])/).flatMap((part, k) => k % 2 ? [part, element("wbr")] : [part]);

// A group of radio buttons that looks like a row of keys. `options`: {value, label, disabled}.
export function choice(name, legend, options, chosen, onChoice) {
  return element("fieldset", {"data-switch": name}, element("legend", {}, legend),
    element("div", {class: "options"}, options.map((o) =>
      element("label", {}, element("input", {type: "radio", name, value: o.value,
        checked: String(o.value) === String(chosen), disabled: o.disabled,
        onchange: () => onChoice(o.value)}), element("span", {}, breakable(o.label))))));
}

// A table that scrolls by itself where it is too wide, by keyboard too.
export function scrolling(label, table) {
  return element("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": label}, table);
}

export function figure(caption, note, content, extra = {}) {
  return element("figure", {class: "panel", ...extra}, element("figcaption", {}, breakable(caption), " ",
    note ? element("span", {class: "quiet"}, note) : null), ...[content].flat());
}
