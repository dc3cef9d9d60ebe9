#include <fmt/format.h>

#include <algorithm>

#include "compare/command/command.h"
#include "compare/files/output_folder.h"
#include "compare/judge/lobe_difference.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/first_look.h"
#include "compare/request/interrupt.h"
#include "compare/request/numbers.h"
#include "compare/request/percent.h"
#include "compare/request/run_monitor.h"
#include "compare/request/truth_request.h"
#include "compare/truth/estimator_choice.h"
#include "compare/truth/ground_truth.h"
#include "phase/math/degrees.h"
#include "phase/math/luminance.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "volume/voxels/density_grid.h"
#include "volume/voxels/depth_profile.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;
using Grids = std::vector<std::shared_ptr<const DensityGrid>>;

constexpr const char* kExample = "woven_cloth";

std::vector<double> factors_of(const Options& options) {
  std::vector<double> factors;
  for (const std::string& text : options.contrasts) {
    const auto value = parse_number(text);
    if (!value || !(*value >= 0 && *value <= 1))
      throw UsageError(fmt::format("--contrast: found \"{}\"; allowed: a number in [0, 1]", text));
    factors.push_back(*value);
  }
  if (factors.empty()) factors.push_back(1);
  return factors;
}

Grids scaled(const Stack& stack, const Grids& grids, double factor) {
  if (factor == 1) return grids;
  Grids out(grids.size());
  for (std::size_t k = 0; k < grids.size(); ++k)
    if (grids[k])
      out[k] = std::make_shared<DensityGrid>(
          stack.layers[k], std::make_shared<Voxels>(with_contrast(grids[k]->voxels(), factor)));
  return out;
}

std::string order_text(int slot) {
  static const char* const names[] = {"1", "2", "3", "4+", "all"};
  return names[slot];
}

Json to_json(const LobeDifference& l) {
  return {{"mu_i", l.wi.z},
          {"phi_i", phi_degrees(l.wi)},
          {"side", l.reflected ? "reflect" : "transmit"},
          {"order", order_text(l.order)},
          {"energy_grid", l.energy},
          {"energy_grid_standard_error", l.energy_error},
          {"energy_homogenised", l.energy_other},
          {"energy_homogenised_standard_error", l.energy_other_error},
          {"energy_grid_missing", l.energy_missing},
          {"energy_homogenised_missing", l.energy_other_missing},
          {"relative_rmse_without_noise", json_number(l.relative_rmse_without_noise)},
          {"p_value", l.p_value},
          {"verdict", to_text(l.verdict)}};
}

void print(std::FILE* out, const LobeDifference& l) {
  const double grid = luminance(l.energy), other = luminance(l.energy_other);
  fmt::print(out,
             "  {:>7g} {:>9} {:>5} {:>10.5f} {:>8.1e} {:>10.5f} {:>8.1e} {:>9} {:>10} "
             "{:>9.2g}  {}\n",
             theta_degrees(l.wi), l.reflected ? "reflect" : "transmit", order_text(l.order), grid,
             luminance(l.energy_error), other, luminance(l.energy_other_error),
             grid > 0 ? signed_percent_cell(other / grid - 1) : "-",
             percent_cell(l.relative_rmse_without_noise), l.p_value, to_text(l.verdict));
}

}  // namespace

int homogenise_command(const Options& options) {
  Options own = options;
  if (own.stack.empty()) own.stack = kExample;
  const Stack stack = stack_of(own);
  if (!stack.has_grid())
    throw UsageError(fmt::format(
        "{}: found no layer with a grid; allowed: a stack with one (lamella grid makes them)",
        stack.name));
  const std::vector<double> factors = factors_of(options);
  if (!options.output.empty()) check_output_file(options.output);
  TruthRequest request = truth_request(options, stack);
  // Two simulations are compared, and a grid has no closed order 1.
  request.limits.order_one = OrderOne::walked;
  const InputFiles inputs(stack);
  const Plan plan = make_plan(stack, request.limits);
  for (const std::string& warning : plan.warnings) terminal_monitor(options).warn(warning);
  check_estimator(request);  // the solver does not apply
  const Estimator estimator = request.estimator.value_or(Estimator::analog);
  const Stack profile = homogenised(stack, plan.grids);
  if (!options.output.empty())
    write_file(options.output,
               fmt::format("# {} with depth profiles in the place of its grids\n\n", stack.name) +
                   to_toml(profile));

  std::FILE* out = table_stream(options);
  const RunMonitor monitor = terminal_monitor(options);
  Json answer = json_header("homogenise", request);
  answer["estimator"] = to_text(estimator);
  answer["homogenised"] = lamella::to_json(profile);
  Json list = Json::array();
  FirstLook look(request, factors.size() * request.directions.size());
  for (const double factor : factors) {
    const Grids grids = scaled(stack, plan.grids, factor);
    const Plan grid_plan = make_plan(stack, request.limits, grids);
    const Stack layers = homogenised(stack, grids);
    Plan layer_plan = make_plan(layers, request.limits);
    // The same cells and channels as the grid's.
    layer_plan.isa = request.isa;
    layer_plan.folded = false;
    layer_plan.channels = grid_plan.channels;
    Json contrasts = Json::array();
    if (!options.quiet)
      fmt::print(out, "{}{}: {} homogeneous layers instead, {} estimator, seed {}{}\n", stack.name,
                 factor == 1 ? "" : fmt::format(" with {} of its contrast", to_text(factor)),
                 layers.layers.size(), to_text(estimator), request.seed,
                 grid_plan.channels == 1 ? "" : fmt::format("; energies: {}", kLuminanceName));
    for (std::size_t k = 0; k < grids.size(); ++k) {
      if (!grids[k]) continue;
      const LateralContrast c = lateral_contrast(*grids[k]);
      contrasts.push_back(
          {{"layer", k}, {"voxel", c.voxel}, {"column", c.column}, {"filled", c.filled}});
      if (!options.quiet)
        fmt::print(
            out,
            "  layer {}, {}: lateral contrast {:.3f} between voxels, {:.3f} between columns; "
            "{} of the voxels filled\n",
            k, stack.layers[k].grid->file, c.voxel, c.column, percent_text(c.filled));
    }
    std::vector<LobeDifference> lobes;
    for (const Direction wi : request.directions) {
      const std::string label = fmt::format("theta_i {:g}", theta_degrees(wi));
      Simulation grid(stack, grid_plan, wi, estimator, request.cells, request.seed);
      const StopRule rule = look.next();
      const RunResult done = run_walks(grid, rule, label, monitor);
      if (user_interrupt) break;
      if (look.has_clock() && done.walks < rule.walks)
        monitor.warn(first_look_text(label, done.walks, rule));
      // As many walks, of another seed: a difference of batches is one of independent numbers.
      Simulation homogeneous(layers, layer_plan, wi, estimator, request.cells, request.seed + 1);
      homogeneous.advance(done.walks);
      for (LobeDifference& l : differences(grid, homogeneous)) lobes.push_back(std::move(l));
    }
    decide(lobes);
    Json entries = Json::array();
    if (!options.quiet)
      fmt::print(out, "  {:>7} {:>9} {:>5} {:>10} {:>8} {:>10} {:>8} {:>9} {:>10} {:>9}  {}\n",
                 "theta_i", "side", "order", "grid", "+-", "layers", "+-", "energy", "rel. RMSE",
                 "p", "verdict");
    bool cut = false;
    for (const LobeDifference& l : lobes) {
      for (const double e : l.energy_missing) cut = cut || e > 0;
      for (const double e : l.energy_other_missing) cut = cut || e > 0;
      if (!options.quiet) print(out, l);
      entries.push_back(to_json(l));
    }
    if (!options.quiet)
      fmt::print(out,
                 "  agrees: no difference beyond the noise, which could hide none above {:g} % of "
                 "rel. RMSE{}\n",
                 100 * kAgreesWithin,
                 cut ? "; walks were cut, and verdicts hold wherever their light belongs "
                       "(--max-order)"
                     : "");
    list.push_back({{"contrast_factor", factor},
                    {"layers", layers.layers.size()},
                    {"contrast", std::move(contrasts)},
                    {"lobes", std::move(entries)}});
    if (user_interrupt) break;
  }
  if (!options.quiet && !options.output.empty()) fmt::print(out, "wrote {}\n", options.output);
  answer["interrupted"] = user_interrupt.load();
  answer["comparisons"] = std::move(list);
  inputs.check();
  add_files(answer, inputs);
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
