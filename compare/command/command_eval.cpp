#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>

#include "analytic/catalogue/model_plugin.h"
#include "analytic/model/grazing_pair.h"
#include "analytic/model/stochastic_model.h"
#include "compare/command/command.h"
#include "compare/command/divided_run.h"
#include "compare/files/output_folder.h"
#include "compare/fit/fitted_models.h"
#include "compare/judge/pair_truth.h"
#include "compare/options/progress.h"
#include "compare/request/direction_pairs.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/request/model_request.h"
#include "compare/request/numbers.h"
#include "compare/request/substrate_model.h"
#include "compare/request/truth_request.h"
#include "phase/medium/media.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {
namespace {

const std::string kStdin = "<stdin>";

// The rows of the answer: f per pair, and its standard error where the model is stochastic.
struct CsvAnswer {
  std::vector<Rgb> f;
  std::vector<Rgb> standard_error;
  bool color = false;
};

std::optional<std::string> take(KeyValues& values, const std::string& key) {
  for (auto it = values.begin(); it != values.end(); ++it)
    if (it->first == key) {
      std::string text = it->second;
      values.erase(it);
      return text;
    }
  return std::nullopt;
}

bool has_three_values(const KeyValues& values) {
  return std::any_of(values.begin(), values.end(), [](const auto& v) {
    return v.first != "axis" && std::count(v.second.begin(), v.second.end(), ',') == 2;
  });
}

// The stack that stack=... names, if it is there. Not both it and the pairs can be stdin.
std::optional<Stack> take_stack(const Options& options, KeyValues& values, const std::string& what,
                                const DirectionPairs& pairs) {
  const auto name = take(values, "stack");
  if (!name) return std::nullopt;
  if (name->empty())
    throw UsageError(fmt::format(
        "{}: key \"stack\": found \"\"; allowed: a stack file, - or a built-in stack", what));
  if (*name == "-" && pairs.file == kStdin)
    throw UsageError(fmt::format(
        "{}: key \"stack\": found - beside --pairs -; allowed: only one of them from stdin", what));
  return stack_of(options, *name);
}

[[noreturn]] void refuse_both_grazing(const DirectionPairs& pairs, std::size_t k) {
  refuse_pair(pairs, k, "both cosines are 0, where there is no limit; allowed: at most one");
}

// Pairs that a stack has no answer to.
void check_pairs(const DirectionPairs& pairs, const Stack& stack, bool wi_only = false) {
  for (std::size_t k = 0; k < pairs.pairs.size(); ++k) {
    if (pairs.pairs[k].wi.z < 0 && !stack.is_open_below())
      refuse_pair(pairs, k,
                  fmt::format("light from below, which {}; allowed: theta_i in [0, 90], mu_i >= 0",
                              stack.substrate ? "meets an opaque substrate"
                                              : "cannot come through a half space"));
    if (!wi_only && grazes_twice(pairs.pairs[k].wi, pairs.pairs[k].wo))
      refuse_both_grazing(pairs, k);
  }
}

// media.NAME.sigma and media.NAME.phase, with the keys of a layer.
CsvAnswer eval_medium(const std::string& what, const KeyValues& given,
                      const std::vector<DirectionPair>& pairs) {
  const std::size_t dot = what.rfind('.');
  const std::string name = what.substr(6, dot - 6), part = what.substr(dot + 1);
  const MediumInfo* info = dot > 6 ? find_medium(name) : nullptr;
  std::vector<std::string> names;
  for (const MediumInfo& m : media())
    for (const char* p : {".sigma", ".phase"}) names.push_back("media." + m.name + p);
  if (!info || (part != "sigma" && part != "phase")) {
    const std::string hint = suggestion(what, names);
    throw UsageError(fmt::format("\"{}\": unknown{}; allowed: {}", what,
                                 hint.empty() ? "" : ", " + hint, listed(names)));
  }
  // A layer's other keys are taken, too, and change neither sigma nor p.
  std::vector<ParameterInfo> infos = info->parameters;
  infos.push_back(
      {.name = "albedo", .kind = ParameterKind::color, .unit = "1", .doc = "", .min = 0, .max = 1});
  infos.push_back({.name = "thickness", .unit = "mm", .doc = "", .min = 0});
  infos.push_back({.name = "density", .unit = "1/mm", .doc = "", .min = 0, .max_open = true});
  Parameters parameters = read_parameters(what, infos, given);
  CsvAnswer answer;
  answer.color = has_three_values(given);
  try {
    const Medium medium = info->make(parameters);
    for (const DirectionPair& pair : pairs)
      answer.f.emplace_back(part == "sigma" ? sigma(medium, pair.wi)
                                            : phase(medium, pair.wi, pair.wo).density);
  } catch (const ParameterError& error) {
    throw UsageError(fmt::format("{}: {}", what, error.what()));
  }
  return answer;
}

// What `truth` with these keys asks for. Of a run in parts the stack's key is gone.
TruthRequest truth_request_of(KeyValues values, const Stack& stack, const Options& options) {
  const auto walks = take(values, "walks");
  const auto estimator = take(values, "estimator");
  const auto seed = take(values, "seed");
  const auto tolerance = take(values, "tolerance");
  const auto seconds = take(values, "time");
  if (estimator && *estimator == "analog")
    throw UsageError(
        "truth: key \"estimator\": found \"analog\", which counts light in cells and never meets a "
        "point; allowed: auto, next-event, deterministic");
  if (estimator && *estimator != "auto" && *estimator != "next-event" &&
      *estimator != "deterministic")
    throw UsageError(
        fmt::format("truth: key \"estimator\": found \"{}\"; allowed: auto, next-event, "
                    "deterministic",
                    *estimator));
  if (!values.empty())
    throw UsageError(fmt::format(
        "truth: key \"{}\": unknown; allowed: stack, walks, estimator, seed, tolerance, "
        "time (seconds of estimator=deterministic)",
        values[0].first));
  TruthRequest request = truth_request(options, stack);
  request.estimator = parse_estimator(estimator.value_or("auto"));
  if (walks) {
    request.effort.walks = parse_walks(*walks);
    request.given.insert(request.given.begin(), WalkSetting::walks);
  }
  if (tolerance) {
    const auto number = parse_number(*tolerance);
    if (!number || !(*number > 0) || std::isinf(*number))
      throw UsageError(fmt::format(
          "truth: key \"tolerance\": found \"{}\"; allowed: a number in (0, inf)", *tolerance));
    request.tolerance = *number;
  }
  if (seconds) {
    const auto number = parse_number(*seconds);
    if (request.estimator != Estimator::deterministic || !number || !(*number > 0))
      throw UsageError(
          fmt::format("truth: key \"time\": found \"{}\" with estimator={}; allowed: a number of "
                      "seconds above 0 with estimator=deterministic",
                      *seconds, estimator_asked(request)));
    request.effort.seconds = *number;
  }
  if (seed) {
    const auto number = parse_whole_number(*seed);
    if (!number)
      throw UsageError(
          fmt::format("truth: key \"seed\": found \"{}\"; allowed: a whole number", *seed));
    request.seed = *number;
  }
  return request;
}

CsvAnswer eval_truth(const TruthRequest& request, const DirectionPairs& pairs,
                     const RunMonitor& monitor) {
  const Stack& stack = request.stack;
  check_pairs(pairs, stack);
  CsvAnswer answer;
  answer.color = !stack.is_grey() || (stack.has_grid() && make_plan(stack).channels == 3);
  const PairTruth truth = truth_of_pairs(request, pairs.pairs, monitor);
  answer.f = truth.f;
  answer.standard_error = truth.error;
  if (user_interrupt)
    fmt::print(stderr, "lamella: interrupted: {} than asked for, see se\n",
               truth.is_solved() ? "a coarser solution" : "fewer walks");
  return answer;
}

// What quadratures of albedos reached, of all pairs.
class AlbedoAccuracy {
 public:
  void add(const AlbedoEstimate& albedo) {
    if (albedo.end == IntegralEnd::tolerance) return;
    for (int c = 0; c < 3; ++c)
      if (albedo.error[c] > worst_ * std::abs(albedo.value[c])) {
        worst_ = albedo.error[c] / std::abs(albedo.value[c]);
        end_ = albedo.end;
      }
  }
  /// One line where the error that is asked of every model was not reached.
  void warn(const std::string& what) const {
    if (end_ == IntegralEnd::tolerance) return;
    fmt::print(stderr, "lamella: warning: {}: error {:.1e} of the value at worst, ended by {}\n",
               what, worst_, reason_of(end_));
  }

 private:
  double worst_ = 0;
  IntegralEnd end_ = IntegralEnd::tolerance;
};

// MODEL, MODEL.pdf, MODEL.albedo or MODEL.LOBE.
CsvAnswer eval_model(const Options& options, const std::string& what, KeyValues values,
                     const DirectionPairs& pairs) {
  std::optional<Stack> stack;
  CsvAnswer answer;
  answer.color = has_three_values(values);
  // The parts of a model in ./mine.so are named ./mine.so.PART.
  const std::size_t object = what.rfind(".so");
  const std::size_t dot = object == std::string::npos ? what.find('.') : what.find('.', object + 1);
  const std::string name = what.substr(0, dot);
  const std::string part = dot == std::string::npos ? "" : what.substr(dot + 1);
  const ModelInfo* info = find_or_load_model(name);
  if (!info) {
    std::vector<std::string> names;
    for (const ModelInfo& m : models()) names.push_back(m.name);
    names.insert(names.end(), {"truth", "media.NAME.sigma", "media.NAME.phase"});
    const std::string hint = suggestion(name, names);
    throw UsageError(fmt::format("model \"{}\": unknown{}; allowed: {}", name,
                                 hint.empty() ? "" : ", " + hint, listed(names)));
  }
  if (info->needs_stack) {
    stack = take_stack(options, values, name, pairs);
    if (stack) answer.color = answer.color || !stack->is_grey();
  }
  if (!stack) refuse_place(options, what);
  ModelRequest request{name, values};
  if (stack) request = with_fitted_lobes(std::move(request), *stack);
  const BoundModel bound = bind_model(request, stack ? &*stack : nullptr);
  int lobe = -1;
  std::vector<std::string> parts{"pdf", "albedo"};
  for (std::size_t k = 0; k < bound.info->lobes.size(); ++k) {
    parts.push_back(bound.info->lobes[k].name);
    if (bound.info->lobes[k].name == part) lobe = static_cast<int>(k);
  }
  const PartInfo* extra = nullptr;
  for (const PartInfo& p : bound.info->parts) {
    parts.push_back(p.name);
    if (p.name == part) extra = &p;
  }
  if (!part.empty() && part != "pdf" && part != "albedo" && lobe < 0 && !extra) {
    const std::string hint = suggestion(part, parts);
    throw UsageError(fmt::format("{}: part \"{}\": unknown{}; allowed: {}", name, part,
                                 hint.empty() ? "" : ", " + hint, listed(parts)));
  }
  if (stack) check_pairs(pairs, *stack, part == "albedo");
  const auto* stochastic = dynamic_cast<const StochasticModel*>(bound.model.get());
  AlbedoAccuracy accuracy;
  for (std::size_t k = 0; k < pairs.pairs.size(); ++k) {
    const Direction wi = with_grazing_limit(pairs.pairs[k].wi);
    const Direction wo = with_grazing_limit(pairs.pairs[k].wo);
    if (part == "albedo") {
      const AlbedoEstimate albedo = bound.model->albedo_with_error(wi);
      answer.f.push_back(albedo.value);
      if (stochastic || is_plugin_path(name)) answer.standard_error.push_back(albedo.error);
      accuracy.add(albedo);
      continue;
    }
    const auto value = [&](Direction i, Direction o) {
      if (part == "pdf") return Rgb(bound.model->pdf(i, o));
      if (extra) return extra->eval(bound.parameters, i, o);
      return lobe < 0 ? bound.model->eval(i, o) : bound.model->eval_lobe(lobe, i, o);
    };
    if (!grazes_twice(pairs.pairs[k].wi, pairs.pairs[k].wo)) {
      answer.f.push_back(value(wi, wo));
    } else if (const auto limit = limit_where_both_graze(value, wi, wo)) {
      answer.f.push_back(*limit);
    } else {
      refuse_both_grazing(pairs, k);
    }
    if (stochastic && part != "pdf" && !extra)
      answer.standard_error.push_back((lobe < 0 ? stochastic->eval_with_error(wi, wo)
                                                : stochastic->eval_lobe_with_error(lobe, wi, wo))
                                          .standard_error);
  }
  accuracy.warn(what);
  return answer;
}

std::string row_text(const Rgb& v, bool color) {
  return color ? fmt::format(",{:.17g},{:.17g},{:.17g}", v.r, v.g, v.b)
               : fmt::format(",{:.17g}", v.r);
}

DirectionPairs pairs_of(const std::string& path) {
  if (path == "-") return read_pairs(std::cin, kStdin);
  std::ifstream file(path);
  const bool folder = std::filesystem::is_directory(path);
  if (!file || folder)
    throw UsageError(fmt::format("{}: {}; allowed: a CSV file of direction pairs, or -", path,
                                 std::strerror(folder ? EISDIR : errno)));
  return read_pairs(file, path);
}

std::string csv_text(const std::string& what, const DirectionPairs& pairs,
                     const CsvAnswer& answer) {
  std::string text = pairs.header + (answer.color ? ",f_r,f_g,f_b" : ",f");
  if (!answer.standard_error.empty()) text += answer.color ? ",se_r,se_g,se_b" : ",se";
  text += '\n';
  for (std::size_t k = 0; k < pairs.rows.size(); ++k) {
    const Rgb f = answer.f[k];
    if (!std::isfinite(f.r + f.g + f.b))
      throw std::domain_error(fmt::format("{}: a value that is not finite at {} = {}", what,
                                          pairs.header, pairs.rows[k]));
    text += pairs.rows[k] + row_text(f, answer.color);
    if (!answer.standard_error.empty()) text += row_text(answer.standard_error[k], answer.color);
    text += '\n';
  }
  return text;
}

// The pairs of a run in parts, and what it asks for.
DirectionPairs pairs_in(const DividedRun& run) {
  std::istringstream text(run.input);
  return read_pairs(text, run.options.pairs.empty() ? "pairs" : run.options.pairs);
}

TruthRequest truth_request_in(const DividedRun& run) {
  std::vector<std::string> words{"truth"};
  words.insert(words.end(), run.words.begin(), run.words.end());
  return truth_request_of(parse_model_words(words).values, run.stack, run.options);
}

void find_pairs(const DividedRun& run, const RunMonitor& monitor) {
  (void)eval_truth(truth_request_in(run), pairs_in(run), monitor);
}

int eval_run(const DividedRun& run, const RunMonitor& monitor) {
  const DirectionPairs pairs = pairs_in(run);
  const std::string text =
      csv_text("truth", pairs, eval_truth(truth_request_in(run), pairs, monitor));
  if (run.options.output.empty())
    fmt::print("{}", text);
  else
    write_file(run.options.output, text);
  return kDone;
}

// eval truth, as it can be divided: the stack and the pairs themselves, not where they are from.
int eval_truth_command(const Options& options, KeyValues values, const DirectionPairs& pairs) {
  const auto stack = take_stack(options, values, "truth", pairs);
  if (!stack)
    throw UsageError(
        "truth: key \"stack\": found nothing; allowed: a stack file, - or a built-in stack");
  check_pairs(pairs, *stack);
  DividedRun run{"eval", options, *stack};
  for (const auto& [key, value] : values) run.words.push_back(key + "=" + value);
  run.input = pairs.header + "\n";
  for (const std::string& row : pairs.rows) run.input += row + "\n";
  return do_divided(eval_divided(), run);
}

}  // namespace

const DividedCommand& eval_divided() {
  static const DividedCommand command{
      "eval", "FILE.csv",
      [](const DividedRun& run) { check_walks_are_given(truth_request_in(run)); }, find_pairs,
      eval_run};
  return command;
}

int eval_command(const Options& options, const std::vector<std::string>& words) {
  const DirectionPairs pairs = pairs_of(options.pairs);
  const std::string& what = words[0];
  if (what != "truth" && !options.shard.empty())
    throw UsageError(
        fmt::format("--shard: found {}, which is no work to divide; allowed: truth", what));
  if (what != "truth" && started_ranks())
    throw UsageError(
        fmt::format("mpirun: found {}, which is no work to divide; allowed: truth", what));
  CsvAnswer answer;
  try {
    if (what == "truth") return eval_truth_command(options, parse_model_words(words).values, pairs);
    if (what.starts_with("media.")) refuse_place(options, what);
    if (what.starts_with("media."))
      answer = eval_medium(what, parse_model_words(words).values, pairs.pairs);
    else
      answer = eval_model(options, what, parse_model_words(words).values, pairs);
  } catch (const std::invalid_argument& error) {
    throw UsageError(fmt::format("{}: {}", what, error.what()));
  }
  const std::string text = csv_text(what, pairs, answer);
  if (options.output.empty())
    fmt::print("{}", text);
  else
    write_file(options.output, text);
  return kDone;
}

}  // namespace lamella
