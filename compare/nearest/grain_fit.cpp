#include "compare/nearest/grain_fit.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "compare/fit/least_squares.h"
#include "compare/nearest/stack_fit.h"
#include "compare/report/json_report.h"
#include "compare/report/wrapped_text.h"
#include "compare/request/errors.h"
#include "compare/request/percent.h"
#include "phase/math/degrees.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Below it the lobes of flakes change no more that cells could show.
constexpr char kRange[] = "layer.0.roughness=0.02:1";

NearestModels fitted_form(const TargetTruths& target, const Stack& equivalent,
                          const RunMonitor& monitor) {
  const ModelRequest request{"vmf_diffuse",
                             {{"albedo", request_value(equivalent.layers[0].albedo)}}};
  return nearest_models(target, parametric_models({request}, target.plan.channels),
                        FitNorm::relative, FitSides::all, monitor);
}

// The fitted number, or none where nothing was free.
const FittedNumber* number_of(const ModelFit& fit) {
  return fit.numbers.empty() ? nullptr : &fit.numbers.front();
}

std::string row(const std::string& what, const ModelFit& fit, double given) {
  const FittedNumber* const number = number_of(fit);
  const bool found = number && number->state == FreeState::found;
  return fmt::format("  {:<30} {:>9.4f} {:>8} {:>9} {:>10} {:>9}{}\n", what,
                     number ? number->value : given,
                     found ? fmt::format("{:.1g}", number->deviation) : "-",
                     found ? fmt::format("{:.1g}", number->of_truth) : "-",
                     percent_cell(fit.relative_rmse), percent_cell(fit.relative_rmse_without_noise),
                     number && !found ? "  " + to_text(number->state) : "");
}

Json fit_entry(const ModelFit& fit, double given) {
  const FittedNumber* const number = number_of(fit);
  Json entry{{"roughness", number ? number->value : given}};
  if (number) {
    entry["state"] = to_text(number->state);
    entry["deviation"] = json_number(number->deviation);
    entry["of_truth"] = json_number(number->of_truth);
  }
  entry["relative_rmse"] = json_number(fit.relative_rmse);
  entry["relative_rmse_without_noise"] = json_number(fit.relative_rmse_without_noise);
  return entry;
}

double roughness_of(const Stack& stack) { return stack.layers[0].parameters.number("roughness"); }

}  // namespace

GrainFit fit_grains(const TruthRequest& request, const Stack& equivalent,
                    const RunMonitor& monitor) {
  require_least_squares();
  const Layer& layer = equivalent.layers.at(0);
  if (!layer.parameters.has("roughness"))
    throw UsageError(
        fmt::format("--fit: found the medium {}, which has no roughness; allowed: --medium "
                    "vmf_flake or sggx",
                    layer.medium_name));
  GroundTruth truth(request, Estimator::analog, monitor);
  GrainFit fit{
      .equivalent = equivalent, .target = truths_of(truth), .by_normals = {}, .medium = {}};
  TruthRequest how{.stack = equivalent};
  how.seed = request.seed;
  how.isa = request.isa;
  const int channels = fit.target.plan.channels;
  fit.by_normals =
      nearest_stack(fit.target, {equivalent, {}}, how, FitNorm::relative, FitSides::all, monitor);
  fit.medium = nearest_stack(fit.target, parametric_stack(equivalent, {kRange}, channels), how,
                             FitNorm::relative, FitSides::all, monitor);
  if (layer.medium_name == "vmf_flake" && equivalent.is_half_space() &&
      layer.parameters.choice("flake") == "lambert")
    fit.form = fitted_form(fit.target, equivalent, monitor);
  return fit;
}

std::string grain_fit_table(const GrainFit& fit) {
  std::string angles;
  for (const Truth& truth : fit.target.truths)
    angles += fmt::format(" {:g}", theta_degrees(truth.run.incident));
  const std::string medium = fit.equivalent.layers[0].medium_name;
  const double measured = roughness_of(fit.equivalent);
  std::string text = wrapped(
      "", fmt::format("roughness by lobes, {} walks among the grains per direction, theta_i{}",
                      fit.target.truths.front().run.walks, angles));
  text += fmt::format("  {:<30} {:>9} {:>8} {:>9} {:>10} {:>9}\n", "", "roughness", "+-",
                      "of truth", "rel. RMSE", "no noise");
  text += row(medium + ", by normals", fit.by_normals.fits.front(), measured);
  text += row(medium + ", by lobes", fit.medium.fits.front(), measured);
  if (fit.form) text += row("vmf_diffuse, by lobes", fit.form->fits.front(), measured);
  return text;
}

Json grain_fit_json(const GrainFit& fit) {
  const double measured = roughness_of(fit.equivalent);
  Json json{{"walks", fit.target.truths.front().run.walks}, {"mu_i", Json::array()}};
  for (const Truth& truth : fit.target.truths) json["mu_i"].push_back(truth.run.incident.z);
  json["medium"] = fit.equivalent.layers[0].medium_name;
  json["interrupted"] = fit.medium.interrupted;
  json["medium_by_normals"] = fit_entry(fit.by_normals.fits.front(), measured);
  json["medium_by_lobes"] = fit_entry(fit.medium.fits.front(), measured);
  if (fit.form) json["vmf_diffuse"] = fit_entry(fit.form->fits.front(), measured);
  return json;
}

}  // namespace lamella
