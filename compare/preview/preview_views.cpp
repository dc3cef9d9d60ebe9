#include "compare/preview/preview_views.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "compare/files/base64.h"
#include "compare/files/output_folder.h"
#include "compare/report/lobe_files.h"
#include "compare/request/interrupt.h"
#include "phase/math/luminance.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

double mean_luminance(const PreviewImage& image) {
  double sum = 0, count = 0;
  for (std::size_t k = 0; k < image.radiance.size(); ++k) {
    if (!image.covered[k]) continue;
    sum += luminance(image.radiance[k]);
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

void add_channels(ExrImage& image, const std::string& layer, const PreviewImage& from, bool plain) {
  for (int c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const Rgb& v : from.radiance) values.push_back(v[c]);
    const std::string letter(1, "RGB"[c]);
    if (plain) image.channels.emplace_back(letter, exr_values(values));
    image.channels.emplace_back(fmt::format("{}.{}", layer, letter), exr_values(values));
  }
}

std::string title_of(const PreviewView& view, const PreviewLighting& lighting) {
  return fmt::format("{} under {}", to_text(view.scene),
                     view.light == PreviewLight::lamp    ? "a distant lamp"
                     : lighting.environment.is_uniform() ? "uniform light"
                                                         : "the environment");
}

// What is drawn, and its name.
struct Surface {
  std::string name, label;
  ReflectionTowards f;
  Specular specular;  // none: no delta
};

Surface surface_of(const LobeTable& truth) {
  Surface surface{"truth", "truth", [&](Direction wo) { return truth.towards(wo); }, {}};
  if (truth.has_specular()) surface.specular = [&](Direction wo) { return truth.specular(wo); };
  return surface;
}

Surface surface_of(const std::string& name, const std::string& label, const Model& model) {
  Surface surface{
      name,
      label,
      [&model](Direction wo) { return [&model, wo](Direction wi) { return model.eval(wi, wo); }; },
      {}};
  // A coat that mirrors does so along the normal, too.
  if (model.specular({0, 0, 1}).max() > 0)
    surface.specular = [&model](Direction wo) { return model.specular(wo); };
  return surface;
}

std::string png_url(const std::string& png) { return "data:image/png;base64," + base64(png); }

}  // namespace

std::string PreviewResult::name() const { return to_text(view.scene) + "_" + to_text(view.light); }

std::vector<PreviewResult> preview_views(const LobeTable& truth,
                                         const std::vector<BoundModel>& models,
                                         const PreviewLighting& lighting, int size,
                                         const StopFlag* stop) {
  std::vector<Surface> surfaces{surface_of(truth)};
  const std::vector<std::string> names = distinct_names(models), labels = distinct_labels(models);
  for (std::size_t k = 0; k < models.size(); ++k)
    surfaces.push_back(surface_of(names[k], labels[k], *models[k].model));
  std::vector<ReflectedLight> reflected;
  for (const Surface& s : surfaces) {
    if (is_set(stop)) return {};
    reflected.emplace_back(s.f, lighting.environment, s.specular,
                           truth.has_azimuth() ? LobeTable::kSectors : 1);
  }
  std::vector<PreviewResult> views;
  for (const PreviewScene scene : {PreviewScene::sphere, PreviewScene::plane})
    for (const PreviewLight light : {PreviewLight::lamp, PreviewLight::environment}) {
      if (is_set(stop)) return views;
      PreviewResult result{{scene, light, size, lighting.lamp_theta, lighting.lamp_phi}, {}};
      for (std::size_t k = 0; k < surfaces.size(); ++k)
        result.columns.push_back({surfaces[k].name,
                                  render(surfaces[k].f, result.view, reflected[k]),
                                  surfaces[k].label});
      views.push_back(std::move(result));
    }
  return views;
}

void write_preview_files(const std::string& prefix, const std::vector<PreviewResult>& views,
                         const LobeTable& truth, const Stack& stack,
                         const PreviewLighting& lighting, const std::vector<PictureFormat>& formats,
                         const InputFiles& inputs) {
  for (const PreviewResult& result : views) {
    ExrImage image;
    image.width = result.view.width();
    image.height = result.view.height();
    image.attributes = {{"lamella.version", LAMELLA_VERSION},
                        {"lamella.command", "preview"},
                        {"lamella.stack", to_toml(stack)},
                        {"lamella.stack_name", stack.name},
                        {"lamella.truth", truth.source()},
                        {"lamella.view", result.name()},
                        {"lamella.conventions",
                         "radiance; the lamp gives a perpendicular surface the irradiance pi; "
                         "plain R, G, B: the truth"}};
    for (std::size_t k = 0; k < result.columns.size(); ++k)
      add_channels(image, result.columns[k].name, result.columns[k].image, k == 0);
    record_files(image, inputs, std::filesystem::path(prefix).parent_path());
    write_exr(prefix + result.name() + ".exr", image);
    write_pictures(prefix + result.name(), formats, [&](PictureFormat format) {
      return draw_preview(stack.name + ": " + title_of(result.view, lighting), result.columns,
                          format);
    });
  }
}

Json to_json(const std::vector<PreviewResult>& views) {
  Json list = Json::array();
  for (const PreviewResult& result : views) {
    Json pictures = Json::array();
    for (const PreviewColumn& column : result.columns)
      pictures.push_back({{"name", column.name},
                          {"label", column.told()},
                          {"mean_luminance", mean_luminance(column.image)},
                          {"flip", flip_error(result.columns.front().image, column.image)}});
    list.push_back({{"scene", to_text(result.view.scene)},
                    {"light", to_text(result.view.light)},
                    {"pictures", std::move(pictures)}});
  }
  return list;
}

Json preview_page_details(const std::vector<PreviewResult>& views, const LobeTable& truth,
                          const PreviewLighting& lighting) {
  Json list = Json::array();
  for (const PreviewResult& result : views) {
    const PreviewScales scales = scales_of(result.columns);
    Json pictures = Json::array();
    for (std::size_t k = 0; k < result.columns.size(); ++k) {
      const PreviewImage& image = result.columns[k].image;
      Json picture{{"png", png_url(picture_png(image, scales.white))}};
      if (k > 0)
        picture["difference"] =
            png_url(difference_png(result.columns.front().image, image, scales.difference));
      pictures.push_back(std::move(picture));
    }
    list.push_back({{"title", title_of(result.view, lighting)},
                    {"width", result.view.width()},
                    {"height", result.view.height()},
                    {"limit", scales.difference.high},
                    {"pictures", std::move(pictures)}});
  }
  Json colors = Json::array();
  constexpr int kStops = 10;
  for (int k = 0; k <= kStops; ++k) {
    const Color c = diverging_color(2.0 * k / kStops - 1);
    colors.push_back(fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b));
  }
  return {{"truth", truth.source()}, {"colors", std::move(colors)}, {"views", std::move(list)}};
}

std::string preview_table(const std::vector<PreviewResult>& views) {
  std::string text;
  for (const PreviewResult& result : views)
    for (const PreviewColumn& column : result.columns) {
      const bool first = &column == &result.columns.front();
      text +=
          fmt::format("  {:<18} {:<40} mean luminance {:.5f}{}\n", result.name(), column.told(),
                      mean_luminance(column.image),
                      first ? ""
                            : fmt::format("  FLIP {:.3f}",
                                          flip_error(result.columns.front().image, column.image)));
    }
  return text;
}

}  // namespace lamella
