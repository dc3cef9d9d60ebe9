#include <fmt/format.h>

#include <algorithm>

#include "analytic/catalogue/model_plugin.h"
#include "compare/command/command.h"
#include "compare/command/divided_run.h"
#include "compare/files/output_folder.h"
#include "compare/fit/fitted_models.h"
#include "compare/judge/model_furnace.h"
#include "compare/judge/statistics.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"
#include "compare/request/errors.h"
#include "compare/request/model_request.h"
#include "compare/request/stack_parameters.h"
#include "compare/request/substrate_model.h"
#include "compare/request/truth_request.h"
#include "compare/truth/ground_truth.h"
#include "phase/math/degrees.h"
#include "phase/stack/builtin_stacks.h"

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

// "fail: loss", or the verdict alone.
std::string told(const std::string& verdict, const std::string& loss_or_gain) {
  if (verdict != "fail") return verdict;
  return "fail: " + (loss_or_gain == "both" ? "loss and gain" : loss_or_gain);
}

// What a pass means; `level`: the chance of each direction and channel that a true furnace fails.
std::string criterion_of(bool bounded, bool as_is, double level) {
  return fmt::format(
      "pass: the energy is 1{} within {}, and none of {} is above {:g}{}; fail: it is off by more, "
      "a loss or a gain; inconclusive: neither can be said",
      as_is ? " less what is absorbed" : "",
      bounded ? "its bound" : fmt::format("{:.1f} standard errors", furnace_quantile(level)),
      bounded ? "the bounds" : "them", kWidestFurnaceError,
      bounded ? "" : ", nor more unresolved than that noise");
}

std::string worse(const std::string& a, const std::string& b) {
  for (const char* v : {"fail", "inconclusive"})
    if (a == v || b == v) return v;
  return "pass";
}

// The furnace of models. `given`: the stack as it was given, if `of_stack_given`; that of
// `truth` is as the furnace has it. `out`: where the table goes, if anywhere.
CommandAnswer model_furnace(const Options& options, const Stack& given, bool of_stack_given,
                            const TruthRequest& truth, std::FILE* out) {
  const InputFiles inputs(of_stack_given ? given : Stack{}, objects_among(model_requests(options)));
  const Stack& stack = truth.stack;
  // Without a stack that was asked for there is none to name.
  std::optional<Stack> named;
  if (of_stack_given) named = stack;
  Json list = Json::array();
  std::string overall = "pass";
  const double tolerance = options.max_error.value_or(kModelTolerance);
  for (ModelRequest request : model_requests(options)) {
    const ModelInfo* info = find_or_load_model(request.name);
    bool of_stack = of_stack_given;
    Stack own = stack;
    if (info && info->needs_stack && !of_stack) {
      const auto key = std::find_if(request.values.begin(), request.values.end(),
                                    [](const auto& v) { return v.first == "stack"; });
      of_stack = key != request.values.end();
      if (of_stack) {
        own = with_surface_model(load_stack(key->second));
        if (!options.as_is) own = with_surface_model(whitened(own));
        named = own;
        std::erase_if(request.values, [](const auto& v) { return v.first == "stack"; });
      }
    }
    if (info && info->needs_stack && !of_stack)
      throw UsageError(fmt::format(
          "furnace --model {}: found no stack; allowed: one, as in lamella furnace {} --model {}",
          request.name, kDefaultStack, request.name));
    request = without_stack_key(std::move(request), given);
    if (!options.as_is && info)
      for (const char* key : {"albedo", "rho", "f0", "base.albedo", "base_color"})
        if (find(info->parameters, key)) {
          std::erase_if(request.values, [&](const auto& v) { return v.first == key; });
          request.values.emplace_back(key, "1");
          request.sources[key] = "white";
        }
    // Without a stack that was asked for a model takes nothing from one.
    const BoundModel bound =
        of_stack ? model_for(with_fitted_lobes(request, own), own) : bind_model(request, nullptr);
    if (out) fmt::print(out, "{}\n{}", bound.info->name, told_parameters(bound, 4));
    Json runs = Json::array();
    for (const Direction wi : truth.directions) {
      const ModelFurnace furnace = judge_model_furnace(*bound.model, wi, options.as_is, tolerance);
      const Rgb energy = furnace.energy, error = furnace.error;
      const std::string verdict = to_text(furnace.verdict);
      const std::string direction = loss_or_gain(furnace.loses, furnace.gains);
      overall = worse(overall, verdict);
      runs.push_back({{"mu_i", wi.z},
                      {"phi_i", phi_degrees(wi)},
                      {"energy", {energy.r, energy.g, energy.b}},
                      {"energy_error", {error.r, error.g, error.b}},
                      {"ended_by", to_text(furnace.end)},
                      {"verdict", verdict},
                      {"loss_or_gain", direction}});
      if (out)
        fmt::print(out, "{} theta_i {:g}: energy {:.6f} {:.6f} {:.6f} +- {:.1e}{}, {}\n",
                   bound.info->name, theta_degrees(wi), energy.r, energy.g, energy.b, error.max(),
                   furnace.end == IntegralEnd::tolerance
                       ? ""
                       : fmt::format(" ({})", reason_of(furnace.end)),
                   told(verdict, direction));
    }
    Json parameters = Json::object();
    for (const auto& [key, value] : bound.parameters.all()) parameters[key] = to_json(value);
    list.push_back({{"name", bound.info->name},
                    {"parameters", std::move(parameters)},
                    {"parameter_sources", bound.sources},
                    {"runs", std::move(runs)}});
  }
  TruthRequest header = truth;
  if (named) header.stack = *named;
  Json answer =
      named ? json_header("furnace", header) : json_header("furnace", truth.seed, truth.isa);
  answer["verdict"] = overall;
  answer["tolerance"] = tolerance;
  answer["models"] = std::move(list);
  inputs.check();
  add_files(answer, inputs);
  answer["runs"] = answer["models"][0]["runs"];
  answer["criterion"] = fmt::format(
      "pass: {} (--max-error); fail: it is off by more, a loss or a gain; inconclusive: the error "
      "of the energy decides",
      options.as_is ? fmt::format("the energy is at most 1 + {:g}", tolerance)
                    : fmt::format("the energy is 1 within {:g}", tolerance));
  if (out) fmt::print(out, "{}\n{}\n", overall, answer["criterion"].get<std::string>());
  return {std::move(answer), status_of(overall, options)};
}

// Whether the page of models is about the stack, too.
bool needs_stack(const Options& options) {
  const std::vector<ModelRequest> requests = model_requests(options);
  return std::any_of(requests.begin(), requests.end(), [](const ModelRequest& request) {
    const ModelInfo* info = find_or_load_model(request.name);
    return info && info->needs_stack;
  });
}

CommandAnswer stack_furnace(const Options& options, TruthRequest request, const RunMonitor& monitor,
                            std::FILE* out) {
  const InputFiles inputs(request.stack);
  request.cells = kFurnaceGrid;
  // What walks bring back is what is judged, so their books must be their own.
  request.limits.order_one = OrderOne::walked;
  const Stack& stack = request.stack;
  GroundTruth truth(request, Estimator::next_event, monitor);
  const Plan& plan = truth.plan();
  const std::vector<Direction>& directions = truth.directions();
  const double level = sidak_level(kFalseAlarm, directions.size() * plan.channels);
  if (out)
    fmt::print(out,
               "{}: furnace{}, {}\n  {:>7} {:>10} {:>9} {:>10} {:>10} {:>10} {:>10} "
               "{:>10}  {}\n",
               stack.name, options.as_is ? " as it is" : ", all albedos at 1",
               estimator_text(truth.choice(), request), "theta_i", "energy", "+-", "reflected",
               "transm.", "uncollided", "absorbed", "unresolved", "verdict");
  Json answer = json_header("furnace", request);
  Json runs = Json::array();
  std::string overall = "pass";
  bool wide = false, cut = false, few = false;
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
    entry["loss_or_gain"] = loss_or_gain(furnace.loses, furnace.gains);
    wide = wide || furnace.is_wide;
    cut = cut || furnace.is_cut;
    few = few || furnace.has_few_events;
    const RunResult& run = furnace.run;
    if (out)
      for (int c = 0; c < plan.channels; ++c)
        fmt::print(out,
                   "  {:>7g} {:>10.8f} {:>9.1e} {:>10.6f} {:>10.6f} {:>10.6f} {:>10.6f} "
                   "{:>10.6f}  {}\n",
                   theta_degrees(wi), furnace.energy[c].value, furnace.energy[c].standard_error,
                   run.reflected.total[c].value, run.transmitted.total[c].value,
                   run.uncollided[c].value, run.absorbed[c].value, run.unresolved[c].value,
                   c == 0 ? told(verdict, entry["loss_or_gain"]) : "");
    if (out && run.lost[0].value > 0)
      fmt::print(out, "          facets lose {:.6f} of it (scattering = \"single\")\n",
                 run.lost[0].value);
    // A one-sided slab has a second furnace: radiance under uniform light from both sides.
    const bool specular = std::any_of(stack.layers.begin(), stack.layers.end(),
                                      [](const Layer& l) { return is_delta(l.medium); });
    if (request.texels.empty() && !options.as_is && plan.transmits && !plan.boundaries &&
        plan.folded && stack.one_sidedness() != 0 && !specular && !truth.is_stopped()) {
      const RadianceCheck check =
          run.is_bounded() ? check_radiance(*truth.choice().solution, wi)
                           : check_radiance(stack, plan, wi, run.walks, request.seed, monitor);
      entry["radiance"] = {{"measured", check.measured},
                           {"standard_error", check.standard_error},
                           {"predicted", check.predicted},
                           {"predicted_standard_error", check.predicted_error}};
      if (out)
        fmt::print(out,
                   "          radiance under uniform light from both sides: {:.8f} +- {:.1e}, "
                   "predicted {:.8f} +- {:.1e}\n",
                   check.measured, check.standard_error, check.predicted, check.predicted_error);
    }
    runs.push_back(std::move(entry));
  }
  add_choice(answer, truth.choice(), request);
  answer["verdict"] = overall;
  const bool bounded = truth.estimator() == Estimator::deterministic;
  answer["criterion"] = criterion_of(bounded, options.as_is, level);
  answer["interrupted"] = truth.is_stopped();
  answer["runs"] = std::move(runs);
  inputs.check();
  add_files(answer, inputs);
  if (out) {
    if (truth.estimator() != Estimator::deterministic && plan.thinning.is_on())
      fmt::print(
          out,
          "long walks are thinned: energies have the noise of that, which is no gain or loss "
          "(--thin-from 0: none are)\n");
    fmt::print(out, "{}\n{}\n", overall, answer["criterion"].get<std::string>());
    if (overall == "inconclusive" && wide)
      fmt::print(out, "{} ({})\n",
                 bounded ? "the solver's bound is too wide to judge by"
                         : "the noise is too large to judge by",
                 bounded ? "--tolerance, --time" : "--walks");
    if (overall == "inconclusive" && cut)
      fmt::print(out, "walks cut after {} events hold more light than the noise (--max-order)\n",
                 truth.plan().max_order);
    if (overall == "inconclusive" && few)
      fmt::print(out, "too few walks hit what scatters sharply (--walks, --estimator analog)\n");
  }
  return {std::move(answer), status_of(overall, options)};
}

// The stack as a furnace has it.
TruthRequest furnace_request(const Options& options, const Stack& given) {
  return truth_request(options, options.as_is ? given : with_surface_model(whitened(given)));
}

}  // namespace

CommandAnswer furnace_answer(const Options& options, const Stack& stack,
                             const RunMonitor& monitor) {
  const TruthRequest request = furnace_request(options, stack);
  return options.models.empty() ? stack_furnace(options, request, monitor, nullptr)
                                : model_furnace(options, stack, true, request, nullptr);
}

namespace {

// With its texels, if it is about the mean over a map.
TruthRequest furnace_request(const DividedRun& run) {
  TruthRequest request = furnace_request(run.options, run.stack);
  for (const Stack& texel : run.texels)
    request.texels.push_back(run.options.as_is ? texel : with_surface_model(whitened(texel)));
  return request;
}

// Of a stack's walks: models have none, and the solver's are seconds of work.
void check_furnace(const DividedRun& run) {
  if (!run.options.models.empty())
    throw UsageError(
        "--shard: found --model, a furnace without walks; allowed: the furnace of a stack");
  const TruthRequest request = truth_request(run.options, run.stack);
  if (request.estimator == Estimator::deterministic)
    throw UsageError(
        "--shard: found a furnace of --estimator deterministic, which is no work to divide; "
        "allowed: --walks N");
  check_walks_are_given(request);
}

int furnace_run(const DividedRun& run, const RunMonitor& monitor) {
  const Options& options = run.options;
  if (!options.html.empty()) check_output_file(options.html);
  const TruthRequest request = furnace_request(run);
  if (!run.texels.empty() && !options.models.empty())
    throw UsageError(
        "--at: found mean for a furnace of --model; allowed: --at U,V, or the stack's furnace");
  std::FILE* out = options.quiet ? nullptr : table_stream(options);
  const bool of_models = !options.models.empty();
  const CommandAnswer found =
      of_models ? model_furnace(options, run.stack, !options.stack.empty(), request, out)
                : stack_furnace(options, request, monitor, out);
  if (!options.html.empty()) {
    if (of_models)
      write_report_page(options.html, "White furnace of closed forms", found.json,
                        {{"needs_stack", needs_stack(options)}});
    else
      write_report_page(options.html, request.stack.name + ": white furnace", found.json, nullptr);
  }
  write_json(found.json, options.json);
  return found.status;
}

}  // namespace

const DividedCommand& furnace_divided() {
  static const DividedCommand command{"furnace", "", check_furnace,
                                      [](const DividedRun& run, const RunMonitor& monitor) {
                                        (void)stack_furnace(run.options, furnace_request(run),
                                                            monitor, nullptr);
                                      },
                                      furnace_run};
  return command;
}

int furnace_command(const Options& options) {
  StackOrMean found = stack_or_mean_of(options);
  return do_divided(furnace_divided(), {.command = "furnace",
                                        .options = options,
                                        .stack = std::move(found.stack),
                                        .texels = std::move(found.texels)});
}

}  // namespace lamella
