#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "analytic/layered/spongecake.h"
#include "compare/command/accuracy_commands.h"
#include "compare/command/command.h"
#include "compare/command/picture_options.h"
#include "compare/ensemble/spongecake_accuracy.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/reproduce/spongecake_matrix.h"
#include "compare/request/percent.h"
#include "compare/request/run_monitor.h"
#include "compare/request/stopwatch.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;
using Rows = std::vector<const SpongecakeAccuracy*>;
using Value = std::function<double(const SpongecakeAccuracy&)>;

constexpr std::size_t kWorst = 5;

double mean_of(const Rows& rows, const Value& value) {
  double sum = 0;
  for (const SpongecakeAccuracy* row : rows) sum += value(*row);
  return rows.empty() ? 0 : sum / static_cast<double>(rows.size());
}

double quantile_of(const Rows& rows, const Value& value, double share) {
  std::vector<double> values;
  for (const SpongecakeAccuracy* row : rows) values.push_back(value(*row));
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const std::size_t below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return std::lerp(values[below], values[above], at - static_cast<double>(below));
}

// What rows are grouped by: over all layers of a stack.
double mean_over_layers(const Stack& stack, const std::function<double(const Layer&)>& of) {
  double sum = 0;
  for (const Layer& layer : stack.layers) sum += of(layer);
  return sum / static_cast<double>(stack.layers.size());
}
bool is_fiber(const Layer& layer) { return layer.parameters.choice("shape") == "fiber"; }
double albedo_of(const Layer& layer) {
  return (layer.albedo.r + layer.albedo.g + layer.albedo.b) / 3;
}
double depth_of(const Stack& stack) {
  double depth = 0;
  for (const Layer& layer : stack.layers) depth += layer.depth();
  return depth;
}
double roughness_of(const Stack& stack) {
  double least = 1;
  for (const Layer& layer : stack.layers)
    least = std::min(least, layer.parameters.number("roughness"));
  return least;
}

struct StackPart {
  std::string name;
  std::function<bool(const Stack&)> has;
};

// The parts of the stacks with this many layers.
std::vector<StackPart> parts_of(std::size_t layers) {
  const std::string name = layers == 1 ? "one layer" : "two layers";
  std::vector<StackPart> list;
  const auto add = [&](const std::string& part, const std::function<bool(const Stack&)>& has) {
    list.push_back({part.empty() ? "**" + name + "**" : name + ": " + part,
                    [=](const Stack& s) { return s.layers.size() == layers && has(s); }});
  };
  const auto fibers = [](double from, double to) {
    return [=](const Stack& s) {
      const double share = mean_over_layers(s, [](const Layer& l) { return is_fiber(l) ? 1 : 0; });
      return share >= from && share <= to;
    };
  };
  const auto within = [](double (*of)(const Stack&), double from, double to) {
    return [=](const Stack& s) { return of(s) >= from && of(s) < to; };
  };
  const auto albedo = [](const Stack& s) { return mean_over_layers(s, albedo_of); };
  add("", [](const Stack&) { return true; });
  add(layers == 1 ? "surface" : "surfaces", fibers(0, 0));
  add(layers == 1 ? "fiber" : "fibers", fibers(1, 1));
  add("one of each", fibers(0.1, 0.9));
  add("least roughness 0.05 to 0.2", within(roughness_of, 0, 0.2));
  add("least roughness 0.2 to 0.5", within(roughness_of, 0.2, 0.5));
  add("least roughness 0.5 to 1", within(roughness_of, 0.5, 2));
  add("depth below 0.3", within(depth_of, 0, 0.3));
  add("depth 0.3 to 3", within(depth_of, 0.3, 3));
  add("depth above 3", within(depth_of, 3, 1e9));
  add("mean albedo below 0.4", within(albedo, 0, 0.4));
  add("mean albedo 0.4 to 0.7", within(albedo, 0.4, 0.7));
  add("mean albedo above 0.7", within(albedo, 0.7, 2));
  return list;
}

double fit_of(const SpongecakeAccuracy& r, double LobeErrors::*which) {
  return r.fit ? (*r.fit).*which : 0;
}
double fit_elsewhere_of(const SpongecakeAccuracy& r) {
  return r.fit_elsewhere ? r.fit_elsewhere->multiple : 0;
}

std::string cell(const Rows& rows, const Value& value) {
  return fmt::format("{} / {}", percent_text(mean_of(rows, value)),
                     percent_text(quantile_of(rows, value, 0.9)));
}

void print_part(std::FILE* out, const std::string& name, const Rows& rows, bool fits) {
  const auto none = [](double LobeErrors::*which) {
    return [which](const SpongecakeAccuracy& r) { return r.nothing.*which; };
  };
  const auto network = [](double LobeErrors::*which) {
    return [which](const SpongecakeAccuracy& r) { return r.network.*which; };
  };
  const auto fit = [](double LobeErrors::*which) {
    return [which](const SpongecakeAccuracy& r) { return fit_of(r, which); };
  };
  const std::string no_fit = "–";
  fmt::print(out, "| {} | {} | {} | {} | {} | {} | {} | {} |\n", name, rows.size(),
             cell(rows, network(&LobeErrors::multiple)),
             fits ? cell(rows, fit(&LobeErrors::multiple)) : no_fit,
             fits ? cell(rows, fit_elsewhere_of) : no_fit, cell(rows, none(&LobeErrors::all)),
             cell(rows, network(&LobeErrors::all)),
             fits ? cell(rows, fit(&LobeErrors::all)) : no_fit);
}

std::string described(const Stack& stack) {
  std::string text;
  for (const Layer& layer : stack.layers)
    text += fmt::format("{}{} alpha {:.2f}, depth {:.2g}, albedo {:.2f}", text.empty() ? "" : "; ",
                        layer.parameters.choice("shape"), layer.parameters.number("roughness"),
                        layer.depth(), albedo_of(layer));
  return text;
}

// The worst first.
Rows worst_of(Rows rows, const Value& value) {
  std::sort(rows.begin(), rows.end(),
            [&](const auto* a, const auto* b) { return value(*a) > value(*b); });
  rows.resize(std::min(kWorst, rows.size()));
  return rows;
}

double network_error(const SpongecakeAccuracy& row) { return row.network.multiple; }
double form_error(const SpongecakeAccuracy& row) { return fit_of(row, &LobeErrors::multiple); }

void print_worst(std::FILE* out, const std::string& title, const Rows& worst) {
  fmt::print(out,
             "\n{}\n\n| stack | network | fit | 2+ of the energy | noise |\n"
             "| --- | --- | --- | --- | --- |\n",
             title);
  for (const SpongecakeAccuracy* row : worst)
    fmt::print(out, "| {}: {} | {} | {} | {} | {} |\n", row->stack.name, described(row->stack),
               percent_text(row->network.multiple), percent_text(form_error(*row)),
               percent_text(row->multiple_share), percent_text(row->noise));
}

// Lobe matrices of these stacks, NAME.png, with this many walks along each of their directions;
// those that were written.
std::vector<std::string> draw_worst(const std::filesystem::path& folder, const Rows& worst,
                                    std::uint64_t walks, const RunMonitor& monitor) {
  std::vector<std::string> written;
  for (const SpongecakeAccuracy* row : worst) {
    const std::string name = row->stack.name + ".png";
    if (monitor.is_stopped() || std::find(written.begin(), written.end(), name) != written.end())
      continue;
    const MultipleLobes truth = matrix_truth(row->stack, walks, 1, monitor.stop);
    if (monitor.is_stopped()) break;
    const SpongecakeTrial trial(row->stack, truth);
    std::optional<SpongecakeLobes> best;
    if (row->fit) best = SpongecakeTrial(row->stack, thinned(truth)).best();
    const LobeMatrix matrix =
        spongecake_matrix(trial, predicted_lobes(row->stack), best, false,
                          fmt::format("{}: {}", row->stack.name, described(row->stack)));
    write_file(folder / name, draw_lobe_matrix(matrix, PictureFormat::png));
    written.push_back(name);
  }
  return written;
}

void print_parts(std::FILE* out, const AccuracyEnsemble& ensemble, const Rows& all, bool fits) {
  fmt::print(out,
             "{} random stacks, {} walks along each of {} directions; relative RMSE over 8 x 16 "
             "cells\nper side and 3 channels, noise taken off: mean / 90th percentile over the "
             "stacks; noise {}\nof a stack's RMS on average; best fit: to the cells that it is "
             "judged on; fit elsewhere: to as many\ndirections of its own\n\n"
             "| stacks | number | 2+: network | 2+: best fit | 2+: fit elsewhere | all: no lobes | "
             "all: network | all: best fit |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n",
             all.size(), ensemble.walks, ensemble.directions,
             percent_text(mean_of(all, [](const SpongecakeAccuracy& r) { return r.noise; })));
  for (const std::size_t layers : {1u, 2u})
    for (const StackPart& part : parts_of(layers)) {
      Rows those;
      for (const SpongecakeAccuracy* row : all)
        if (part.has(row->stack)) those.push_back(row);
      if (!those.empty()) print_part(out, part.name, those, fits);
    }
}

Json errors_json(const LobeErrors& e) { return {{"multiple", e.multiple}, {"all", e.all}}; }

}  // namespace

Json spongecake_accuracy(const Options& options, const RunMonitor& monitor, std::FILE* out) {
  AccuracyEnsemble ensemble;
  if (options.quick) ensemble.one_layer = ensemble.two_layers = 8;
  if (options.walks_given) ensemble.walks = options.walks;
  const bool draws = !options.output.empty();
  // Before the work: a folder that cannot be made, a build that cannot draw.
  if (draws) {
    (void)picture_formats_of({"png"});
    make_output_folder(options.output);
  }
  std::vector<SpongecakeAccuracy> rows;
  Json list = Json::array();
  measure_spongecake_accuracy(ensemble, monitor, [&](const SpongecakeAccuracy& row) {
    rows.push_back(row);
    Json one{{"name", row.stack.name},
             {"stack", to_toml(row.stack)},
             {"noise", row.noise},
             {"multiple_share", row.multiple_share},
             {"nothing", errors_json(row.nothing)},
             {"network", errors_json(row.network)}};
    if (row.fit) one["fit"] = errors_json(*row.fit);
    if (row.fit_elsewhere) one["fit_elsewhere"] = errors_json(*row.fit_elsewhere);
    list.push_back(std::move(one));
  });
  if (monitor.finished) monitor.finished();
  if (rows.empty()) return list;
  Rows all;
  for (const SpongecakeAccuracy& row : rows) all.push_back(&row);
  const bool fits = rows.front().fit.has_value();
  const Rows network = worst_of(all, network_error);
  const Rows form = fits ? worst_of(all, form_error) : Rows();
  if (!options.quiet) {
    print_parts(out, ensemble, all, fits);
    print_worst(out, "Where the network is worst", network);
    if (fits) print_worst(out, "Where the form of two lobes is worst", form);
    const double seconds = wall_seconds_of([&] {
      for (const SpongecakeAccuracy* row : all) (void)predicted_lobes(row->stack);
    });
    fmt::print(out, "\nthe network predicts a stack's lobes in {:.0f} microseconds\n",
               1e6 * seconds / static_cast<double>(all.size()));
  }
  if (draws) {
    Rows worst = network;
    worst.insert(worst.end(), form.begin(), form.end());
    const std::vector<std::string> written =
        draw_worst(options.output, worst, ensemble.walks, monitor);
    if (!options.quiet) fmt::print(out, "wrote {}/: {}\n", options.output, fmt::join(written, " "));
  }
  return list;
}

}  // namespace lamella
