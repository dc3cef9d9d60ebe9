#include "analytic/model/model.h"

#include <algorithm>
#include <array>
#include <vector>

#include "phase/math/sampling.h"

namespace lamella {

std::vector<ParameterInfo> parameters_of(const ModelInfo& info, const std::string& choice) {
  std::vector<ParameterInfo> all = info.parameters;
  if (info.selector.empty()) return all;
  const std::vector<std::string>& choices = find(info.parameters, info.selector)->choices;
  if (std::find(choices.begin(), choices.end(), choice) == choices.end()) return all;
  const std::vector<ParameterInfo> further = info.selected(choice);
  all.insert(all.end(), further.begin(), further.end());
  return all;
}

std::vector<ParameterInfo> parameters_of(const ModelInfo& info, const Parameters& parameters) {
  if (info.selector.empty()) return info.parameters;
  return parameters_of(info, parameters.has(info.selector)
                                 ? parameters.choice(info.selector)
                                 : find(info.parameters, info.selector)->default_value);
}

Rgb Model::eval(Direction wi, Direction wo) const {
  Rgb sum;
  for (int lobe = 0; lobe < lobes_; ++lobe) sum += eval_lobe(lobe, wi, wo);
  return sum;
}

void Model::eval_lobes(Direction wi, Direction wo, std::span<Rgb> values) const {
  for (int lobe = 0; lobe < lobes_; ++lobe) values[lobe] = eval_lobe(lobe, wi, wo);
}

void Model::eval(std::span<const DirectionPair> pairs, std::span<Rgb> values) const {
  static const Isa widest = isa_from_text("auto");
  eval(pairs, values, widest);
}

void Model::eval(std::span<const DirectionPair> pairs, std::span<Rgb> values, Isa /*isa*/) const {
  for (std::size_t k = 0; k < pairs.size(); ++k) values[k] = eval(pairs[k].wi, pairs[k].wo);
}

std::optional<Direction> Model::sample(Direction wo, double u1, double u2, double /*u3*/) const {
  return cosine_hemisphere(Direction{0, 0, wo.z < 0 ? -1.0 : 1.0}, u1, u2);
}

double Model::pdf(Direction wi, Direction wo) const {
  const bool same_side = (wi.z < 0) == (wo.z < 0);
  return same_side ? std::abs(wi.z) / kPi : 0;
}

AlbedoEstimate Model::albedo_with_error(Direction wi) const {
  std::vector<DirectionPair> pairs;
  const auto f = [&](std::span<const Direction> directions, std::span<Rgb> values) {
    pairs.clear();
    for (const Direction& wo : directions) pairs.push_back({wi, wo});
    // In double on every machine, so that an albedo does not depend on the instruction set.
    eval(pairs, values, Isa::scalar);
  };
  const DirectionalIntegral integral = integrate_projected(f, wi, std::array{1.0, -1.0});
  return {integral.value, integral.error, integral.end};
}

double Model::uncollided(Direction /*wi*/) const { return 0; }

Rgb Model::specular(Direction /*wi*/) const { return {}; }

}  // namespace lamella
