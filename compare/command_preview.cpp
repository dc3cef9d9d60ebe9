#include <fmt/format.h>

#include <cmath>

#include "compare/command.h"
#include "compare/json_report.h"
#include "compare/lobe_files.h"
#include "compare/lobe_table.h"
#include "compare/model_request.h"
#include "compare/output_folder.h"
#include "compare/preview.h"
#include "phase/stack_file.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

double mean_luminance(const PreviewImage& image) {
  double sum = 0, count = 0;
  for (std::size_t k = 0; k < image.radiance.size(); ++k) {
    if (!image.covered[k]) continue;
    const Rgb c = image.radiance[k];
    sum += 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
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
    image.channels.emplace_back(layer + "." + letter, exr_values(values));
  }
}

// "THETA,PHI" in degrees.
std::pair<double, double> lamp_of(const std::string& text) {
  const std::size_t comma = text.find(',');
  const auto theta = parse_number(std::string_view(text).substr(0, comma));
  const auto phi =
      comma == std::string::npos ? std::optional(0.0) : parse_number(text.substr(comma + 1));
  if (!theta || !phi || !(*theta >= 0 && *theta < 180) || !std::isfinite(*phi))
    throw UsageError(fmt::format(
        "--light: found \"{}\"; allowed: THETA[,PHI] in degrees, THETA in [0, 180)", text));
  return {*theta, *phi};
}

// Two requests of one model get a number each.
std::vector<std::string> names_of(const std::vector<BoundModel>& models) {
  std::vector<std::string> names;
  for (const BoundModel& m : models) {
    int same = 0, before = 0;
    for (const BoundModel& other : models) {
      if (&other == &m) before = same;
      same += other.info == m.info;
    }
    names.push_back(same > 1 ? fmt::format("{}_{}", m.info->name, before) : m.info->name);
  }
  return names;
}

}  // namespace

int preview_command(const Options& options) {
  const Stack stack = stack_of(options);
  const auto [theta, phi] = lamp_of(options.light);
  const Environment environment =
      options.environment == "uniform" ? Environment() : Environment(options.environment);
  const std::vector<BoundModel> models = models_for(options, stack);
  const std::vector<std::string> names = names_of(models);
  const std::string folder = options.output.empty() ? stack.name + "-preview" : options.output;
  make_output_folder(folder);
  catch_interrupts();
  const LobeTable table = LobeTable::make(stack, options);
  std::FILE* out = table_stream(options);
  if (!options.quiet) fmt::print(out, "{}: truth by {}\n", stack.name, table.source());
  Json answer = json_header("preview", stack, options);
  Json views = Json::array();
  for (const PreviewScene scene : {PreviewScene::sphere, PreviewScene::plane})
    for (const PreviewLight light : {PreviewLight::lamp, PreviewLight::environment}) {
      if (interrupted) break;
      const PreviewView view{scene, light, options.size, theta, phi};
      std::vector<PreviewColumn> columns;
      columns.push_back({"truth", render([&](Direction wi, Direction wo) { return table(wi, wo); },
                                         view, environment)});
      for (std::size_t k = 0; k < models.size(); ++k) {
        const Model& model = *models[k].model;
        columns.push_back(
            {names[k], render([&](Direction wi, Direction wo) { return model.eval(wi, wo); }, view,
                              environment)});
      }
      const std::string name = to_text(scene) + "_" + to_text(light);
      ExrImage image;
      image.width = view.width();
      image.height = view.height();
      image.attributes = {{"lamella.version", LAMELLA_VERSION},
                          {"lamella.command", "preview"},
                          {"lamella.stack", to_toml(stack)},
                          {"lamella.stack_name", stack.name},
                          {"lamella.truth", table.source()},
                          {"lamella.view", name},
                          {"lamella.conventions",
                           "radiance; the lamp gives a perpendicular surface the irradiance pi; "
                           "plain R, G, B: the truth"}};
      Json pictures = Json::array();
      for (std::size_t k = 0; k < columns.size(); ++k) {
        add_channels(image, columns[k].name, columns[k].image, k == 0);
        pictures.push_back(
            {{"name", columns[k].name}, {"mean_luminance", mean_luminance(columns[k].image)}});
        if (!options.quiet)
          fmt::print(out, "  {:<20} {:<28} mean luminance {:.5f}\n", name, columns[k].name,
                     mean_luminance(columns[k].image));
      }
      write_exr(folder + "/" + name + ".exr", image);
      write_file(folder + "/" + name + ".png",
                 draw_preview(fmt::format("{}: {} under {}", stack.name, to_text(scene),
                                          light == PreviewLight::lamp        ? "a distant lamp"
                                          : options.environment == "uniform" ? "uniform light"
                                                                             : "the environment"),
                              columns));
      views.push_back({{"scene", to_text(scene)},
                       {"light", to_text(light)},
                       {"pictures", std::move(pictures)}});
    }
  answer["truth"] = table.source();
  answer["interrupted"] = interrupted.load();
  answer["views"] = std::move(views);
  if (!options.quiet) fmt::print(out, "wrote {}/: an EXR and a PNG per view\n", folder);
  write_json(answer, options);
  return kDone;
}

}  // namespace lamella
