#pragma once

#include <span>

#include "phase/medium/medium.h"
#include "volume/algebra/matrix_product.h"
#include "volume/kernel/kernel_modes.h"
#include "volume/quadrature/direction_sets.h"

namespace lamella {

/// The modes 0 ... modes - 1 for every pair of an outgoing and an incoming |mu|. f0: Schlick's
/// reflectance of mirror flakes. Lambertian flakes by volume/kernel/lambert_flake_kernel.h. Mirror
/// flakes and particles by Gauss-Legendre quadrature in the azimuth, crowded as the nearest
/// singularity in the complex plane asks (volume/kernel/pair_modes.h); mirror flakes, whose kernel
/// jumps where w_o = -w_i, and particles with a narrow forward peak enter projected onto what the
/// nodes can represent (volume/kernel/forward_projection.h).
[[nodiscard]] KernelModes kernel_modes(const Medium& medium, double f0, const DirectionSets& sets,
                                       int modes, const MatrixProduct& product = MatrixProduct());

/// The modes of particles (sigma = 1) whose phase function is a Legendre series, p = 1 / (4 pi) sum
/// over l of terms[l] P_l(cosine of the deflection), terms[0] = 1. Series that dip below 0 are
/// taken as they are.
[[nodiscard]] KernelModes legendre_modes(std::span<const double> terms, const DirectionSets& sets,
                                         int modes);

}  // namespace lamella
