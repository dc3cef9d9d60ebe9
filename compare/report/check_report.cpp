#include "compare/report/check_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "compare/report/json_report.h"
#include "compare/report/wrapped_text.h"
#include "phase/math/degrees.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostIndent = 11;

std::string direction_text(const char* name, Direction w) {
  return fmt::format(", {} at theta {:.6g}, phi {:.6g}", name, theta_degrees(w), phi_degrees(w));
}

std::string text_of(const CheckCase& worst) {
  std::string text = worst.text;
  // Values that the model's loader refused name their directions.
  if (text.find("w_i = ") != std::string::npos) return text;
  if (worst.wi) text += direction_text("w_i", *worst.wi);
  if (worst.wo) text += direction_text("w_o", *worst.wo);
  return text + "; " + worst.parameters;
}

Json direction_json(Direction w) { return Json::array({w.x, w.y, w.z}); }

}  // namespace

std::string to_text(const CheckLine& line, int width) {
  std::string cases = line.cases ? fmt::format("{} cases", line.cases) : "";
  if (line.undecided) cases += fmt::format(", {} undecided", line.undecided);
  std::string text = fmt::format("  {:<9}  {:<{}}  {}\n", to_text(line.verdict()), line.name, width,
                                 line.cases ? cases : line.reason);
  if (line.worst && (line.worst->found > 0 || line.verdict() == CheckVerdict::fail))
    text += wrapped(
        fmt::format("  {:<9}  {:<{}}  ", "", "", std::min(width, kMostIndent)),
        (line.verdict() == CheckVerdict::fail ? "found: " : "worst: ") + text_of(*line.worst));
  return text;
}

std::string to_text(const ModelCheck& check) {
  int width = 11;
  for (const CheckLine& line : check.lines)
    width = std::max(width, static_cast<int>(line.name.size()));
  std::string text;
  for (const CheckLine& line : check.lines) text += to_text(line, width);
  const SamplerExtremes& e = check.extremes;
  if (!e.parameters.empty())
    text += wrapped(
        "  ", fmt::format("Samples' weights: variance up to {:.4g} (theta_o {:.6g}; {}), largest "
                          "weight {:.4g}, {:.4g} of the samples without light.",
                          e.variance, e.theta_o, e.parameters, e.max_weight, e.lost));
  return text;
}

Json to_json(const CheckLine& line) {
  Json entry{{"name", line.name},
             {"claim", line.claim},
             {"verdict", to_text(line.verdict())},
             {"cases", line.cases},
             {"undecided", line.undecided}};
  if (!line.reason.empty()) entry["reason"] = line.reason;
  if (line.worst) {
    Json worst{{"text", line.worst->text},
               {"found", json_number(line.worst->found)},
               {"allowed", json_number(line.worst->allowed)},
               {"request", line.worst->parameters}};
    if (line.worst->wi) worst["wi"] = direction_json(*line.worst->wi);
    if (line.worst->wo) worst["wo"] = direction_json(*line.worst->wo);
    entry["worst"] = std::move(worst);
  }
  return entry;
}

Json to_json(const ModelCheck& check) {
  Json lines = Json::array();
  for (const CheckLine& line : check.lines) lines.push_back(to_json(line));
  const SamplerExtremes& e = check.extremes;
  Json answer{{"verdict", check.failed() ? "fail" : "pass"},
              {"configurations", check.configurations},
              {"refused", check.refused},
              {"ended_by_time", check.ended_by_time},
              {"samples", check.samples},
              {"single_precision", check.single_precision},
              {"checks", std::move(lines)}};
  if (!e.parameters.empty())
    answer["sampler"] = {{"variance", json_number(e.variance)},
                         {"max_weight", json_number(e.max_weight)},
                         {"lost", e.lost},
                         {"theta_o", e.theta_o},
                         {"request", e.parameters}};
  return answer;
}

}  // namespace lamella
