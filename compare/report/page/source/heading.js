import {breakable, element} from "./dom.js";

export function heading(answer, title, facts) {
  return element("header", {}, element("h1", {}, breakable(title)), element("ul", {class: "meta"},
    [...facts, answer.seed === undefined ? "" : `seed ${answer.seed}`, answer.isa ? `${answer.isa} kernels` : ""].filter(Boolean)
      .map((f) => element("li", {}, breakable(f)))));
}
