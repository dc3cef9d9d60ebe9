#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace lamella {

/// Where light comes from and leaves to, for the four parts of a kernel or a layer's operator.
enum Part { kAboveToUp = 0, kAboveToDown = 1, kBelowToDown = 2, kBelowToUp = 3 };

/// Four matrices, by Part; rows: outgoing |mu|, columns: incoming |mu|.
using Parts = std::array<Eigen::MatrixXd, 4>;

/// Azimuthal modes of the kernel K(w_i, w_o) = sigma(w_i) p(w_i -> w_o) [1/sr], which reciprocity
/// makes symmetric, of a medium that is symmetric about z at albedo 1:
///   K = sum over m >= 0 of (2 - [m = 0]) K_m(mu_i, mu_o) cos(m x),  x = pi - phi,
/// phi the azimuth of w_o relative to w_i. In x, unlike phi, the modes of a chain of events are
/// products of its K_m without alternating signs.
struct KernelModes {
  std::vector<Parts> modes;  ///< with the Schlick factor
  Parts white;               ///< mode 0 without it
};

}  // namespace lamella
