#include "volume/adding/thin_layer.h"

#include <algorithm>
#include <cmath>

#include "phase/math/direction.h"

namespace lamella {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

// (1 - exp(-x)) / x
double mean_decay(double x) { return x == 0 ? 1 : -std::expm1(-x) / x; }

// (exp(-a) - exp(-b)) / (b - a)
double decay_between(double a, double b) {
  return std::exp(-std::min(a, b)) * mean_decay(std::abs(a - b));
}

// Integrals over 0 < t, t' < 1 of exp(-a t') times exp(-b t) (reflected) or exp(-b (1 - t))
// (through), over t > t' (onward) and t < t' (back). The division by a or b loses digits at small
// values, so these stop at a floor: a relative error of 1e-5 of a term that is itself of the order
// of the layer's optical depth.
struct TwoEvents {
  double reflected_onward, reflected_back, through_onward, through_back;
};
TwoEvents two_events(double a, double b) {
  constexpr double kFloor = 1e-5;
  a = std::max(a, kFloor);
  b = std::max(b, kFloor);
  const double between = decay_between(a, b);
  return {(mean_decay(b) - mean_decay(a + b)) / a, (mean_decay(a) - mean_decay(a + b)) / b,
          (mean_decay(b) - between) / a, (between - std::exp(-b) * mean_decay(a)) / b};
}

VectorXd rates(const VectorXd& sigma, const VectorXd& mu) { return sigma.cwiseQuotient(mu); }

// The part of the kernel that sends light from a side back to it, and that which sends it on.
constexpr Part same(int side) { return side == 0 ? kAboveToUp : kBelowToDown; }
constexpr Part through(int side) { return side == 0 ? kAboveToDown : kBelowToUp; }

OperatorSide thin_side(const LayerScattering& s, int side, double thickness,
                       const OperatorRules& rules) {
  const DirectionSets& sets = rules.sets;
  const Parts& kernel = s.modes[rules.mode];
  const Index n = sets.nodes(), rows = sets.out.size(), columns = sets.in.size();
  // Light from side 0 goes down and meets sigma(+mu); what leaves through side 0 goes up and meets
  // sigma(-mu).
  const VectorXd a = thickness * rates(s.sigma_in[side], sets.in);
  const VectorXd b_back = thickness * rates(s.sigma_out[1 - side], sets.out);
  const VectorXd b_on = thickness * rates(s.sigma_out[side], sets.out);
  // Events along a unit of irradiance's path at the nodes, onward and back.
  VectorXd inner[2];
  for (const bool back : {false, true}) {
    const VectorXd depth =
        thickness * rates(s.sigma_in[back ? 1 - side : side].head(n), sets.in.head(n));
    inner[back] = sets.flux.cwiseQuotient(sets.in.head(n).cwiseAbs2());
    for (Index k = 0; k < n; ++k) inner[back][k] *= mean_decay(2 * depth[k] / 3);
  }
  const auto twice = [&](Part last, int back, Part first) {
    return MatrixXd(kernel[last].leftCols(n) * inner[back].asDiagonal() * kernel[first].topRows(n));
  };
  const MatrixXd r_onward = twice(same(side), 0, through(side));
  const MatrixXd r_back = twice(through(1 - side), 1, same(side));
  const MatrixXd t_onward = twice(through(side), 0, through(side));
  const MatrixXd t_back = twice(same(1 - side), 1, same(side));

  OperatorSide result;
  for (Series* series : {&result.r, &result.t}) series->fill(MatrixXd::Zero(rows, columns));
  for (Index j = 0; j < columns; ++j)
    for (Index i = 0; i < rows; ++i) {
      const double mi = sets.in[j], mo = sets.out[i];
      const double si = s.sigma_in[side][j], so = s.sigma_out[1 - side][i];
      const double x = a[j] + b_back[i];
      const double per = thickness / mi / mo;
      const double back = x < 1 ? per * mean_decay(x) : -std::expm1(-x) / (si * mo + so * mi);
      // Along directions that are asked for the layer may be opaque: then nothing crosses it, and
      // infinity times nothing is nothing. The kernel stays out of this.
      const auto share = [](double value) { return std::isfinite(value) ? value : 0; };
      const double on = share(per * decay_between(a[j], b_on[i]));
      result.r[1](i, j) = back * kernel[same(side)](i, j);
      result.t[1](i, j) = on * kernel[through(side)](i, j);
      const TwoEvents back2 = two_events(a[j], b_back[i]), on2 = two_events(a[j], b_on[i]);
      const double per2 = per * thickness;
      result.r[2](i, j) = share(per2 * back2.reflected_onward) * r_onward(i, j) +
                          share(per2 * back2.reflected_back) * r_back(i, j);
      result.t[2](i, j) = share(per2 * on2.through_onward) * t_onward(i, j) +
                          share(per2 * on2.through_back) * t_back(i, j);
    }
  result.r[0] = result.r[1] + result.r[2];
  result.t[0] = result.t[1] + result.t[2];
  if (rules.mode == 0) {
    result.absorbed = RowVectorXd(columns);
    const VectorXd later[2] = {inner[0].cwiseProduct(s.absorbing[side].head(n)),
                               inner[1].cwiseProduct(s.absorbing[1 - side].head(n))};
    const RowVectorXd onward = later[0].transpose() * kernel[through(side)].topRows(n);
    const RowVectorXd back = later[1].transpose() * kernel[same(side)].topRows(n);
    for (Index j = 0; j < columns; ++j) {
      const TwoEvents after = two_events(a[j], 0);
      const double per = thickness / sets.in[j];
      result.absorbed[j] =
          per * (mean_decay(a[j]) * s.absorbing[side][j] +
                 thickness * (after.reflected_onward * onward[j] + after.reflected_back * back[j]));
    }
  }
  return result;
}

}  // namespace

LayerOperator thin_layer(const LayerScattering& scattering, double thickness,
                         const OperatorRules& rules) {
  LayerOperator layer{thin_side(scattering, 0, thickness, rules),
                      thin_side(scattering, 1, thickness, rules)};
  set_direct(layer, scattering, thickness, rules.sets);
  return layer;
}

void set_direct(LayerOperator& layer, const LayerScattering& scattering, double thickness,
                const DirectionSets& sets) {
  const auto shares = [&](const VectorXd& sigma, const VectorXd& mu) {
    return VectorXd((-thickness * rates(sigma, mu).array()).exp());
  };
  layer.above.direct_in = shares(scattering.sigma_in[0], sets.in);
  layer.below.direct_in = shares(scattering.sigma_in[1], sets.in);
  layer.above.direct_out = shares(scattering.sigma_out[0], sets.out);
  layer.below.direct_out = shares(scattering.sigma_out[1], sets.out);
}

}  // namespace lamella
