#include "compare/judge/accuracy_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/fit/fitted_models.h"
#include "compare/judge/comparison.h"
#include "compare/request/model_request.h"
#include "compare/request/truth_request.h"
#include "compare/truth/ground_truth.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

struct Family {
  std::string name;
  std::vector<std::string> keys;            // of the layer, what varies
  std::vector<std::vector<double>> values;  // per stack
  std::string rest;                         // of the layer
};

const std::vector<Family>& families() {
  static const std::vector<Family> list{
      {"Lambert-sphere half space",
       {"albedo"},
       {{0.9}, {0.3}, {0.5}, {0.7}, {0.99}, {1}},
       "medium = \"lambert_sphere\"\nthickness = inf\n"},
      {"isotropic half space",
       {"albedo"},
       {{0.9}, {0.5}, {1}},
       "medium = \"henyey_greenstein\"\nthickness = inf\n"},
      {"half space of Lambertian vMF flakes",
       {"roughness", "albedo"},
       {{0.5, 0.9},
        {0.1, 0.5},
        {0.1, 1},
        {0.3, 0.5},
        {0.3, 1},
        {0.5, 0.5},
        {0.5, 1},
        {0.8, 0.5},
        {0.8, 1},
        {1, 0.5},
        {1, 1}},
       "medium = \"vmf_flake\"\nthickness = inf\n"},
      {"Henyey-Greenstein slab",
       {"g", "thickness", "albedo"},
       {{0.5, 1, 0.9}, {0.5, 0.1, 0.9}, {0.5, 4, 0.9}, {0.5, 1, 0.5}},
       "medium = \"henyey_greenstein\"\n"},
      {"slab of Lambertian SGGX flakes",
       {"roughness", "thickness", "albedo"},
       {{0.5, 1, 0.9}, {0.2, 1, 0.9}, {1, 1, 0.9}, {0.5, 0.1, 0.9}, {0.5, 4, 0.9}},
       "medium = \"sggx\"\nflake = \"lambert\"\n"},
  };
  return list;
}

std::vector<ModelAccuracy> accuracy_on(const Stack& stack, const std::string& family,
                                       double tolerance, const RunMonitor& monitor) {
  TruthRequest request{.stack = stack};
  request.estimator = Estimator::deterministic;
  request.tolerance = tolerance;
  GroundTruth truth(std::move(request), Estimator::analog, monitor);
  const std::vector<BoundModel> models = fitted_models_for({}, stack);
  std::vector<ModelAccuracy> rows;
  for (const BoundModel& m : models)
    rows.push_back({family, stack.name, m.info->name, {}, {}, 0, 0});
  for (std::size_t k = 0; k < truth.directions().size(); ++k) {
    const RunResult run = truth.find(k).run;
    for (std::size_t m = 0; m < models.size(); ++m) {
      for (const bool up : {true, false}) {
        if (!up && !truth.plan().transmits) continue;
        const ProjectedLobes projected =
            project(*models[m].model, *models[m].info, run.incident, run.grid, up, run.channels);
        const LobeComparison all = compare(run, nullptr, projected, up).back();
        (up ? rows[m].reflected : rows[m].transmitted).push_back(all.relative_rmse);
        rows[m].energy_off =
            std::max(rows[m].energy_off, std::abs(all.energy_model[0] - all.energy_truth[0]));
      }
      rows[m].bound = std::max(rows[m].bound, run.accuracy->error);
    }
  }
  return rows;
}

}  // namespace

void measure_model_accuracy(bool quick, double tolerance, const RunMonitor& monitor,
                            const std::function<void(const ModelAccuracy&)>& report) {
  for (const Family& family : families())
    for (std::size_t k = 0; k < (quick ? 1 : family.values.size()) && !monitor.is_stopped(); ++k) {
      std::string toml = "[[layer]]\n" + family.rest, name;
      for (std::size_t i = 0; i < family.keys.size(); ++i) {
        toml += fmt::format("{} = {}\n", family.keys[i], family.values[k][i]);
        name += fmt::format("{}{} {}", i ? ", " : "", family.keys[i], family.values[k][i]);
      }
      for (const ModelAccuracy& row :
           accuracy_on(parse_stack(toml, family.name, name), family.name, tolerance, monitor))
        report(row);
    }
}

}  // namespace lamella
