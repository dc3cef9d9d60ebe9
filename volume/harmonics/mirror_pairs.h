#pragma once

#include <memory>

#include "phase/lanes/isa.h"
#include "phase/stack/stack.h"
#include "volume/harmonics/mirror_layers.h"

namespace lamella {

/// Light that mirror flakes scatter twice, at a pair of directions, by quadrature over the
/// direction w' in between, for axes that point anywhere:
///   f = 1 / (|mu_i| |mu_o|) integral dw' / |mu'| sum over layers j, k of
///       K_j(w_i, w') K_k(-w', w_o) I_jk(w'),
/// K(w_i, w_o) = albedo D(h) / 4 and I_jk the integral over the depths of both events of the three
/// attenuations (volume/quadrature/depth_integrals.h). On a circle of w' about an axis kernels and
/// projected areas are rational functions and roots of trigonometric polynomials, whose zeros in
/// the complex plane place the points (circle_points.h). The axis is that of the flakes, where all
/// mirrors share one: both kernels are then narrow across the circles, not along them. Circles are
/// cut at the horizon. Else it is the normal. In the cosine with the axis, rules of Gauss and
/// Kronrod are halved where they must, between the cosines where the kernels jump or peak, where
/// circles touch the horizon, and +-1; points crowd there like t^3.
///
/// Other media, and the substrate, attenuate and absorb. Interfaces are not known here.
class MirrorPairs {
 public:
  /// isa: of the sums over circles, whose last digits depend on it.
  explicit MirrorPairs(const Stack& stack, Isa isa = Isa::scalar,
                       MirrorCircles circles = MirrorCircles::automatic);
  ~MirrorPairs();
  MirrorPairs(MirrorPairs&&) noexcept;
  MirrorPairs& operator=(MirrorPairs&&) noexcept;

  [[nodiscard]] const MirrorLayers& layers() const { return *layers_; }
  /// Whether no layer has mirror flakes.
  [[nodiscard]] bool is_empty() const;

  struct Value {
    Rgb f;             ///< [1/sr]
    double error = 0;  ///< absolute [1/sr], of any channel
  };
  /// w_i, w_o: no mu = 0, see with_grazing_limit. tolerance: absolute [1/sr], of f.
  [[nodiscard]] Value operator()(Direction wi, Direction wo, double tolerance) const;

 private:
  std::unique_ptr<const MirrorLayers> layers_;
};

}  // namespace lamella
