#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "phase/medium.h"

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

/// The modes 0 ... modes - 1 for every pair of an outgoing and an incoming |mu|. Mirror flakes and
/// particles by Gauss-Legendre quadrature in the azimuth, crowded where the two directions are
/// opposite as the nearest singularity in the complex plane asks; Lambertian flakes through
///   K_m = 2 integral of D(v) c_m(mu_i, v) c_m(mu_o, v) dv,  v = m.z,
/// c_m the closed modes of a clamped cosine <w, m>. f0: Schlick's reflectance of mirror flakes.
[[nodiscard]] KernelModes kernel_modes(const Medium& medium, double f0, const Eigen::VectorXd& out,
                                       const Eigen::VectorXd& in, int modes);

/// Whether two media scatter alike: same kind, same numbers.
[[nodiscard]] bool is_same_medium(const Medium& a, const Medium& b);

/// Whether K(w_i, w_o) = K(-w_i, -w_o): particles and two-sided flakes.
[[nodiscard]] bool is_two_sided(const Medium& medium);

}  // namespace lamella
