#include "compare/judge/furnace_sweep.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "compare/judge/parameter_steps.h"
#include "phase/math/larger_error.h"

namespace lamella {
namespace {

constexpr double kCosines[] = {1, 0.9, 0.6, 0.3, 0.1, 0.02, 0};
constexpr int kSteps = 5;

std::vector<ParameterValue> values_of(const ParameterInfo& p) {
  if (is_white(p)) return {Rgb(1)};
  if (p.name == "base_weight") return {1.0};
  if (p.name == "material") return {std::string("white"), std::string("dielectric")};
  if (is_shape(p)) {
    const std::vector<double> list = steps_of_range(p, kSteps);
    return {list.begin(), list.end()};
  }
  if (p.name == "surface") return {p.choices.begin(), p.choices.end()};
  return {parse_value(p, p.default_value)};
}

double degrees_of(double mu) { return std::acos(mu) * 180 / kPi; }

}  // namespace

std::vector<double> furnace_sweep_angles() {
  std::vector<double> angles;
  for (const double mu : kCosines) angles.push_back(degrees_of(mu));
  return angles;
}

FurnaceSweep sweep_furnace(const ModelInfo& info) {
  FurnaceSweep sweep;
  std::vector<std::vector<ParameterValue>> choices;
  for (const ParameterInfo& p : info.parameters) {
    choices.push_back(values_of(p));
    if (choices.back().size() < 2) continue;
    FurnaceSweepAxis& axis = sweep.axes.emplace_back();
    axis.name = p.name;
    for (const ParameterValue& value : choices.back()) axis.values.push_back(to_text(value));
  }
  std::vector<std::size_t> at(choices.size(), 0);
  for (bool more = true; more;) {
    Parameters parameters;
    std::string text;
    for (std::size_t k = 0; k < choices.size(); ++k) {
      parameters.set(info.parameters[k].name, choices[k][at[k]]);
      if (choices[k].size() > 1)
        text += fmt::format("{}{}={}", text.empty() ? "" : ", ", info.parameters[k].name,
                            to_text(choices[k][at[k]]));
    }
    const auto model = info.make(parameters, nullptr);
    ++sweep.configurations;
    for (const double mu : kCosines) {
      const Direction wi = with_grazing_limit(direction_from_mu_phi(mu, 0));
      const AlbedoEstimate albedo = model->albedo_with_error(wi);
      const double energy = albedo.value.g + model->specular(wi).g + model->uncollided(wi);
      if (!std::isfinite(energy))
        throw std::domain_error(
            fmt::format("{}: the energy at mu = {} is not finite with {}", info.name, mu, text));
      sweep.energies.push_back(energy);
      sweep.worst_error = larger_error(sweep.worst_error, albedo.error.g);
      const double theta = degrees_of(mu);
      if (energy < sweep.least.energy) sweep.least = SweepExtreme{energy, theta, text};
      if (energy > sweep.most.energy) sweep.most = SweepExtreme{energy, theta, text};
    }
    more = false;
    for (std::size_t k = 0; k < at.size() && !more; ++k) {
      more = ++at[k] < choices[k].size();
      if (!more) at[k] = 0;
    }
  }
  return sweep;
}

}  // namespace lamella
