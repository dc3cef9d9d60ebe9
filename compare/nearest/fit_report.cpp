#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/nearest/nearest_models.h"
#include "compare/report/json_report.h"
#include "compare/report/wrapped_text.h"
#include "compare/request/percent.h"
#include "phase/math/degrees.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

std::string found_text(const ModelFit& fit) {
  std::string text;
  for (const auto& [key, value] : fit.request.values)
    text += fmt::format("{}{} = {}{}", text.empty() ? "" : ", ", key, value,
                        fit.request.sources.contains(key) ? "" : " (given)");
  return text.empty() ? "no parameters" : text;
}

std::string error_text(double error) {
  return std::isfinite(error) ? fmt::format("{:.2g}", error) : "-";
}

std::string block(const ModelFit& fit) {
  std::string text =
      fmt::format("\n{}: {} left over", fit.request.name, percent_text(fit.relative_rmse));
  if (fit.noise > 0) text += fmt::format(", noise {}", percent_text(fit.noise));
  if (fit.starts > 0)
    text += fmt::format("; {} of {} searches ended there", fit.agreeing, fit.starts);
  text += "\n";
  if (!fit.numbers.empty())
    text += fmt::format("  {:<24} {:>12} {:>9} {:>9}\n", "parameter", "value", "+-", "of truth");
  for (const FittedNumber& n : fit.numbers)
    text += fmt::format("  {:<24} {:>12.6g} {:>9} {:>9}{}\n", n.number.name(), n.value,
                        n.state == FreeState::found ? error_text(n.deviation) : "-",
                        n.state == FreeState::found ? error_text(n.of_truth) : "-",
                        n.state == FreeState::found ? "" : "  " + to_text(n.state));
  text += fmt::format("  {:>7} {:>9} {:>13} {:>13} {:>10} {:>9}\n", "theta_i", "side",
                      "energy truth", "energy model", "rel. RMSE", "noise");
  for (const FittedLobe& lobe : fit.lobes)
    text +=
        fmt::format("  {:>7g} {:>9} {:>13.5f} {:>13.5f} {:>10} {:>9}\n", theta_degrees(lobe.wi),
                    lobe.reflected ? "reflect" : "transmit", lobe.energy_truth, lobe.energy_model,
                    percent_cell(lobe.relative_rmse), percent_cell(lobe.noise));
  return text;
}

Json to_json(const FittedNumber& n) {
  return {{"name", n.number.name()},
          {"value", n.value},
          {"state", to_text(n.state)},
          {"deviation", json_number(n.deviation)},
          {"of_truth", json_number(n.of_truth)},
          {"lowest", n.number.low},
          {"highest", n.number.high}};
}

Json lobes_and_numbers(const ModelFit& fit) {
  Json numbers = Json::array(), lobes = Json::array(), covariance = Json::array();
  for (const FittedNumber& n : fit.numbers) numbers.push_back(to_json(n));
  for (std::size_t k = 0; k < fit.numbers.size(); ++k) {
    Json row = Json::array();
    for (std::size_t i = 0; i < fit.numbers.size(); ++i)
      row.push_back(fit.covariance[k * fit.numbers.size() + i]);
    covariance.push_back(std::move(row));
  }
  for (const FittedLobe& lobe : fit.lobes)
    lobes.push_back({{"mu_i", lobe.wi.z},
                     {"phi_i", phi_degrees(lobe.wi)},
                     {"side", lobe.reflected ? "reflect" : "transmit"},
                     {"energy_truth", lobe.energy_truth},
                     {"energy_model", lobe.energy_model},
                     {"energy_missing", lobe.energy_missing},
                     {"relative_rmse", json_number(lobe.relative_rmse)},
                     {"noise", json_number(lobe.noise)}});
  return {{"name", fit.request.name},
          {"model", request_text(fit.request)},
          {"misfit", fit.misfit},
          {"relative_rmse", fit.relative_rmse},
          {"relative_rmse_without_noise", fit.relative_rmse_without_noise},
          {"noise", fit.noise},
          {"parameters", std::move(numbers)},
          {"covariance", std::move(covariance)},
          {"residues", std::move(lobes)},
          {"searches", fit.starts},
          {"searches_agreeing", fit.agreeing},
          {"iterations", fit.iterations}};
}

Json to_json(const ModelFit& fit) {
  Json json = lobes_and_numbers(fit);
  if (fit.info) return json;
  // A stack is no model: its file, and how its lobes were found.
  json.erase("model");
  json["stack"] = fit.stack;
  json["lobes_by"] = fit.estimator;
  return json;
}

}  // namespace

std::string fit_summary(const TargetTruths& target, const NearestModels& nearest) {
  const RunResult& first = target.truths.front().run;
  std::string text =
      wrapped("",
              fmt::format("{}: {}{}{}", target.request.stack.name,
                          first.is_bounded() || first.walks == 0
                              ? ""
                              : fmt::format("{} walks per direction, ", first.walks),
                          estimator_text(target.choice, target.request),
                          first.channels == 3 ? fmt::format("; energies: {}", kLuminanceName) : ""),
              2);
  text += nearest.norm == FitNorm::relative
              ? "least: relative RMSE of f over cells of equal projected solid angle, every "
                "direction alike\n"
              : "least: RMS of ln f over cells of equal projected solid angle (\"in ln f\")\n";
  if (target.plan.transmits && !nearest.transmitted)
    text += "transmission is left out (--sides reflect)\n";
  if (!nearest.fits.front().info)
    text += wrapped("", fmt::format("lobes of the stack {}: {}", nearest.fits.front().request.name,
                                    nearest.fits.front().estimator));
  const bool logs = nearest.norm == FitNorm::logarithmic;
  const HeldOut& held_out = nearest.held_out;
  const bool judged = !held_out.directions.empty();
  text += fmt::format("\n  rank {:<28} {}{:>10} {:>10}{}\n",
                      nearest.fits.front().info ? "model" : "stack", logs ? " in ln f  " : "",
                      "rel. RMSE", "no noise", judged ? "   held out" : "");
  for (std::size_t k = 0; k < nearest.fits.size(); ++k) {
    const ModelFit& fit = nearest.fits[k];
    text +=
        fmt::format("  {:>4} {:<28} {}{:>10} {:>10}{}\n", k + 1, fit.request.name,
                    logs ? fmt::format("{:>8.4f}  ", fit.misfit) : "",
                    percent_cell(fit.relative_rmse), percent_cell(fit.relative_rmse_without_noise),
                    judged ? fmt::format(" {:>10}", percent_cell(held_out.relative_rmse[k])) : "");
    text += wrapped("       ", found_text(fit));
  }
  for (const std::string& why : nearest.refused) text += wrapped("     - ", why);
  for (std::size_t k = 0; k < nearest.fits.size() && k < kToldModels; ++k)
    text += block(nearest.fits[k]);
  if (nearest.fits.size() > kToldModels)
    text += fmt::format("\nthe other {} models: --json\n", nearest.fits.size() - kToldModels);
  double missing = 0;
  for (const FittedLobe& lobe : nearest.fits.front().lobes)
    missing = std::max(missing, lobe.energy_missing);
  if (missing > 0)
    text += fmt::format("walks were cut: the truth's energies are too low by {:.1e} at most\n",
                        missing);
  if (judged) {
    std::string angles;
    for (const Direction wi : held_out.directions)
      angles += fmt::format("{}{:g}", angles.empty() ? "" : ", ", theta_degrees(wi));
    text += "\n" + wrapped("", fmt::format("held out: without noise, on incident directions that "
                                           "nothing was fitted to, theta_i {}",
                                           angles));
  }
  text += "\n";
  text += wrapped("",
                  "+-: one standard deviation, as if what is left over were independent from cell "
                  "to cell; of truth: the part that the truth's own error makes");
  const ModelFit& best = nearest.fits.front();
  if (best.info)
    text += fmt::format("\n--model {}\n", request_text(best.request));
  else
    text += fmt::format("\n\n{}", best.stack);
  return text;
}

Json fit_json(const TargetTruths& target, const NearestModels& nearest) {
  Json answer = json_header("fit", target.request);
  add_choice(answer, target.choice, target.request);
  answer["walks"] = target.truths.front().run.walks;
  answer["interrupted"] = nearest.interrupted;
  answer["norm"] = to_text(nearest.norm);
  answer["sides"] = nearest.transmitted ? "all" : "reflect";
  answer["models"] = Json::array();
  for (std::size_t k = 0; k < nearest.fits.size(); ++k) {
    Json one = to_json(nearest.fits[k]);
    if (!nearest.held_out.directions.empty())
      one["held_out_relative_rmse"] = nearest.held_out.relative_rmse[k];
    answer["models"].push_back(std::move(one));
  }
  for (const Direction wi : nearest.held_out.directions)
    answer["held_out"].push_back({{"mu_i", wi.z}, {"phi_i", phi_degrees(wi)}});
  answer["refused"] = nearest.refused;
  return answer;
}

}  // namespace lamella
