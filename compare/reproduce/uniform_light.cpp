#include "compare/reproduce/uniform_light.h"

#include <fmt/format.h>

#include <vector>

#include "compare/request/model_request.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {

Rgb quick_albedo(const Model& model, double mu) {
  constexpr int kAzimuths = 24;
  const Quadrature& rule = cached_gauss_legendre(16);
  const Direction wo = direction_from_mu_phi(mu, 0);
  std::vector<DirectionPair> pairs;
  for (const double mu_i : rule.points)
    for (int k = 0; k < kAzimuths; ++k)
      pairs.push_back({direction_from_mu_phi(mu_i, kPi * (k + 0.5) / kAzimuths), wo});
  std::vector<Rgb> values(pairs.size());
  model.eval(pairs, values);
  Rgb sum;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    sum += 2 * kPi * rule.weights[static_cast<Eigen::Index>(k / kAzimuths)] / kAzimuths *
           pairs[k].wi.z * values[k];
  return sum;
}

Rgb quick_average_albedo(const Model& model) {
  Rgb sum;
  const Quadrature& rule = cached_gauss_legendre(8);
  for (Eigen::Index k = 0; k < rule.points.size(); ++k)
    sum += 2 * rule.points[k] * rule.weights[k] * quick_albedo(model, rule.points[k]);
  return sum;
}

std::string with_bond_albedo(const std::string& request, Rgb color) {
  const auto with = [&](Rgb a) {
    return fmt::format("{},albedo={},{},{}", request, a.r, a.g, a.b);
  };
  Rgb low, high(1);
  for (int k = 0; k < 10; ++k) {
    const Rgb middle = 0.5 * (low + high);
    const Rgb reflected =
        quick_average_albedo(*bind_model(parse_model_request(with(middle)), nullptr).model);
    for (int c = 0; c < 3; ++c) (reflected[c] < color[c] ? low : high)[c] = middle[c];
  }
  return with(0.5 * (low + high));
}

}  // namespace lamella
