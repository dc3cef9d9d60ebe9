#pragma once

#include <vector>

#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

/// Reflection without a preferred azimuth, tabulated in coordinates in which a lobe varies slowly
/// whether it is wide or narrow: mu_o, and the half vector h = (w_i + w_o) / |w_i + w_o| by its
/// polar angle alpha and its azimuth beta relative to w_o. A mirror's lobe of any roughness lies
/// about alpha = 0 for every w_o (Rusinkiewicz 1998, "A new change of variables for efficient BRDF
/// representation"), so that interpolation between two w_o moves the lobe instead of blending two.
///
/// alpha runs from 0 to alpha_max(mu_o, beta), where w_i reaches the horizon: the table has no
/// corner without a direction. Its nodes crowd like t^3 at 0, where the first eight of them lie
/// within 0.02 radians and so resolve a lobe of roughness 0.02, and like (1 - t)^2 at the horizon.
/// Linear between nodes: no stated error.
class HalfVectorGrid {
 public:
  static constexpr int kOut = 24, kAlpha = 32, kBeta = 25;
  static constexpr double kLeastMu = 0.01;

  HalfVectorGrid() : values_(static_cast<std::size_t>(kOut) * kAlpha * kBeta) {}

  /// mu_o of a node, from 1 (k = 0) to kLeastMu (k = kOut - 1); k may lie between two nodes.
  [[nodiscard]] static double node_mu(double k);
  /// w_i of a node for w_o = (sqrt(1 - mu_o^2), 0, mu_o), not below kLeastMu.
  [[nodiscard]] static Direction node_wi(double mu_o, int alpha, int beta);

  [[nodiscard]] Rgb& at(int out, int alpha, int beta) {
    return values_[(static_cast<std::size_t>(out) * kAlpha + alpha) * kBeta + beta];
  }
  [[nodiscard]] Rgb at(int out, int alpha, int beta) const {
    return values_[(static_cast<std::size_t>(out) * kAlpha + alpha) * kBeta + beta];
  }

  /// f at unit directions with cosines of at least kLeastMu.
  [[nodiscard]] Rgb operator()(Direction wi, Direction wo) const { return towards(wo)(wi); }

  /// f of one w_o: two nodes in mu_o are blended once, for many w_i.
  class Slice {
   public:
    [[nodiscard]] Rgb operator()(Direction wi) const;

   private:
    friend class HalfVectorGrid;
    Direction wo_{};
    double across_ = 0;  // sine of w_o's angle
    std::vector<Rgb> values_{};
  };
  [[nodiscard]] Slice towards(Direction wo) const;

  /// A place among nodes in mu_o, from 0 to kOut - 1: the inverse of node_mu.
  [[nodiscard]] static double place_of_mu(double mu_o);

 private:
  std::vector<Rgb> values_;
};

/// The unit direction that w is mirrored to by a facet with unit normal h.
[[nodiscard]] inline Direction mirrored(Direction w, Direction h) { return 2 * dot(w, h) * h - w; }

/// w as it is, or raised to the cosine `least` at the same azimuth.
[[nodiscard]] Direction raised_to(Direction w, double least);

}  // namespace lamella
