#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "phase/medium/medium.h"
#include "volume/harmonics/harmonic_turn.h"
#include "volume/harmonics/triaxial_kernel.h"

namespace lamella {

/// How a medium of albedo 1 turns radiance into its source function, in spherical harmonics: the
/// integral of sigma(-v) p(-v -> w) L(v) over v, both along the light's way. Exact in the degrees
/// that there are. Particles: diagonal. Flakes with an axis of symmetry: about it one block per m;
/// others: triaxial_kernel.h.
class HarmonicKernel {
 public:
  /// f0: Schlick's, of mirror flakes. Throws std::invalid_argument where why_no_harmonics tells
  /// why.
  HarmonicKernel(const Medium& medium, double f0, const HarmonicBasis& basis,
                 MatrixProduct product = MatrixProduct());

  /// Columns: functions on the sphere, in the slab's frame.
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::MatrixXd& radiance) const;

  /// Bytes of one: of what it holds.
  [[nodiscard]] static std::size_t bytes(const Medium& medium, const HarmonicBasis& basis);

 private:
  HarmonicBasis basis_;
  MatrixProduct product_;
  Eigen::VectorXd by_degree_;          // of particles
  std::vector<Eigen::MatrixXd> by_m_;  // of flakes
  std::optional<HarmonicTurn> turn_;   // to their axis, unless it is z
  std::optional<TriaxialKernel> triaxial_;
};

/// Why a medium's kernel has no such expansion, if it has none: deltas.
[[nodiscard]] std::optional<std::string> why_no_harmonics(const Medium& medium);

}  // namespace lamella
