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

}  // namespace

DirectionSets::DirectionSets(int nodes, const std::vector<double>& extra_out,
                             const std::vector<double>& extra_in, const GrazingMap& grazing_map)
    : map(grazing_map) {
  const Quadrature rule = grazing_quadrature(nodes, map);
  out = joined(rule.points, extra_out);
  in = joined(rule.points, extra_in);
  // Uniform radiance must carry exactly pi, or a Lambertian substrate would not keep its energy.
  weight = rule.weights / (2 * rule.points.dot(rule.weights));
  flux = 2 * kPi * rule.points.cwiseProduct(weight);
}

}  // namespace lamella
