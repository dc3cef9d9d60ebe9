#include <fmt/format.h>

#include "compare/closed_form_command.h"
#include "compare/json_report.h"
#include "compare/model_request.h"
#include "compare/sampler_statistics.h"

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

// Table 1 of the same paper, with VMF Diffuse.
constexpr const char* kTimed[] = {"lambert",    "fon", "oren_nayar", "oren_nayar_full",
                                  "eon_approx", "eon", "vmf_diffuse"};

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

}  // namespace

int samplers_command(const Options& options, const ClosedFormOptions& closed) {
  std::FILE* out = table_stream(options);
  const Stack stack = stack_of(options);  // for models that are built from one
  const std::vector<double> thetas = angles(closed);
  Json answer = json_header("samplers", options);
  answer["samples"] = closed.samples;
  answer["models"] = Json::array();
  Options one = options;
  for (const std::string& text : options.models.empty() ? default_requests() : options.models) {
    one.models = {text};
    const BoundModel bound = std::move(models_for(one, stack).front());
    if (!options.quiet)
      fmt::print(out, "{}\n  {:>7} {:>9} {:>9} {:>9} {:>11} {:>11} {:>7}\n", text, "theta_o",
                 "albedo", "mean", "+-", "variance", "max weight", "lost");
    Json rows = Json::array();
    for (const double theta : thetas) {
      const Direction wo = direction_from_degrees(theta, 0);
      const SamplerStatistics s =
          sampler_statistics(*bound.model, wo, closed.samples, options.seed);
      const double albedo = bound.model->albedo(with_grazing_limit(wo)).max();
      if (!options.quiet)
        fmt::print(out, "  {:>7g} {:>9.5f} {:>9.5f} {:>9.1e} {:>11.4g} {:>11.4g} {:>7.4f}\n", theta,
                   albedo, s.mean, s.mean_error, s.variance, s.max_weight, s.lost);
      rows.push_back({{"theta_o", theta},
                      {"albedo", albedo},
                      {"mean", s.mean},
                      {"standard_error", s.mean_error},
                      {"variance", s.variance},
                      {"max_weight", s.max_weight},
                      {"lost", s.lost}});
    }
    answer["models"].push_back({{"request", text}, {"rows", std::move(rows)}});
  }
  if (options.models.empty()) {
    answer["times"] = Json::array();
    if (!options.quiet)
      fmt::print(out,
                 "\nns per call: evaluation; cosine law and MIS with density and evaluation "
                 "(parameters fixed)\n  {:<16} {:>8} {:>8} {:>8}\n",
                 "model", "eval", "cosine", "mis");
    for (const char* name : kTimed) {
      const bool samples = find(find_model(name)->parameters, "sampler") != nullptr;
      ModelRequest request{name, {}};
      if (samples) request.values = {{"sampler", "cosine"}};
      const SamplerTimes cosine = sampler_times(*bind_model(request, &stack).model, 0.02);
      std::optional<double> mis;
      if (samples) mis = sampler_times(*bind_model({name, {}}, &stack).model, 0.02).sample;
      if (!options.quiet)
        fmt::print(out, "  {:<16} {:>8.1f} {:>8.1f} {:>8}\n", name, cosine.eval, cosine.sample,
                   mis ? fmt::format("{:.1f}", *mis) : "-");
      answer["times"].push_back({{"model", name},
                                 {"eval_ns", cosine.eval},
                                 {"cosine_sample_ns", cosine.sample},
                                 {"mis_sample_ns", mis ? Json(*mis) : Json(nullptr)}});
    }
  }
  write_json(answer, options);
  return kDone;
}

}  // namespace lamella
