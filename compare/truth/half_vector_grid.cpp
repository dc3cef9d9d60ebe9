#include "compare/truth/half_vector_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lamella {
namespace {

using Grid = HalfVectorGrid;

// Steps in the angle of w_o shrink towards grazing: theta = theta_max (1 - (1 - t)^kCrowding).
constexpr double kCrowding = 1.5;
const double kMostTheta = std::acos(Grid::kLeastMu);

// alpha / alpha_max of the nodes: t^3 (4 - 3 t), steepest at t = 2/3.
const std::array<double, Grid::kAlpha>& alpha_nodes() {
  static const auto nodes = [] {
    std::array<double, Grid::kAlpha> u;
    for (int k = 0; k < Grid::kAlpha; ++k) {
      const double t = static_cast<double>(k) / (Grid::kAlpha - 1);
      u[k] = t * t * t * (4 - 3 * t);
    }
    return u;
  }();
  return nodes;
}

// The tilt of h at which w_i reaches the horizon: mu_i = 2 (w_o . h) h.z - mu_o = 0.
double most_alpha(double mu_o, double cos_beta) {
  const double sine = std::sqrt(std::max(1 - mu_o * mu_o, 0.0));
  return std::atan2(mu_o, -sine * cos_beta) / 2;
}

struct Between {
  int node;
  double fraction;
};

Between between(double place, int nodes) {
  const int node = std::clamp(static_cast<int>(place), 0, nodes - 2);
  return {node, std::clamp(place - node, 0.0, 1.0)};
}

}  // namespace

double HalfVectorGrid::node_mu(double k) {
  if (k == kOut - 1) return kLeastMu;
  return std::cos(kMostTheta * (1 - std::pow(1 - k / (kOut - 1), kCrowding)));
}

double HalfVectorGrid::place_of_mu(double mu_o) {
  const double theta = std::acos(std::clamp(mu_o, kLeastMu, 1.0));
  const double left = std::clamp(1 - theta / kMostTheta, 0.0, 1.0);
  return (kOut - 1) * (1 - std::cbrt(left * left));
}

Direction HalfVectorGrid::node_wi(double mu_o, int alpha, int beta) {
  const double b = kPi * beta / (kBeta - 1);
  const double a = most_alpha(mu_o, std::cos(b)) * alpha_nodes()[alpha];
  const Direction wo = direction_from_mu_phi(mu_o, 0);
  const Direction h{std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)};
  return raised_to(mirrored(wo, h), kLeastMu);
}

HalfVectorGrid::Slice HalfVectorGrid::towards(Direction wo) const {
  Slice slice;
  slice.wo_ = wo;
  slice.across_ = std::hypot(wo.x, wo.y);
  const Between o = between(place_of_mu(wo.z), kOut);
  constexpr std::size_t kCount = static_cast<std::size_t>(kAlpha) * kBeta;
  const Rgb* near = values_.data() + static_cast<std::size_t>(o.node) * kCount;
  slice.values_.resize(kCount);
  for (std::size_t k = 0; k < kCount; ++k)
    slice.values_[k] = (1 - o.fraction) * near[k] + o.fraction * near[kCount + k];
  return slice;
}

Rgb HalfVectorGrid::Slice::operator()(Direction wi) const {
  const Direction h = wi + wo_;
  const double in_plane = std::hypot(h.x, h.y);
  // Where w_o is the normal every azimuth is the same; where h is, beta has no meaning.
  const double cos_beta =
      in_plane > 0 && across_ > 0
          ? std::clamp((h.x * wo_.x + h.y * wo_.y) / (in_plane * across_), -1.0, 1.0)
          : 1;
  const double share = std::atan2(in_plane, h.z) / most_alpha(wo_.z, cos_beta);
  const auto& u = alpha_nodes();
  const auto above = std::upper_bound(u.begin() + 1, u.end() - 1, share) - u.begin();
  const Between a{static_cast<int>(above) - 1,
                  std::clamp((share - u[above - 1]) / (u[above] - u[above - 1]), 0.0, 1.0)};
  const Between b = between(std::acos(cos_beta) / kPi * (kBeta - 1), kBeta);
  const auto at = [&](int alpha, int beta) {
    return values_[static_cast<std::size_t>(alpha) * kBeta + static_cast<std::size_t>(beta)];
  };
  return (1 - a.fraction) *
             ((1 - b.fraction) * at(a.node, b.node) + b.fraction * at(a.node, b.node + 1)) +
         a.fraction *
             ((1 - b.fraction) * at(a.node + 1, b.node) + b.fraction * at(a.node + 1, b.node + 1));
}

Direction raised_to(Direction w, double least) {
  return w.z >= least ? w : direction_from_mu_phi(least, azimuth(w));
}

}  // namespace lamella
