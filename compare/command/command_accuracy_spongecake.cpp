#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "analytic/layered/spongecake.h"
#include "compare/command/accuracy_commands.h"
#include "compare/command/command.h"
#include "compare/ensemble/spongecake_accuracy.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
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

std::vector<StackPart> parts() {
  const auto layers = [](std::size_t n) {
    return [n](const Stack& s) { return s.layers.size() == n; };
  };
  const auto within = [](double (*of)(const Stack&), double from, double to) {
    return [=](const Stack& s) { return of(s) >= from && of(s) < to; };
  };
  const auto albedo = [](const Stack& s) { return mean_over_layers(s, albedo_of); };
  return {{"one layer", layers(1)},
          {"two layers", layers(2)},
          {"one layer: surface",
           [](const Stack& s) { return s.layers.size() == 1 && !is_fiber(s.layers[0]); }},
          {"one layer: fiber",
           [](const Stack& s) { return s.layers.size() == 1 && is_fiber(s.layers[0]); }},
          {"least roughness 0.05 to 0.2", within(roughness_of, 0, 0.2)},
          {"least roughness 0.2 to 0.5", within(roughness_of, 0.2, 0.5)},
          {"least roughness 0.5 to 1", within(roughness_of, 0.5, 2)},
          {"depth below 0.3", within(depth_of, 0, 0.3)},
          {"depth 0.3 to 3", within(depth_of, 0.3, 3)},
          {"depth above 3", within(depth_of, 3, 1e9)},
          {"mean albedo below 0.4", within(albedo, 0, 0.4)},
          {"mean albedo 0.4 to 0.7", within(albedo, 0.4, 0.7)},
          {"mean albedo above 0.7", within(albedo, 0.7, 2)}};
}

double fit_of(const SpongecakeAccuracy& r, double LobeErrors::*which) {
  return r.fit ? (*r.fit).*which : 0;
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
  fmt::print(out, "| {} | {} | {} | {} | {} | {} | {} |\n", name, rows.size(),
             cell(rows, network(&LobeErrors::multiple)),
             fits ? cell(rows, fit(&LobeErrors::multiple)) : no_fit,
             cell(rows, none(&LobeErrors::all)), cell(rows, network(&LobeErrors::all)),
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

void print_worst(std::FILE* out, const std::string& title, Rows rows, const Value& value) {
  std::sort(rows.begin(), rows.end(),
            [&](const auto* a, const auto* b) { return value(*a) > value(*b); });
  fmt::print(out,
             "\n{}\n\n| stack | network | fit | 2+ of the energy | noise |\n"
             "| --- | --- | --- | --- | --- |\n",
             title);
  for (std::size_t k = 0; k < std::min(kWorst, rows.size()); ++k)
    fmt::print(out, "| {}: {} | {} | {} | {} | {} |\n", rows[k]->stack.name,
               described(rows[k]->stack), percent_text(rows[k]->network.multiple),
               percent_text(fit_of(*rows[k], &LobeErrors::multiple)),
               percent_text(rows[k]->multiple_share), percent_text(rows[k]->noise));
}

Json errors_json(const LobeErrors& e) { return {{"multiple", e.multiple}, {"all", e.all}}; }

}  // namespace

Json spongecake_accuracy(const Options& options, const RunMonitor& monitor, std::FILE* out) {
  AccuracyEnsemble ensemble;
  if (options.quick) ensemble.one_layer = 16;
  if (options.walks_given) ensemble.walks = options.walks;
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
    list.push_back(std::move(one));
  });
  if (!options.quiet && !rows.empty()) {
    Rows all;
    for (const SpongecakeAccuracy& row : rows) all.push_back(&row);
    const bool fits = rows.front().fit.has_value();
    fmt::print(out,
               "{} random stacks, {} walks along each of {} directions; relative RMSE over 8 x 16 "
               "cells per side and 3\nchannels, noise taken off: mean / 90th percentile over the "
               "stacks; noise {} of a stack's RMS on average\n\n"
               "| stacks | number | 2+: network | 2+: best fit | all: no lobes | all: network | "
               "all: best fit |\n| --- | --- | --- | --- | --- | --- | --- |\n",
               rows.size(), ensemble.walks, ensemble.directions,
               percent_text(mean_of(all, [](const SpongecakeAccuracy& r) { return r.noise; })));
    print_part(out, "all", all, fits);
    for (const StackPart& part : parts()) {
      Rows those;
      for (const SpongecakeAccuracy& row : rows)
        if (part.has(row.stack)) those.push_back(&row);
      if (!those.empty()) print_part(out, part.name, those, fits);
    }
    print_worst(out, "Where the network is worst", all,
                [](const SpongecakeAccuracy& r) { return r.network.multiple; });
    if (fits)
      print_worst(out, "Where the form of two lobes is worst", all,
                  [](const SpongecakeAccuracy& r) { return fit_of(r, &LobeErrors::multiple); });
    const double seconds = wall_seconds_of([&] {
      for (const SpongecakeAccuracy* row : all) (void)predicted_lobes(row->stack);
    });
    fmt::print(out, "\nthe network predicts a stack's lobes in {:.0f} microseconds\n",
               1e6 * seconds / static_cast<double>(all.size()));
  }
  return list;
}

}  // namespace lamella
