// A sphere and a plane under light: truth, models, and their difference from the truth.
import {breakable, element} from "./dom.js";
import {luminanceName, percent, short} from "./numbers.js";

export function previews(answer, details) {
  if (!details) return [];
  const gradient = `linear-gradient(to right, ${details.colors.join(", ")})`;
  return [element("h2", {}, "Under light"),
    element("p", {class: "quiet"}, `Truth by ${details.truth}. Above: radiance, one exposure per row of pictures. Below: ${luminanceName}, model − truth.`),
    element("div", {class: "halves"}, details.views.map((view, v) => {
      const pictures = answer[v].pictures, truth = pictures[0].mean_luminance;
      const shot = (src, alt) => element("img", {src, alt, width: view.width, height: view.height});
      return element("figure", {class: "panel"}, element("figcaption", {}, view.title[0].toUpperCase() + view.title.slice(1)),
        element("div", {class: "shots"}, view.pictures.map((p, k) => element("div", {class: "shot", "data-picture": pictures[k].name},
          element("p", {}, element("strong", {}, breakable(pictures[k].label ?? pictures[k].name)), element("span", {class: "quiet", "data-field": "mean_luminance", "data-value": pictures[k].mean_luminance},
            ` mean luminance ${short(pictures[k].mean_luminance, 4)}` + (k && truth > 0 ? ` (${pictures[k].mean_luminance < truth ? "−" : "+"}${percent(Math.abs(pictures[k].mean_luminance / truth - 1))})` : ""))),
          shot(p.png, `${view.title}: ${pictures[k].label ?? pictures[k].name}`),
          p.difference ? shot(p.difference, `${view.title}: ${pictures[k].label ?? pictures[k].name} less the truth, at most ${short(view.limit)}`) : null))),
        view.pictures.length > 1 ? element("div", {class: "bar"}, element("div", {class: "strip", style: `background: ${gradient}`}),
          element("div", {class: "ticks"}, [-view.limit, 0, view.limit].map((t) => element("span", {}, short(t))))) : null);
    }))];
}
