#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/harmonics/harmonic_basis.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {

/// Panels on [0, pi] that shrink towards places where a function is narrow, with as many points as
/// products of two harmonics of a degree need besides. width: over which it changes there.
[[nodiscard]] Quadrature flake_angles(const std::vector<double>& places, double width, int degree);

/// By degree, Funk and Hecke's factors of the clamped cosine.
[[nodiscard]] Eigen::VectorXd clamped_cosine_factors(const HarmonicBasis& basis);

/// What a mirror whose normal is z makes of harmonics, by m: half a turn, weighted with the clamped
/// cosine and Schlick's factor.
[[nodiscard]] std::vector<Eigen::MatrixXd> one_mirror(double f0, const HarmonicBasis& basis);

}  // namespace lamella
