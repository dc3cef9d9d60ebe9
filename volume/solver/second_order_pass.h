#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/kernel/kernel_profiles.h"
#include "volume/solver/second_order_quadrature.h"

// The integrands of volume/solver/second_order.h; not for its users.

namespace lamella {

/// A kernel that layers share.
struct SecondKind {
  std::size_t layer;  ///< the first that has it
  double albedo, f0;
  double index;  ///< of refraction
};

struct SecondKinds {
  std::vector<SecondKind> kinds;
  std::vector<int> of_layer;  ///< -1: its medium does not count

  SecondKinds(const Stack& stack, int channel);
};

/// One pair of directions, as a function of the direction in between.
class SecondOrderPass {
 public:
  virtual ~SecondOrderPass() = default;
  /// The integral over the azimuth, without the common factor, at one cosine of w'.
  [[nodiscard]] virtual double at(const BetweenCosine& between) const = 0;
  /// Its first modes instead, over 2 pi.
  [[nodiscard]] virtual Eigen::ArrayXd modes_at(const BetweenCosine& between, int count) const = 0;

  std::vector<BetweenBreak> breaks;  ///< of the integrand, in its cosine
  double common = 1;                 ///< factor of the integral
  /// By how much a doubling of the points may be trusted to lower the error of modes.
  double fall = 1e-2;
};

/// Layers alone: the cosine in between is that of w', from -1 to 1.
[[nodiscard]] std::unique_ptr<SecondOrderPass> open_second_order(const Stack& stack,
                                                                 const SecondKinds& kinds,
                                                                 Direction wi, Direction wo);
/// Layers between smooth boundaries: the cosine in between is |mu'| in the densest medium that
/// scatters; light on its way up and down, and all internal reflections, are one integrand.
[[nodiscard]] std::unique_ptr<SecondOrderPass> bounded_second_order(const Stack& stack,
                                                                    const SecondKinds& kinds,
                                                                    Direction wi, Direction wo);

/// Azimuth of one peak of the two kernels relative to the other, in [0, pi].
[[nodiscard]] inline double peak_separation(Direction wi, Direction wo) {
  return kPi - std::abs(std::atan2(wi.x * wo.y - wi.y * wo.x, wi.x * wo.x + wi.y * wo.y));
}

/// How far in the azimuth the nearest singularity of a kernel is from its peak.
template <class P>
[[nodiscard]] double peak_distance(const P& profile, double mu_i, double mu_o, const Pair& pair) {
  return std::sqrt(profile.reach(mu_i, mu_o, pair.gap) / std::max(pair.product, 1e-300));
}

/// Values of a kernel at azimuths so far from its peak.
template <class P, class Column>
void fill_kernel(const P& profile, const SecondKind& kind, const Eigen::ArrayXd& chord2,
                 const Pair& pair, Column column) {
  for (Eigen::Index p = 0; p < chord2.size(); ++p) {
    const double hxy2 = pair.gap + pair.product * chord2[p];
    double value = profile.value(hxy2, pair.hz);
    if (kind.f0 != 1)
      value *= kind.f0 + (1 - kind.f0) * schlick_weight(std::sqrt(hxy2 + pair.hz * pair.hz) / 2);
    column[p] = kind.albedo * value;
  }
}

}  // namespace lamella
