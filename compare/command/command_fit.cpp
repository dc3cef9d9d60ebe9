#include <fmt/format.h>

#include <algorithm>

#include "analytic/layered/spongecake.h"
#include "compare/command/command.h"
#include "compare/files/output_folder.h"
#include "compare/fit/least_squares.h"
#include "compare/fit/sampler_fit.h"
#include "compare/fit/spongecake_truth.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/request/model_request.h"
#include "compare/request/percent.h"
#include "compare/request/truth_request.h"
#include "compare/truth/ground_truth.h"
#include "phase/math/degrees.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kSamplingNodes = 9;

// The sampling lobes of a model with a roughness, as initializers.
int fit_sampling(const Options& options, const ClosedFormOptions& closed) {
  const ModelRequest request = parse_model_request(closed.sampling);
  const ModelInfo* info = find_model(request.name);
  if (info && !find(info->parameters, "roughness"))
    throw UsageError(
        fmt::format("--sampling: found \"{}\", which has no roughness; allowed: a model with one",
                    request.name));
  const auto model = [&](double roughness) {
    ModelRequest at = request;
    at.values.emplace_back("roughness", to_text(roughness));
    return bind_model(at, nullptr).model;
  };
  const SamplingLobeTable table = fit_sampling_lobes(model, kSamplingNodes, kSamplingNodes);
  std::FILE* out = table_stream(options);
  if (!options.quiet) {
    fmt::print(out, "second moment of the weight at the nodes: roughness, mu, cosine law, fit\n");
    for (int i = 0; i < table.roughnesses; ++i)
      for (int j = 0; j < table.cosines; ++j) {
        const auto square = [](int k) { return k * k / 64.0; };
        const std::size_t at = static_cast<std::size_t>(i) * table.cosines + j;
        fmt::print(out, "  {:>9.6f} {:>9.6f} {:>11.5g} {:>11.5g}\n", square(i), square(j),
                   table.cosine_moment[at], table.moment[at]);
      }
  }
  if (!options.output.empty()) write_file(options.output, to_initializers(table));
  return kDone;
}

void check_stack(const Stack& stack) {
  if (!is_spongecake_stack(stack))
    throw UsageError(fmt::format(
        "fit: found stack \"{}\"; allowed: layers of SGGX mirror flakes or henyey_greenstein",
        stack.name));
}

// Options that only fits of models have a use for.
void refuse_model_options(const Options& options, const ClosedFormOptions& closed,
                          const std::vector<std::string>& pictures) {
  const char* found = !options.incident.empty()                   ? "--wi"
                      : options.grid != Options{}.grid            ? "--grid"
                      : options.estimator != Options{}.estimator  ? "--estimator"
                      : options.tolerance != Options{}.tolerance  ? "--tolerance"
                      : closed.norm != ClosedFormOptions{}.norm   ? "--norm"
                      : closed.sides != ClosedFormOptions{}.sides ? "--sides"
                      : !pictures.empty()                         ? "--pictures"
                      : options.target_error                      ? "--target-error"
                      : options.seconds                           ? "--time"
                                                                  : nullptr;
  if (found)
    throw UsageError(fmt::format("fit {}: found no --model; allowed: with one, or all", found));
}

int fit_stack(const Options& options) {
  TruthRequest request = truth_request(options, stack_of(options));
  request.cells = kFitGrid;
  const Stack& stack = request.stack;
  check_stack(stack);
  if (!options.output.empty()) check_output_file(options.output);
  std::vector<RunResult> runs;
  SpongecakeFit fit;
  std::string by;
  const std::vector<WalkSetting>& asked = request.given;
  if (std::find(asked.begin(), asked.end(), WalkSetting::walks) == asked.end()) {
    catch_interrupts();
    SpongecakeTruth found = fit_spongecake_to_truth(
        stack, {request.seed, request.limits, request.isa, &user_interrupt});
    by = found.walks == 0
             ? std::string("by the solver")
             : fmt::format("{} analog walks per direction, {}", found.walks,
                           found.is_sharp ? "whose noise is small beside what the lobes leave over"
                           : user_interrupt ? "when it was interrupted"
                           : found.is_late  ? "the most in 20 s (--walks for more)"
                                            : "the most that are tried (--walks for more)");
    runs = std::move(found.runs);
    fit = std::move(found.fit);
  } else {
    GroundTruth truth(request, Estimator::analog, terminal_monitor(options));
    for (std::size_t k = 0; truth.goes_on(k); ++k) runs.push_back(truth.find(k).run);
    fit = fit_spongecake(stack, runs);
    by = estimator_text(truth.choice(), request);
  }
  std::FILE* out = table_stream(options);
  if (!options.quiet) {
    fmt::print(out,
               "{}: orders 2 and up, {}{}; what two lobes leave over\n"
               "  {:>7} {:>9} {:>13} {:>13} {:>10} {:>9}\n",
               stack.name, by,
               runs.front().channels == 1 ? "" : fmt::format(", energies: {}", kLuminanceName),
               "theta_i", "side", "energy truth", "energy lobes", "rel. RMSE", "noise");
    for (const SpongecakeResidue& r : fit.residues)
      fmt::print(out, "  {:>7g} {:>9} {:>13.5f} {:>13.5f} {:>10} {:>9}\n", theta_degrees(r.wi),
                 r.reflected ? "reflect" : "transmit", r.energy_truth, r.energy_model,
                 percent_cell(r.relative_rmse), percent_cell(r.noise));
    fmt::print(out, "  all: {} of the root mean square, {} of it noise\n",
               percent_cell(fit.relative_rmse), percent_cell(fit.noise));
    double missing = 0;
    for (const SpongecakeResidue& r : fit.residues) missing = std::max(missing, r.energy_missing);
    if (missing > 0)
      fmt::print(out,
                 "  walks were cut after {} events: the truth's energies are too low by {:.1e} at "
                 "most, which counts\n  as noise (--max-order)\n",
                 runs.front().max_order, missing);
    fmt::print(out, "\n--model {}\n", fit.request);
  }
  Json answer = json_header("fit", request);
  answer["walks"] = runs.front().walks;
  answer["model"] = fit.request;
  answer["relative_rmse"] = fit.relative_rmse;
  answer["noise"] = fit.noise;
  answer["residues"] = Json::array();
  for (const SpongecakeResidue& r : fit.residues)
    answer["residues"].push_back({{"mu_i", r.wi.z},
                                  {"phi_i", phi_degrees(r.wi)},
                                  {"side", r.reflected ? "reflect" : "transmit"},
                                  {"energy_truth", r.energy_truth},
                                  {"energy_model", r.energy_model},
                                  {"energy_missing", r.energy_missing},
                                  {"relative_rmse", r.relative_rmse},
                                  {"noise", r.noise}});
  if (!options.output.empty()) write_file(options.output, fit.request + "\n");
  write_json(answer, options.json);
  return kDone;
}

}  // namespace

int fit_command(const Options& options, const ClosedFormOptions& closed,
                const std::vector<std::string>& pictures) {
  require_least_squares();
  if (!closed.vary.empty() && closed.stack.empty())
    throw UsageError("--vary: found no --stack; allowed: beside it");
  if (!closed.stack.empty()) {
    if (!options.models.empty() || !closed.sampling.empty())
      throw UsageError(fmt::format("--stack: found beside {}; allowed: one of the two",
                                   options.models.empty() ? "--sampling" : "--model"));
    return fit_stack_command(options, closed, pictures);
  }
  if (!options.models.empty()) {
    if (!closed.sampling.empty())
      throw UsageError("--sampling: found beside --model; allowed: one of the two");
    return fit_models_command(options, closed, pictures);
  }
  refuse_model_options(options, closed, pictures);
  return closed.sampling.empty() ? fit_stack(options) : fit_sampling(options, closed);
}

}  // namespace lamella
