#include "volume/kernel/layer_scattering.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd projected_areas(const Medium& medium, const VectorXd& mu, double sign) {
  return mu.unaryExpr([&](double m) {
    return sigma(medium, {std::sqrt((1 - m) * (1 + m)), 0, sign * m});
  });
}

// The part for light from side `in` (0 above, 1 below) that leaves up (0) or down (1).
constexpr int part_of(int in, int out) {
  return in == 0 ? (out == 0 ? kAboveToUp : kAboveToDown) : (out == 0 ? kBelowToUp : kBelowToDown);
}

// Below this share of the largest projected area, rows are left alone: such light hardly meets
// anything, and its row is rounding noise.
constexpr double kNegligibleArea = 1e-11;

double factor(double area, double sum, double largest) {
  return area > kNegligibleArea * largest && sum > 0 ? area / sum : 1;
}

}  // namespace

LayerScattering::LayerScattering(const Medium& medium, double albedo, double f0,
                                 const DirectionSets& sets, int mode_count,
                                 const MatrixProduct& product)
    : two_sided(traits(medium).two_sided) {
  for (const int side : {0, 1}) {
    sigma_in[side] = projected_areas(medium, sets.in, side == 0 ? 1 : -1);
    sigma_out[side] = projected_areas(medium, sets.out, side == 0 ? 1 : -1);
  }
  conserve_energy(kernel_modes(medium, f0, sets, mode_count, product), albedo, f0, sets);
}

LayerScattering::LayerScattering(KernelModes kernel, double albedo, const DirectionSets& sets) {
  for (const int side : {0, 1}) {
    sigma_in[side] = VectorXd::Ones(sets.in.size());
    sigma_out[side] = VectorXd::Ones(sets.out.size());
  }
  conserve_energy(std::move(kernel), albedo, 1, sets);
}

void LayerScattering::conserve_energy(KernelModes kernel, double albedo, double f0,
                                      const DirectionSets& sets) {
  const Index n = sets.nodes();
  const VectorXd solid_angle = 2 * kPi * sets.weight;

  // d at the nodes, by direction label: + (facing up) and -. An outgoing direction going up has the
  // label +, light from above has the label +.
  VectorXd d[2] = {VectorXd::Ones(n), VectorXd::Ones(n)};
  double largest = 0;
  for (const VectorXd& area : sigma_in) largest = std::max(largest, area.head(n).maxCoeff());
  const auto white_sum = [&](int side) {
    VectorXd sum = VectorXd::Zero(sets.in.size());
    for (const int out : {0, 1})
      sum += kernel.white[part_of(side, out)].topRows(n).transpose() *
             solid_angle.cwiseProduct(d[out]);
    return sum;
  };
  for (int step = 0; step < 200; ++step) {
    const VectorXd sums[2] = {white_sum(0), white_sum(1)};
    double change = 0;
    for (const int side : {0, 1})
      for (Index j = 0; j < n; ++j) {
        const double f = factor(sigma_in[side][j], d[side][j] * sums[side][j], largest);
        change = std::max(change, std::abs(f - 1));
        d[side][j] *= std::sqrt(f);
      }
    if (change < 1e-15) break;
  }
  VectorXd d_in[2], d_out[2];
  for (const int side : {0, 1}) {
    correction = std::max(correction, (d[side].array() - 1).abs().maxCoeff());
    const VectorXd sum = white_sum(side);
    d_in[side] = VectorXd(sets.in.size());
    for (Index j = 0; j < sets.in.size(); ++j)
      d_in[side][j] = j < n ? d[side][j] : factor(sigma_in[side][j], sum[j], largest);
    // Outgoing directions: the same sum by symmetry, over what light from the label + or - does.
    VectorXd out_sum = VectorXd::Zero(sets.out.size());
    for (const int from : {0, 1})
      out_sum += kernel.white[part_of(from, side)].leftCols(n) * solid_angle.cwiseProduct(d[from]);
    d_out[side] = VectorXd(sets.out.size());
    for (Index i = 0; i < sets.out.size(); ++i)
      d_out[side][i] = i < n ? d[side][i] : factor(sigma_out[side][i], out_sum[i], largest);
  }
  const auto scale = [&](Parts& parts, double by) {
    for (const int in : {0, 1})
      for (const int out : {0, 1}) {
        Eigen::MatrixXd& part = parts[part_of(in, out)];
        part = (by * d_out[out]).asDiagonal() * part * d_in[in].asDiagonal();
      }
  };
  scale(kernel.white, 1);
  for (Parts& mode : kernel.modes) scale(mode, 1);
  for (const int side : {0, 1}) {
    // Where the row was left alone, what it scatters is its extinction.
    VectorXd white = VectorXd::Zero(sets.in.size()), lost = white;
    for (const int out : {0, 1}) {
      const int part = part_of(side, out);
      white += kernel.white[part].topRows(n).transpose() * solid_angle;
      if (f0 != 1)
        lost += (kernel.white[part] - kernel.modes[0][part]).topRows(n).transpose() * solid_angle;
    }
    for (Index j = 0; j < sets.in.size(); ++j)
      if (sigma_in[side][j] <= kNegligibleArea * largest)
        sigma_in[side][j] = std::max(0., white[j]);
    absorbing[side] = (1 - albedo) * sigma_in[side] + albedo * lost;
  }
  for (Parts& mode : kernel.modes)
    for (Eigen::MatrixXd& part : mode) part *= albedo;
  modes = std::move(kernel.modes);
}

}  // namespace lamella
