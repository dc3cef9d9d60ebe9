#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/command/command.h"
#include "compare/fit/fitted_models.h"
#include "compare/judge/sampler_statistics.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/model_request.h"
#include "compare/request/numbers.h"
#include "compare/request/stack_parameters.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Figures 11 and 13 of Portsmouth, Kutz and Hill 2025, "EON", and the same for VMF Diffuse.
std::vector<std::string> default_requests() {
  std::vector<std::string> list;
  for (const char* sampler : {"uniform", "cosine", "ltc", "cltc", "mis"})
    list.push_back(fmt::format("eon,roughness=1,sampler={}", sampler));
  for (const double r : {0.1, 0.25, 0.5, 0.75})
    for (const char* sampler : {"cosine", "mis"})
      list.push_back(fmt::format("eon,roughness={},sampler={}", r, sampler));
  for (const double r : {0.1, 0.5, 1.0})
    for (const char* sampler : {"cosine", "mis"})
      list.push_back(fmt::format("vmf_diffuse,roughness={},sampler={}", r, sampler));
  return list;
}

// Table 1 of the same paper: its nanoseconds on one thread of an AMD 3970X, for random roughness
// and albedo; NaN: not in it.
struct TimedModel {
  const char* name;
  double eval, cosine, mis;
};
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr TimedModel kTimed[] = {
    {"lambert", 1.4, 67.2, kNone},        {"fon", 6.3, 67.2, kNone},
    {"oren_nayar", 6.3, 67.4, kNone},     {"oren_nayar_full", 141.7, 211.218, kNone},
    {"eon_approx", 20.8, 105.8, 217.0},   {"eon", 108.7, 193.5, 297.0},
    {"vmf_diffuse", kNone, kNone, kNone},
};

Json number_or_null(double x) { return std::isnan(x) ? Json(nullptr) : Json(x); }

// Ours, the paper's, and ours over the paper's.
std::string beside(double ours, double papers) {
  const auto text = [](double x, int digits) {
    return std::isnan(x) ? std::string("-") : fmt::format("{:.{}f}", x, digits);
  };
  return fmt::format("{:>8} {:>7} {:>6}", text(ours, 1), text(papers, 1), text(ours / papers, 2));
}

Json measure_times(const Stack& stack, std::FILE* out) {
  if (out)
    fmt::print(out,
               "\nns per call: evaluation; cosine law and MIS with density and evaluation "
               "(parameters fixed), beside EON's Table 1\n  {:<16} {:>8} {:>7} {:>6} {:>8} {:>7} "
               "{:>6} {:>8} {:>7} {:>6}\n",
               "model", "eval", "paper", "ratio", "cosine", "paper", "ratio", "mis", "paper",
               "ratio");
  Json times = Json::array();
  for (const TimedModel& timed : kTimed) {
    const bool samples = find(find_model(timed.name)->parameters, "sampler") != nullptr;
    ModelRequest request{timed.name, {}};
    if (samples) request.values = {{"sampler", "cosine"}};
    const SamplerTimes cosine = sampler_times(*bind_model(request, &stack).model, 0.02);
    const double mis =
        samples ? sampler_times(*bind_model({timed.name, {}}, &stack).model, 0.02).sample : kNone;
    if (out)
      fmt::print(out, "  {:<16} {} {} {}\n", timed.name, beside(cosine.eval, timed.eval),
                 beside(cosine.sample, timed.cosine), beside(mis, timed.mis));
    times.push_back({{"model", timed.name},
                     {"eval_ns", cosine.eval},
                     {"cosine_sample_ns", cosine.sample},
                     {"mis_sample_ns", number_or_null(mis)},
                     {"paper_eval_ns", number_or_null(timed.eval)},
                     {"paper_cosine_sample_ns", number_or_null(timed.cosine)},
                     {"paper_mis_sample_ns", number_or_null(timed.mis)}});
  }
  return times;
}

std::vector<double> angles(const ClosedFormOptions& closed) {
  if (closed.outgoing.empty()) return {0, 15, 30, 45, 60, 70, 80, 85, 88, 89};
  std::vector<double> list;
  for (const std::string& text : closed.outgoing) {
    const auto theta = parse_number(text);
    if (!theta || !(*theta >= 0 && *theta <= 90))
      throw UsageError(
          fmt::format("--wo: found \"{}\"; allowed: an angle in degrees in [0, 90]", text));
    list.push_back(*theta);
  }
  return list;
}

void print_rows(std::FILE* out, const std::string& request, const Json& rows) {
  fmt::print(out, "{}\n  {:>7} {:>9} {:>9} {:>9} {:>9} {:>11} {:>11} {:>7}\n", request, "theta_o",
             "albedo", "+-", "mean", "+-", "variance", "max weight", "lost");
  for (const Json& row : rows)
    fmt::print(out, "  {:>7g} {:>9.5f} {:>9.1e} {:>9.5f} {:>9.1e} {:>11.4g} {:>11.4g} {:>7.4f}\n",
               row["theta_o"].get<double>(), row["albedo"].get<double>(),
               row["albedo_error"].get<double>(), row["mean"].get<double>(),
               row["standard_error"].get<double>(), row["variance"].get<double>(),
               row["max_weight"].get<double>(), row["lost"].get<double>());
}

// The rows that a line per model has room for, spread over all.
std::vector<std::size_t> shown_rows(std::size_t count) {
  constexpr std::size_t kMost = 5;
  std::vector<std::size_t> list;
  for (std::size_t k = 0; k < std::min(count, kMost); ++k)
    list.push_back(count <= kMost ? k : k * (count - 1) / (kMost - 1));
  return list;
}

// A line per model: what fits a screen.
void print_summary(std::FILE* out, const Json& models, const std::vector<double>& thetas) {
  fmt::print(out, "variance at theta_o, and the largest weight at any (--all: every row)\n  {:<40}",
             "model");
  const std::vector<std::size_t> shown = shown_rows(thetas.size());
  for (const std::size_t k : shown) fmt::print(out, "{:>9g}", thetas[k]);
  fmt::print(out, "{:>11}\n", "weight");
  for (const Json& model : models) {
    fmt::print(out, "  {:<40}", model["request"].get<std::string>());
    for (const std::size_t k : shown)
      fmt::print(out, "{:>9.3g}", model["rows"][k]["variance"].get<double>());
    double largest = 0;
    for (const Json& row : model["rows"])
      largest = std::max(largest, row["max_weight"].get<double>());
    fmt::print(out, "{:>11.4g}\n", largest);
  }
}

}  // namespace

int samplers_command(const Options& options, const ClosedFormOptions& closed) {
  std::FILE* out = table_stream(options);
  const Stack stack = stack_of(options);  // for models that are built from one
  const std::vector<double> thetas = angles(closed);
  const bool summary = options.models.empty() && !closed.all;
  Json answer = json_header("samplers", options.seed, isa_of(options));
  const InputFiles inputs(Stack{}, objects_among(model_requests(options)));
  answer["samples"] = closed.samples;
  answer["models"] = Json::array();
  for (const std::string& text : options.models.empty() ? default_requests() : options.models) {
    const BoundModel bound = bind_model(
        with_fitted_lobes(without_stack_key(parse_model_request(text), stack), stack), &stack);
    Json rows = Json::array();
    for (const double theta : thetas) {
      const Direction wo = direction_from_degrees(theta, 0);
      const SamplerStatistics s =
          sampler_statistics(*bound.model, wo, closed.samples, options.seed);
      const AlbedoEstimate albedo = bound.model->albedo_with_error(with_grazing_limit(wo));
      rows.push_back({{"theta_o", theta},
                      {"albedo", albedo.value.max()},
                      {"albedo_error", albedo.error.max()},
                      {"mean", s.mean},
                      {"standard_error", s.mean_error},
                      {"variance", s.variance},
                      {"max_weight", s.max_weight},
                      {"lost", s.lost}});
    }
    if (!options.quiet && !summary) print_rows(out, text, rows);
    answer["models"].push_back({{"request", text}, {"rows", std::move(rows)}});
  }
  if (!options.quiet && summary) print_summary(out, answer["models"], thetas);
  if (options.models.empty() && (closed.all || !options.json.empty()))
    answer["times"] = measure_times(stack, options.quiet || summary ? nullptr : out);
  inputs.check();
  add_files(answer, inputs);
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
