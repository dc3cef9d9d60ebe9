#include "compare/judge/coat_accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "compare/fit/fitted_models.h"
#include "compare/judge/comparison.h"
#include "compare/request/truth_request.h"
#include "compare/truth/ground_truth.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

Stack coat_over_lambert(double ior, double roughness, double albedo) {
  const std::string facets = roughness == 0
                                 ? "interface = \"smooth\"\n"
                                 : fmt::format("interface = \"ggx\"\nroughness = {}\n", roughness);
  return parse_stack(
      fmt::format("[[layer]]\n{}ior = {}\n[substrate]\nalbedo = {}\n", facets, ior, albedo),
      "coats", "coat over Lambert's law");
}

// Of the base's lobe: orders 1 and up, which are all that cells hold where a coat is smooth.
double base_error(const RunResult& run, const BoundModel& model) {
  const Order base = run.reflected.has_zero_lobe() ? Order::scattered : Order::all;
  const ProjectedLobes projected =
      project(*model.model, *model.info, run.incident, run.grid, true, run.channels);
  for (const LobeComparison& lobe : compare(run, nullptr, projected, true))
    if (lobe.order == base) return lobe.relative_rmse;
  throw std::logic_error("a coat without a base's lobe");
}

}  // namespace

CoatRanges coat_ranges(bool quick) {
  if (quick) return {{1.5}, {0, 0.3}, {0.8}};
  return {{1.3, 1.5, 2}, {0, 0.1, 0.3, 0.6, 1}, {0.05, 0.2, 0.5, 0.8, 1}};
}

void measure_coat_accuracy(bool quick, double tolerance, const RunMonitor& monitor,
                           const std::function<void(const CoatAccuracy&)>& report) {
  const CoatRanges ranges = coat_ranges(quick);
  for (const double ior : ranges.ior)
    for (const double albedo : ranges.albedo)
      for (const double roughness : ranges.roughness) {
        if (monitor.is_stopped()) return;
        TruthRequest request{.stack = coat_over_lambert(ior, roughness, albedo)};
        request.estimator = Estimator::deterministic;
        request.tolerance = tolerance;
        request.directions = {direction_from_degrees(30, 0), direction_from_degrees(80, 0)};
        const std::vector<BoundModel> models = fitted_models_for({}, request.stack);
        GroundTruth truth(std::move(request), Estimator::analog, monitor);
        std::vector<CoatAccuracy> rows;
        for (const BoundModel& m : models)
          if (m.info->name == "coated")
            rows.push_back({m.parameters.choice(m.info->alternatives), ior, roughness, albedo});
        for (const std::size_t k : {0, 1}) {
          const RunResult run = truth.find(k).run;
          std::size_t row = 0;
          for (const BoundModel& m : models) {
            if (m.info->name != "coated") continue;
            (k == 0 ? rows[row].at_30 : rows[row].at_80) = base_error(run, m);
            rows[row].bound = std::max(rows[row].bound, run.accuracy->error);
            ++row;
          }
        }
        std::for_each(rows.begin(), rows.end(), report);
      }
}

}  // namespace lamella
