#pragma once

#include <Eigen/Core>
#include <memory>

#include "phase/stack/stack.h"

namespace lamella {

struct SecondKinds;
class SecondOrderPass;

/// Scattering of order 2 at a pair of directions, by quadrature over the direction w' in between:
///   f2 = 1 / (|mu_i| |mu_o|) integral dw' / |mu'| sum over layers j, k of
///        K_j(w_i, w') K_k(-w', w_o) I_jk(mu'),
/// I_jk the integral over the depths of both events of the three attenuations, in closed form
/// (volume/quadrature/depth_integrals.h). Mirror flakes' kernels jump at w' = -w_i and at w' = w_o,
/// and are steep nearby: in the azimuth, Gauss-Legendre in asinh about both; in mu', tanh-sinh
/// between 0 (where I changes its form), these two cosines and +-1, doubled until it stands still.
///
/// Between smooth boundaries light reaches the first event, the second and the way out along beams
/// that reflect and refract (volume/solver/stack_beams.h), and w' runs on through all reflections
/// until the second event: I_jk is then a sum over the ways up and down, and mu' ends at each
/// critical angle too.
///
/// Only events in media with a closed kernel count (volume/kernel/kernel_profiles.h): Lambertian
/// flakes and the substrate attenuate and absorb. No rough boundaries.
class SecondOrder {
 public:
  SecondOrder(const Stack& stack, int channel);

  struct Value {
    double f = 0;      ///< [1/sr]
    double error = 0;  ///< change under the last doubling
  };
  /// w_i, w_o: no mu = 0, see with_grazing_limit. tolerance: absolute [1/sr], of f.
  [[nodiscard]] Value operator()(Direction wi, Direction wo, double tolerance) const;

  /// Azimuthal modes of order 2 [1/sr]: f2 = sum over m of (2 - [m = 0]) f[m] cos(m x), x = pi -
  /// phi.
  struct Modes {
    Eigen::ArrayXd f;
    /// Of f2 at any x, from these modes: what the next doubling would change, were it to fall as
    /// under the last two, a hundredfold at most (tanh-sinh squares it). With interfaces: what the
    /// last doubling changed.
    double error = 0;
  };
  /// The first `count` modes for a pair of cosines, neither 0: the same integral with the kernels'
  /// modes. tolerance: absolute [1/sr], of the error.
  [[nodiscard]] Modes modes(double mu_i, double mu_o, int count, double tolerance) const;

  /// Whether any layer's medium counts.
  [[nodiscard]] bool is_empty() const;

 private:
  // Neither light nor order 2 between these sides.
  [[nodiscard]] bool is_dark(double mu_i, double mu_o) const;
  [[nodiscard]] std::unique_ptr<SecondOrderPass> pass(Direction wi, Direction wo) const;

  Stack stack_;
  std::shared_ptr<const SecondKinds> kinds_;
};

}  // namespace lamella
