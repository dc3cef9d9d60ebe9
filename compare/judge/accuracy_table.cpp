#include "compare/judge/accuracy_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/fit/fitted_models.h"
#include "compare/judge/comparison.h"
#include "compare/request/model_request.h"
#include "compare/request/substrate_model.h"
#include "compare/request/truth_request.h"
#include "compare/truth/ground_truth.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

struct Family {
  std::string name;
  std::vector<std::string> keys;            // what varies: of the layer, unless `coat`
  std::vector<std::vector<double>> values;  // per stack
  std::string rest;                         // of the layer; of the substrate under a coat
  // Coats (keys: ior, roughness (0: smooth), albedo of the base) and flakes without symmetry about
  // the normal cost the solver time for digits that no difference of closed forms needs.
  bool coat = false, leans = false;
};

std::string toml_of(const Family& family, const std::vector<double>& values) {
  if (family.coat) {
    const bool smooth = values[1] == 0;
    return fmt::format("[[layer]]\ninterface = \"{}\"\nior = {}\n{}[substrate]\n{}albedo = {}\n",
                       smooth ? "smooth" : "ggx", values[0],
                       smooth ? "" : fmt::format("roughness = {}\n", values[1]), family.rest,
                       values[2]);
  }
  std::string toml = "[[layer]]\n" + family.rest;
  for (std::size_t i = 0; i < family.keys.size(); ++i)
    toml += fmt::format("{} = {}\n", family.keys[i], values[i]);
  return toml;
}

constexpr double kCoatTolerance = 1e-4, kLeaningTolerance = 1e-6;
// Of four directions among flakes that lean; on a machine with other work some take five minutes.
constexpr double kLeaningSeconds = 1200;

// One of the values at a time, about an index of 1.5, alpha 0.1 and albedo 0.8; then the corners
// where light stays longest.
const std::vector<std::vector<double>> kCoats{
    {1.5, 0.1, 0.8}, {1.3, 0.1, 0.8}, {2, 0.1, 0.8},    {1.5, 0, 0.8},   {1.5, 0.3, 0.8},
    {1.5, 0.6, 0.8}, {1.5, 1, 0.8},   {1.5, 0.1, 0.05}, {1.5, 0.1, 0.5}, {1.5, 0.1, 1},
    {2, 0, 1},       {2, 1, 1},       {1.3, 0, 0.05}};

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
      {"slab of SGGX mirror fibers along x",
       {"roughness", "thickness", "albedo"},
       {{0.5, 1, 0.9}, {0.3, 1, 0.9}, {0.5, 0.1, 0.9}, {0.5, 4, 0.9}, {0.5, 1, 0.5}},
       "medium = \"sggx\"\nshape = \"fiber\"\n",
       false,
       true},
      {"slab of SGGX mirror flakes that lean by 45 degrees",
       {"roughness", "thickness", "albedo"},
       {{0.5, 1, 0.9}, {0.3, 1, 0.9}},
       "medium = \"sggx\"\naxis = [1, 0, 1]\n",
       false,
       true},
      {"GGX coat over Lambert's law",
       {"ior", "roughness", "albedo"},
       kCoats,
       "bsdf = \"lambert\"\n",
       true},
      {"GGX coat over EON of roughness 0.5",
       {"ior", "roughness", "albedo"},
       {{1.5, 0.09, 0.8}, {1.5, 0.36, 0.8}, {1.5, 0.09, 0.2}, {1.6, 0, 0.8}},
       "bsdf = \"eon\"\nroughness = 0.5\n",
       true},
  };
  return list;
}

std::vector<ModelAccuracy> accuracy_on(const Stack& stack, const std::string& family,
                                       double tolerance, std::optional<double> seconds,
                                       const RunMonitor& monitor) {
  TruthRequest request{.stack = stack};
  request.estimator = Estimator::deterministic;
  request.tolerance = tolerance;
  request.effort.seconds = seconds;
  GroundTruth truth(std::move(request), Estimator::analog, monitor);
  const std::vector<BoundModel> models = fitted_models_for({}, stack);
  std::vector<ModelAccuracy> rows;
  for (const BoundModel& m : models) {
    // A model of several alternatives is told by the one that it has.
    std::string name = m.info->name;
    if (!m.info->alternatives.empty()) name += ", " + m.parameters.choice(m.info->alternatives);
    rows.push_back({family, stack.name, name, {}, {}, 0, 0});
  }
  for (std::size_t k = 0; k < truth.directions().size(); ++k) {
    const RunResult run = truth.find(k).run;
    for (std::size_t m = 0; m < models.size(); ++m) {
      for (const bool up : {true, false}) {
        if (!up && !truth.plan().transmits) continue;
        const ProjectedLobes projected =
            project(*models[m].model, *models[m].info, run.incident, run.grid, up, run.channels);
        const std::vector<LobeComparison> lobes = compare(run, nullptr, projected, up);
        const LobeComparison& all =
            *std::find_if(lobes.begin(), lobes.end(),
                          [](const LobeComparison& l) { return l.order == Order::all; });
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
  for (const Family& family : families()) {
    if (quick && family.leans) continue;
    for (std::size_t k = 0; k < (quick ? 1 : family.values.size()) && !monitor.is_stopped(); ++k) {
      std::string name;
      for (std::size_t i = 0; i < family.keys.size(); ++i)
        name += fmt::format("{}{} {}", i ? ", " : "", family.keys[i], family.values[k][i]);
      const Stack stack =
          with_surface_model(parse_stack(toml_of(family, family.values[k]), family.name, name));
      const double enough = family.coat    ? std::max(tolerance, kCoatTolerance)
                            : family.leans ? std::min(tolerance, kLeaningTolerance)
                                           : tolerance;
      const std::optional<double> seconds =
          family.leans ? std::optional(kLeaningSeconds) : std::nullopt;
      for (const ModelAccuracy& row : accuracy_on(stack, family.name, enough, seconds, monitor))
        report(row);
    }
  }
}

}  // namespace lamella
