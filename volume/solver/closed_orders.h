#pragma once

#include "phase/stack/stack.h"

namespace lamella {

/// What is known of f in closed form at a pair of directions; the solver's modes have the rest.
struct ClosedOrders {
  Rgb zero;  ///< of order 0: one event at a rough boundary that beams reach, from either side
  Rgb one;   ///< order 1, unless a boundary is rough (is_first_closed)

  [[nodiscard]] Rgb all() const { return zero + one; }
};

/// Whether order 1 is closed: beams reach every event, and leave from it, by Snell's law alone.
[[nodiscard]] bool is_first_closed(const Stack& stack);

/// Without boundaries order 1 is that of phase/stack/single_scattering.h. With smooth ones the beam
/// arrives in each layer from above and from below, and leaves it both ways, with what Fresnel's
/// shares sum to between all boundaries; each of the four ways has the closed integral over depth
/// (volume/quadrature/depth_integrals.h). Radiance carries n^2. Deltas are left out. w_i, w_o as in
/// single_scattering.
[[nodiscard]] ClosedOrders closed_orders(const Stack& stack, Direction wi, Direction wo);

/// The share of light from w_i, above, that leaves along its mirror image as a delta: it has met
/// smooth boundaries and a smooth conductor alone, and no scatterer (delta flakes apart). 0 without
/// boundaries.
[[nodiscard]] Rgb mirrored_share(const Stack& stack, Direction wi);

}  // namespace lamella
