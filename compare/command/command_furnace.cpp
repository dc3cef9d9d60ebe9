#include <fmt/format.h>

#include <algorithm>

#include "analytic/catalogue/model_plugin.h"
#include "compare/command/command.h"
#include "compare/files/output_folder.h"
#include "compare/judge/furnace.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"
#include "compare/request/interrupt.h"
#include "compare/request/model_request.h"
#include "compare/request/substrate_model.h"
#include "compare/request/truth_request.h"
#include "compare/truth/ground_truth.h"
#include "phase/math/degrees.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Chance that a true furnace fails, over all directions and channels of one command.
constexpr double kFalseAlarm = 1e-3;
// What a closed form may miss of the energy unless --max-error says otherwise.
constexpr double kModelTolerance = 1e-3;
// A furnace needs totals only: few targets keep next-event estimation cheap.
constexpr CellGrid kFurnaceGrid{4, 8, false};

int status_of(const std::string& verdict, const Options& options) {
  if (verdict == "fail") return kFailed;
  return verdict == "inconclusive" && options.strict ? kFailed : kDone;
}

std::string worse(const std::string& a, const std::string& b) {
  for (const char* v : {"fail", "inconclusive"})
    if (a == v || b == v) return v;
  return "pass";
}

int model_furnace(const Options& options, const TruthRequest& truth) {
  const Stack& stack = truth.stack;
  Json answer = json_header("furnace", truth);
  Json list = Json::array();
  std::string overall = "pass";
  bool needs_stack = false;
  const double tolerance = options.max_error.value_or(kModelTolerance);
  std::FILE* out = table_stream(options);
  for (ModelRequest& request : model_requests(options)) {
    if (!options.as_is)
      if (const ModelInfo* info = find_or_load_model(request.name))
        for (const char* key : {"albedo", "rho", "f0"})
          if (find(info->parameters, key)) {
            std::erase_if(request.values, [&](const auto& v) { return v.first == key; });
            request.values.emplace_back(key, "1");
          }
    const BoundModel bound = model_for(request, stack);
    Json runs = Json::array();
    for (const Direction wi : truth.directions) {
      const Direction w = with_grazing_limit(wi);
      const AlbedoEstimate scattered = bound.model->albedo_with_error(w);
      const double passed = bound.model->uncollided(w);
      std::string verdict = "pass";
      Json energy = Json::array(), errors = Json::array();
      double least = 0, most = 0, largest_error = 0;  // what the energy misses, within its error
      for (int c = 0; c < 3; ++c) {
        const double e = scattered.value[c] + passed, error = scattered.error[c];
        if (!std::isfinite(e))
          throw std::domain_error("the model gives a value that is not finite");
        energy.push_back(e);
        errors.push_back(error);
        const double missing = options.as_is ? std::max(0.0, e - 1) : std::abs(e - 1);
        least = std::max(least, missing - error);
        most = std::max(most, missing + error);
        largest_error = std::max(largest_error, error);
      }
      if (least > tolerance)
        verdict = "fail";
      else if (most > tolerance)
        verdict = "inconclusive";
      overall = worse(overall, verdict);
      runs.push_back({{"mu_i", wi.z},
                      {"phi_i", phi_degrees(wi)},
                      {"energy", energy},
                      {"energy_error", errors},
                      {"ended_by", to_text(scattered.end)},
                      {"verdict", verdict}});
      if (!options.quiet)
        fmt::print(out, "{} theta_i {:g}: energy {:.6f} {:.6f} {:.6f} +- {:.1e}{}, {}\n",
                   bound.info->name, theta_degrees(wi), energy[0].get<double>(),
                   energy[1].get<double>(), energy[2].get<double>(), largest_error,
                   scattered.end == IntegralEnd::tolerance
                       ? ""
                       : fmt::format(" ({})", reason_of(scattered.end)),
                   verdict);
    }
    needs_stack = needs_stack || bound.info->needs_stack;
    list.push_back({{"name", bound.info->name}, {"runs", std::move(runs)}});
  }
  answer["verdict"] = overall;
  answer["tolerance"] = tolerance;
  answer["models"] = std::move(list);
  answer["runs"] = answer["models"][0]["runs"];
  if (!options.quiet) fmt::print(out, "{}\n", overall);
  if (!options.html.empty())
    write_report_page(options.html, "White furnace of closed forms", answer,
                      {{"needs_stack", needs_stack}});
  write_json(answer, options.json);
  return status_of(overall, options);
}

}  // namespace

int furnace_command(const Options& options) {
  if (!options.html.empty()) check_output_file(options.html);
  Stack given = stack_of(options);
  if (!options.as_is) given = with_surface_model(whitened(std::move(given)));
  TruthRequest request = truth_request(options, given);
  if (!options.models.empty()) return model_furnace(options, request);
  request.cells = kFurnaceGrid;
  const Stack& stack = request.stack;
  GroundTruth truth(request, Estimator::next_event, terminal_monitor(options));
  const Plan& plan = truth.plan();
  const std::vector<Direction>& directions = truth.directions();
  const double level = -std::expm1(std::log1p(-kFalseAlarm) /
                                   static_cast<double>(directions.size() * plan.channels));
  std::FILE* out = table_stream(options);
  if (!options.quiet)
    fmt::print(out,
               "{}: furnace{}, {}\n  {:>7} {:>10} {:>9} {:>10} {:>10} {:>10} {:>10} "
               "{:>10}  {}\n",
               stack.name, options.as_is ? " as it is" : ", all albedos at 1",
               estimator_text(truth.choice(), request), "theta_i", "energy", "+-", "reflected",
               "transm.", "uncollided", "absorbed", "unresolved", "verdict");
  Json answer = json_header("furnace", request);
  Json runs = Json::array();
  std::string overall = "pass";
  for (std::size_t k = 0; truth.goes_on(k); ++k) {
    const Direction wi = directions[k];
    const Truth found = truth.find(k);
    const FurnaceRun furnace = judge_furnace(found.run, found.batches.get(), !options.as_is, level);
    const std::string verdict = to_text(furnace.verdict);
    overall = worse(overall, verdict);
    Json entry = to_json(furnace.run);
    entry["energy"] = values_of(furnace.energy, plan.channels);
    entry["energy_standard_error"] = errors_of(furnace.energy, plan.channels);
    entry["verdict"] = verdict;
    const RunResult& run = furnace.run;
    if (!options.quiet)
      for (int c = 0; c < plan.channels; ++c)
        fmt::print(out,
                   "  {:>7g} {:>10.8f} {:>9.1e} {:>10.6f} {:>10.6f} {:>10.6f} {:>10.6f} "
                   "{:>10.6f}  {}\n",
                   theta_degrees(wi), furnace.energy[c].value, furnace.energy[c].standard_error,
                   run.reflected.total[c].value, run.transmitted.total[c].value,
                   run.uncollided[c].value, run.absorbed[c].value, run.unresolved[c].value,
                   c == 0 ? verdict : "");
    // A one-sided slab has a second furnace: radiance under uniform light from both sides.
    const bool specular = std::any_of(stack.layers.begin(), stack.layers.end(),
                                      [](const Layer& l) { return is_delta(l.medium); });
    if (!options.as_is && plan.transmits && plan.folded && stack.one_sidedness() != 0 &&
        !specular && !user_interrupt) {
      const RadianceCheck check = run.is_bounded() ? check_radiance(*truth.choice().solution, wi)
                                                   : check_radiance(stack, plan, wi, run.walks,
                                                                    options.seed, &user_interrupt);
      entry["radiance"] = {{"measured", check.measured},
                           {"standard_error", check.standard_error},
                           {"predicted", check.predicted},
                           {"predicted_standard_error", check.predicted_error}};
      if (!options.quiet)
        fmt::print(out,
                   "          radiance under uniform light from both sides: {:.8f} +- {:.1e}, "
                   "predicted {:.8f} +- {:.1e}\n",
                   check.measured, check.standard_error, check.predicted, check.predicted_error);
    }
    runs.push_back(std::move(entry));
  }
  add_choice(answer, truth.choice(), request);
  answer["verdict"] = overall;
  answer["interrupted"] = user_interrupt.load();
  answer["runs"] = std::move(runs);
  if (!options.quiet) {
    if (truth.estimator() != Estimator::deterministic && plan.thinning.is_on())
      fmt::print(
          out,
          "long walks are thinned: energies have the noise of that, which is no gain or loss "
          "(--thin-from 0: none are)\n");
    fmt::print(out, "{}\n", overall);
    if (overall == "inconclusive" && truth.estimator() == Estimator::deterministic)
      fmt::print(out, "the solver's bound is too wide to judge by (--tolerance, --time)\n");
    else if (overall == "inconclusive")
      fmt::print(
          out,
          "walks cut after {} events hold more light than the noise (--max-order), or too few "
          "walks hit what scatters sharply (--walks, --estimator analog)\n",
          truth.plan().max_order);
  }
  if (!options.html.empty())
    write_report_page(options.html, stack.name + ": white furnace", answer, nullptr);
  write_json(answer, options.json);
  return status_of(overall, options);
}

}  // namespace lamella
