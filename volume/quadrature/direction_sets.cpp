#include "volume/quadrature/direction_sets.h"

#include <algorithm>

#include "phase/math/direction.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd joined(const VectorXd& nodes, const std::vector<double>& extra) {
  VectorXd all(nodes.size() + static_cast<Index>(extra.size()));
  all.head(nodes.size()) = nodes;
  for (std::size_t k = 0; k < extra.size(); ++k)
    all[nodes.size() + static_cast<Index>(k)] = std::max(extra[k], kGrazingLimit);
  return all;
}

// Cosines in the medium of that index, and which of them exist there.
std::vector<double> asked_in(double index, std::span<const AskedCosine> asked,
                             std::vector<bool>& exists) {
  constexpr double kNowhere = 0.5;
  std::vector<double> cosines;
  for (const AskedCosine& a : asked) {
    const double mu = snell_cosine(std::max(a.mu, kGrazingLimit), a.index, index);
    exists.push_back(mu > 0);
    cosines.push_back(mu > 0 ? mu : kNowhere);
  }
  return cosines;
}

// Nodes of a panel: the narrower it is, the fewer of them serve.
int nodes_of(double reach, int nodes) {
  constexpr int kFewest = 6;
  return reach == 1 ? nodes
                    : std::max(kFewest, static_cast<int>(std::ceil(nodes * std::sqrt(reach))));
}

}  // namespace

double snell_cosine(double mu, double from, double to) {
  if (from == to) return mu;
  const double ratio = from / to;
  // 1 - ratio^2 (1 - mu^2) in the form that keeps the digits of a small mu and of a ratio near 1.
  const double square = (1 - ratio) * (1 + ratio) + ratio * mu * ratio * mu;
  return square > 0 ? std::min(1.0, std::sqrt(square)) : 0;
}

double NodePanel::mu(double u) const { return snell_cosine(reach * map.mu(u), ratio, 1); }

double NodePanel::slope(double u) const {
  const double home = reach * map.slope(u);
  return ratio == 1 ? home : ratio * ratio * home * reach * map.mu(u) / mu(u);
}

double NodePanel::parameter(double mu) const {
  return map.parameter(std::clamp(snell_cosine(mu, 1, ratio) / reach, 0.0, 1.0));
}

DirectionSets::DirectionSets(int nodes, const std::vector<double>& extra_out,
                             const std::vector<double>& extra_in, const GrazingMap& grazing_map)
    : panels{{0, nodes, grazing_map}} {
  const Quadrature rule = grazing_quadrature(nodes, grazing_map);
  out = joined(rule.points, extra_out);
  in = joined(rule.points, extra_in);
  // Uniform radiance must carry exactly pi, or a Lambertian substrate would not keep its energy.
  weight = rule.weights / (2 * rule.points.dot(rule.weights));
  flux = 2 * kPi * rule.points.cwiseProduct(weight);
}

DirectionSets::DirectionSets(const RefractiveNodes& nodes, double medium,
                             std::span<const AskedCosine> asked_out,
                             std::span<const AskedCosine> asked_in_)
    : index(medium) {
  std::vector<double> points, weights;
  double rarer = 0;
  for (const double home : nodes.indices) {
    if (home > medium) break;
    NodePanel panel{static_cast<Index>(points.size()), 0, nodes.map, 1, home / medium};
    if (rarer > 0) panel.reach = std::sqrt((1 - rarer / home) * (1 + rarer / home));
    panel.count = nodes_of(panel.reach, nodes.nodes);
    const Quadrature rule = grazing_quadrature(static_cast<int>(panel.count), panel.map);
    // Uniform radiance must carry what lies between the two cosines, exactly; and the same flux
    // times index^2 in each medium.
    const double carried = panel.reach * panel.reach / (2 * rule.points.dot(rule.weights));
    for (Index k = 0; k < panel.count; ++k) {
      const double at_home = panel.reach * rule.points[k];
      const double mu = snell_cosine(at_home, home, medium);
      points.push_back(mu);
      weights.push_back(carried * rule.points[k] * rule.weights[k] * panel.ratio * panel.ratio /
                        mu);
    }
    panels.push_back(panel);
    rarer = home;
  }
  const Index count = static_cast<Index>(points.size());
  const VectorXd cosines = Eigen::Map<const VectorXd>(points.data(), count);
  weight = Eigen::Map<const VectorXd>(weights.data(), count);
  flux = 2 * kPi * cosines.cwiseProduct(weight);
  out = joined(cosines, asked_in(medium, asked_out, out_exists));
  in = joined(cosines, asked_in(medium, asked_in_, in_exists));
}

}  // namespace lamella
