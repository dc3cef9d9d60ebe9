#pragma once

#include <Eigen/Core>
#include <optional>

#include "volume/kernel/layer_scattering.h"

namespace lamella {

/// The exponentials that solve the equation of transfer of one azimuthal mode inside a homogeneous
/// layer that is the same from both sides. With D = diag(sqrt(2 pi w)), w the nodes' weights,
///   D L_down = sum over k of forward_k exp(-t / nu_k) + backward_k exp(-(T - t) / nu_k),
///   D L_up   = sum over k of backward_k exp(-t / nu_k) + forward_k exp(-(T - t) / nu_k).
/// Normalised so that an event at depth 0 of strength S (per depth, in D L's units) excites mode k
/// by forward_k . S_down + backward_k . S_up over nu_k.
struct LayerEigenmodes {
  Eigen::VectorXd nu;                 ///< depths over which the modes decay, > 0
  Eigen::MatrixXd forward, backward;  ///< rows: nodes, columns: modes
};

/// With M = diag(mu), A = sigma - D (K_on + K_back) D, B = sigma - D (K_on - K_back) D and their
/// Cholesky factors A = L L', B = N N': nu are the singular values of L^-1 M N^-T. That is the
/// eigenvalue problem turned upside down: nodes at grazing, however small mu is, cost no digits.
/// Nothing where A or B is not positive definite: one-sided flakes, mode 0 at albedo 1, nodes that
/// are too few for the kernel.
[[nodiscard]] std::optional<LayerEigenmodes> layer_eigenmodes(const LayerScattering& scattering,
                                                              int mode, const DirectionSets& sets);

/// The same without events: each node is a mode of its own that runs forward alone.
struct FreeFlights {
  Eigen::VectorXd nu;       ///< mu / sigma
  Eigen::VectorXd excited;  ///< D forward, a diagonal matrix
  FreeFlights(const LayerScattering& scattering, const DirectionSets& sets);
};

}  // namespace lamella
