#include "volume/adding/rough_crossing.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kPointsPerInterval = 10;

// Transmission of one boundary, either way.
class Transmission {
 public:
  Transmission(const Interface& interface, double outside, double between)
      : outside_is_rarer_(outside < between),
        ratio_(outside_is_rarer_ ? between / outside : outside / between),
        profile_(interface.facets, interface.masking, ratio_) {}

  // Modes of f between |mu| outside and |mu'| between the boundaries; arrives: light comes from
  // outside.
  void modes(double outside, double between, bool arrives, ArrayXd& result) const {
    profile_.modes(outside_is_rarer_ ? outside : between, outside_is_rarer_ ? between : outside,
                   result);
    if (arrives != outside_is_rarer_) result /= ratio_ * ratio_;
  }
  // As a function of mu'.
  [[nodiscard]] FacetProfile::Places places(double outside) const {
    return profile_.places(outside, outside_is_rarer_);
  }

 private:
  bool outside_is_rarer_;
  double ratio_;
  FacetProfile profile_;
};

// Ends of intervals in the polar angle, doubling away from either peak.
std::vector<double> interval_ends(const FacetProfile::Places& a, const FacetProfile::Places& b) {
  std::vector<double> ends{0, kPi / 2};
  const auto add = [&](double at) {
    if (at > 0 && at < kPi / 2) ends.push_back(at);
  };
  for (const FacetProfile::Places* places : {&a, &b}) {
    for (const double edge : places->edges) add(edge);
    add(places->peak);
    for (double step = places->width / 2; step < kPi / 2; step *= 2) {
      add(places->peak - step);
      add(places->peak + step);
    }
  }
  // Towards grazing, where masking, Fresnel's shares and attenuation are steep.
  for (double step = 0.2; step > 1e-3; step /= 4) add(kPi / 2 - step);
  std::sort(ends.begin(), ends.end());
  ends.erase(
      std::unique(ends.begin(), ends.end(), [](double x, double y) { return y - x < 1e-12; }),
      ends.end());
  return ends;
}

VectorXd asked(const VectorXd& cosines, Index nodes) {
  return cosines.tail(cosines.size() - nodes);
}

}  // namespace

RoughCrossing::RoughCrossing(const Interface& upper, const Interface& lower,
                             const DirectionSets& above, const DirectionSets& between,
                             const DirectionSets& below, std::vector<const Layer*> layers,
                             int modes)
    : layers_(std::move(layers)) {
  const Transmission first(upper, above.index, between.index),
      second(lower, below.index, between.index);
  const auto cross = [&](bool travels_down) {
    const Transmission &in = travels_down ? first : second, &out = travels_down ? second : first;
    const DirectionSets &from = travels_down ? above : below, &to = travels_down ? below : above;
    const VectorXd mu_i = asked(from.in, from.nodes()), mu_o = asked(to.out, to.nodes());
    std::vector<MatrixXd> result(modes, MatrixXd::Zero(mu_o.size(), mu_i.size()));
    const auto exists = [](const std::vector<bool>& list, Index k) {
      return list.empty() || list[static_cast<std::size_t>(k)];
    };
    oneapi::tbb::parallel_for(Index{0}, mu_i.size() * mu_o.size(), [&](Index pair) {
      const Index i = pair / mu_o.size(), o = pair % mu_o.size();
      if (!exists(from.in_exists, i) || !exists(to.out_exists, o)) return;
      const std::vector<double> ends = interval_ends(in.places(mu_i[i]), out.places(mu_o[o]));
      const Quadrature& rule = cached_gauss_legendre(kPointsPerInterval);
      ArrayXd f1(modes), f2(modes), sum = ArrayXd::Zero(modes);
      for (std::size_t e = 0; e + 1 < ends.size(); ++e)
        for (int p = 0; p < kPointsPerInterval; ++p) {
          const double length = ends[e + 1] - ends[e];
          const double theta = ends[e] + length * rule.points[p], mu = std::cos(theta);
          const double share = survives(mu, travels_down);
          if (share == 0) continue;
          in.modes(mu_i[i], mu, true, f1);
          out.modes(mu_o[o], mu, false, f2);
          sum += (length * rule.weights[p] * mu * std::sin(theta) * share) * f1 * f2;
        }
      for (int m = 0; m < modes; ++m) result[m](o, i) = 2 * kPi * sum[m];
    });
    return result;
  };
  down = cross(true);
  up = cross(false);
}

double RoughCrossing::survives(double mu, bool travels_down) const {
  double depth = 0;
  const double sine = std::sqrt((1 - mu) * (1 + mu));
  for (const Layer* layer : layers_)
    depth += layer->depth() * sigma(layer->medium, {sine, 0, travels_down ? mu : -mu}) / mu;
  return std::exp(-depth);
}

}  // namespace lamella
