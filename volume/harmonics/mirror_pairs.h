#pragma once

#include <memory>

#include "phase/lanes/isa.h"
#include "phase/stack/stack.h"

namespace lamella {

struct MirrorLayers;

/// Light that mirror flakes scatter twice, at a pair of directions, by quadrature over the
/// direction w' in between, for axes that point anywhere:
///   f = 1 / (|mu_i| |mu_o|) integral dw' / |mu'| sum over layers j, k of
///       K_j(w_i, w') K_k(-w', w_o) I_jk(w'),
/// K(w_i, w_o) = albedo D(h) / 4 and I_jk the integral over the depths of both events of the three
/// attenuations (volume/quadrature/depth_integrals.h). On a circle of constant mu' kernels and
/// projected areas are rational functions and roots of trigonometric polynomials, whose zeros in
/// the complex plane place the points (circle_points.h). In mu', rules of Gauss and Kronrod are
/// halved where they must, between 0, where I changes its form, -mu_i and mu_o, where the kernels
/// jump, and +-1; points crowd there like t^3.
///
/// Other media, and the substrate, attenuate and absorb. Interfaces are not known here.
class MirrorPairs {
 public:
  /// isa: of the sums over circles, whose last digits depend on it.
  explicit MirrorPairs(const Stack& stack, Isa isa = Isa::scalar);
  ~MirrorPairs();
  MirrorPairs(MirrorPairs&&) noexcept;
  MirrorPairs& operator=(MirrorPairs&&) noexcept;

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
