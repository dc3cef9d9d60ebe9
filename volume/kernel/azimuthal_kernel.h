#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "phase/medium/medium.h"
#include "volume/quadrature/direction_sets.h"

namespace lamella {

/// Where light comes from and leaves to, for the four parts of a kernel or a layer's operator.
enum Part { kAboveToUp = 0, kAboveToDown = 1, kBelowToDown = 2, kBelowToUp = 3 };

/// Four matrices, by Part; rows: outgoing |mu|, columns: incoming |mu|.
using Parts = std::array<Eigen::MatrixXd, 4>;

/// Azimuthal modes of the kernel K(w_i, w_o) = sigma(w_i) p(w_i -> w_o) [1/sr], which reciprocity
/// makes symmetric, of a medium that is symmetric about z at albedo 1:
///   K = sum over m >= 0 of (2 - [m = 0]) K_m(mu_i, mu_o) cos(m x),  x = pi - phi,
/// phi the azimuth of w_o relative to w_i. Taking x instead of phi, a chain of events multiplies
/// its K_m without alternating signs.
struct KernelModes {
  std::vector<Parts> modes;  ///< with the Schlick factor
  Parts white;               ///< mode 0 without it
};

/// The modes 0 ... modes - 1 for every pair of an outgoing and an incoming |mu|. f0: Schlick's
/// reflectance of mirror flakes. Lambertian flakes by volume/kernel/lambert_flake_kernel.h. Mirror
/// flakes and particles by Gauss-Legendre quadrature in the azimuth, crowded as the nearest
/// singularity in the complex plane asks (volume/kernel/pair_modes.h); mirror flakes, whose kernel
/// jumps where w_o = -w_i, and particles with a narrow forward peak enter projected onto what the
/// nodes can represent (volume/kernel/forward_projection.h).
[[nodiscard]] KernelModes kernel_modes(const Medium& medium, double f0, const DirectionSets& sets,
                                       int modes);

/// The same of particles (sigma = 1) whose phase function is a Legendre series,
/// p = 1 / (4 pi) sum over l of terms[l] P_l(cosine of the deflection), terms[0] = 1. Series that
/// dip below 0 are taken as they are.
[[nodiscard]] KernelModes legendre_modes(std::span<const double> terms, const DirectionSets& sets,
                                         int modes);

/// Whether two media scatter alike: same kind, same numbers.
[[nodiscard]] bool is_same_medium(const Medium& a, const Medium& b);

/// Whether K(w_i, w_o) = K(-w_i, -w_o): particles and two-sided flakes.
[[nodiscard]] bool is_two_sided(const Medium& medium);

}  // namespace lamella
