#include "compare/report/lobe_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "compare/drawing/lobe_picture.h"
#include "compare/judge/verdict_text.h"
#include "phase/math/degrees.h"
#include "phase/math/luminance.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/stack_paths.h"

namespace lamella {
namespace {

std::string side_name(bool reflected) { return reflected ? "reflect" : "transmit"; }

std::string channel_letter(int channels, int c) {
  return channels == 1 ? "Y" : std::string(1, "RGB"[c]);
}

void add(ExrImage& image, int run, bool reflected, Order order, const std::string& part,
         const std::vector<double>& values, int channels) {
  const std::size_t cells = values.size() / channels;
  for (int c = 0; c < channels; ++c)
    image.channels.emplace_back(channel_name(run, side_name(reflected), lobe_name(order), part,
                                             channel_letter(channels, c)),
                                exr_values(std::span(values).subspan(c * cells, cells)));
}

int index_of(const std::vector<RunResult>& runs, Direction wi) {
  for (std::size_t k = 0; k < runs.size(); ++k)
    if (runs[k].incident == wi) return static_cast<int>(k);
  return 0;
}

ExrImage empty_image(const TruthRequest& request, const std::vector<RunResult>& runs) {
  ExrImage image;
  image.width = runs[0].grid.columns();
  image.height = runs[0].grid.rows();
  image.attributes = file_attributes(request, runs);
  return image;
}

// exact if it is that for any direction: the numbers of walks then tell for which.
OrderOne order_one_of(const std::vector<RunResult>& runs) {
  return std::any_of(runs.begin(), runs.end(),
                     [](const RunResult& run) { return run.order_one == OrderOne::exact; })
             ? OrderOne::exact
             : OrderOne::walked;
}

// What the channels named se hold, and of the solver how far it got.
void add_error_attributes(std::map<std::string, std::string>& attributes,
                          const std::vector<RunResult>& runs, double tolerance) {
  if (!runs[0].is_bounded()) {
    attributes["lamella.se"] = order_one_of(runs) == OrderOne::exact
                                   ? "standard error; of order 1 an error bound"
                                   : "standard error";
    return;
  }
  attributes["lamella.se"] = "error bound of the deterministic solver";
  attributes["lamella.tolerance"] = to_text(tolerance);
  std::string& reached = attributes["lamella.error_reached"];
  for (const RunResult& run : runs)
    reached += fmt::format("{}{:.1e}", reached.empty() ? "" : " ", run.accuracy->error);
  attributes["lamella.nodes"] = fmt::format("{}", runs[0].accuracy->nodes);
  const auto& modes = runs[0].accuracy->channel_modes;
  attributes["lamella.modes"] = fmt::format("{}", fmt::join(modes, " "));
  if (runs[0].accuracy->harmonics > 0)
    attributes["lamella.integrated_from"] = fmt::format("{}", runs[0].accuracy->integrated_from);
}

}  // namespace

std::map<std::string, std::string> file_attributes(const TruthRequest& request,
                                                   const std::vector<RunResult>& runs) {
  std::string degrees, directions, walks;
  for (const RunResult& run : runs) {
    degrees += fmt::format("{}{},{}", degrees.empty() ? "" : " ", theta_degrees(run.incident),
                           phi_degrees(run.incident));
    const Direction w = run.incident;
    directions += fmt::format("{}{},{},{}", directions.empty() ? "" : " ", w.x, w.y, w.z);
    walks += fmt::format("{}{}", walks.empty() ? "" : " ", run.walks);
  }
  const CellGrid& grid = runs[0].grid;
  std::map<std::string, std::string> attributes{
      {"lamella.version", LAMELLA_VERSION},
      {"lamella.stack", to_toml(request.stack)},
      {"lamella.stack_name", request.stack.name},
      {"lamella.seed", fmt::format("{}", request.seed)},
      {"lamella.walks", walks},
      {"lamella.max_order", fmt::format("{}", runs[0].max_order)},
      {"lamella.thin_from", fmt::format("{}", runs[0].thinning.first)},
      {"lamella.estimator", to_text(runs[0].estimator)},
      {"lamella.estimator_asked", estimator_asked(request)},
      {"lamella.isa", to_text(request.isa)},
      {"lamella.incident", degrees},
      {"lamella.directions", directions},
      {"lamella.grid", fmt::format("{}x{}", grid.mu_cells, grid.phi_cells)},
      {"lamella.phi", grid.folded
                          ? "folded: columns cover 0 to 180 degrees, each stands for phi and -phi"
                          : "columns cover 0 to 360 degrees"},
      {"lamella.conventions",
       "f in 1/sr without the cosine, cosine-weighted mean over each cell; x: azimuth of w_o "
       "relative to w_i from 0; y: mu_o^2 in equal steps, normal incidence at the top; both "
       "directions point away from the stack; wiN: N-th incident direction (theta,phi in "
       "degrees); se: what lamella.se says"}};
  if (!request.texels.empty())
    attributes["lamella.texels"] = fmt::format("{}", request.texels.size());
  if (!runs[0].is_bounded()) {
    attributes["lamella.sampling"] = to_text(runs[0].sampling);
    attributes["lamella.order_1"] = to_text(order_one_of(runs));
  }
  add_error_attributes(attributes, runs, request.tolerance);
  return attributes;
}

ExrImage simulation_image(const TruthRequest& request, const std::vector<RunResult>& runs) {
  ExrImage image = empty_image(request, runs);
  for (std::size_t k = 0; k < runs.size(); ++k)
    for (const bool reflected : {true, false}) {
      const SideResult& side = reflected ? runs[k].reflected : runs[k].transmitted;
      for (int o = 0; o < static_cast<int>(side.lobes.size()); ++o) {
        if (side.lobes[o].value.empty()) continue;
        const int n = static_cast<int>(k);
        add(image, n, reflected, static_cast<Order>(o), "", side.lobes[o].value, runs[k].channels);
        add(image, n, reflected, static_cast<Order>(o), "se", side.lobes[o].standard_error,
            runs[k].channels);
      }
    }
  add_plain_channels(image);
  return image;
}

void add_map_errors(ExrImage& image, const std::vector<RunResult>& map_errors) {
  for (std::size_t k = 0; k < map_errors.size(); ++k)
    for (const bool reflected : {true, false}) {
      const SideResult& side = reflected ? map_errors[k].reflected : map_errors[k].transmitted;
      for (int o = 0; o < static_cast<int>(side.lobes.size()); ++o)
        if (!side.lobes[o].value.empty())
          add(image, static_cast<int>(k), reflected, static_cast<Order>(o), "map_error",
              side.lobes[o].standard_error, map_errors[k].channels);
    }
}

ExrImage comparison_image(const TruthRequest& request, const std::vector<RunResult>& runs,
                          const std::vector<LobeComparison>& lobes, const std::string& model) {
  ExrImage image = empty_image(request, runs);
  image.attributes["lamella.model"] = model;
  for (const LobeComparison& l : lobes) {
    const int run = index_of(runs, l.wi);
    const Order order = l.order;
    const int channels = static_cast<int>(l.energy_truth.size());
    std::vector<double> difference(l.truth.size());
    for (std::size_t k = 0; k < difference.size(); ++k) difference[k] = l.model[k] - l.truth[k];
    const auto put = [&](const char* part, const std::vector<double>& values) {
      add(image, run, l.reflected, order, part, values, channels);
    };
    put("truth", l.truth);
    put("se", l.standard_error);
    put("model", l.model);
    put("difference", difference);
    put("z", l.z());
    // What viewers show at first: the model's reflection, all orders, first direction.
    if (run == 0 && l.reflected && l.order == Order::all)
      for (int c = 0; c < channels; ++c) {
        const std::size_t cells = l.model.size() / channels;
        image.channels.emplace_back(channel_letter(channels, c),
                                    exr_values(std::span(l.model).subspan(c * cells, cells)));
      }
  }
  return image;
}

void record_files(ExrImage& image, const InputFiles& inputs, const std::filesystem::path& folder) {
  if (!inputs.empty()) image.attributes["lamella.files"] = inputs.text(folder);
}

TruthRequest named_for_image(TruthRequest request, const std::filesystem::path& folder) {
  request.stack = with_files_relative_to(std::move(request.stack), folder);
  return request;
}

int write_comparison_pictures(const std::string& folder, const std::string& model,
                              const std::string& label, const std::string& stack,
                              const std::vector<RunResult>& runs,
                              const std::vector<LobeComparison>& lobes,
                              const std::vector<PictureFormat>& formats) {
  int count = 0;
  if (formats.empty()) return count;
  for (const LobeComparison& l : lobes) {
    const int run = index_of(runs, l.wi), channels = static_cast<int>(l.energy_truth.size());
    const std::size_t cells = runs[run].grid.cells();
    LobePicture picture;
    picture.grid = runs[run].grid;
    const std::vector<double> z = l.z();
    double energy = 0;
    for (std::size_t k = 0; k < cells; ++k) {
      // Colour as luminance; z as that of the channel farthest off.
      double truth = 0, value = 0, farthest = 0;
      bool seen = false;
      for (int c = 0; c < channels; ++c) {
        const double weight = channels == 1 ? 1 : kLuminanceWeights[c];
        const std::size_t i = c * cells + k;
        truth += weight * l.truth[i];
        value += weight * l.model[i];
        seen = seen || l.standard_error[i] > 0;
        if (std::abs(z[i]) > std::abs(farthest)) farthest = z[i];
      }
      picture.truth.push_back(truth);
      picture.model.push_back(value);
      picture.difference.push_back(value - truth);
      picture.z.push_back(seen ? farthest : std::nan(""));
      energy += truth + std::abs(value);
    }
    if (energy == 0) continue;
    const std::string lobe = to_text(l.order) == "all" ? "all orders" : "order " + to_text(l.order);
    picture.title = fmt::format("{} against simulation of {}", label, stack);
    picture.subtitle = fmt::format(
        "\u03b8_i = {:.4g}\u00b0, \u03c6_i = {:.4g}\u00b0, {}, {}{}: {}", theta_degrees(l.wi),
        phi_degrees(l.wi), l.reflected ? "reflected" : "transmitted", lobe,
        channels == 1 ? "" : fmt::format(", {}", kLuminanceName), verdict_text(l));
    picture.mu_i = std::abs(l.wi.z);
    picture.transmitted = !l.reflected;
    picture.bounded = l.bounded;
    write_pictures(fmt::format("{}/{}_wi{}_{}_{}", folder, model, run, side_name(l.reflected),
                               lobe_name(l.order)),
                   formats, [&](PictureFormat format) { return draw_lobe(picture, format); });
    ++count;
  }
  return count;
}

}  // namespace lamella
