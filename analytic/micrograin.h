#pragma once

#include "analytic/model.h"

namespace lamella {

// A porous layer of opaque half ellipsoids on a surface: discs of radius 1 at random (Poisson),
// height beta. Lucas et al. 2023, "A Micrograin BSDF Model for the Rendering of Porous Layers";
// equation numbers are theirs. tau0: filling factor, the share of the surface under grains, in
// [0, 1). beta: anfractuosity in (0, 1]. mu: cosine with the normal, in (0, 1].
// lambda = -log(1 - tau0) is the number of grains per area of a disc.

/// f = w f_S + (1 - w) f_B (eq. 1), w the weight of eq. 24, f_B = bulk_albedo / pi.
/// Lambertian grains: f_S = albedo / pi. Conductors: f_S = D(h) G F / (4 mu_i mu_o) (eq. 2), F
/// Schlick's factor of f0, G = 1 / (1 + Lambda_i + Lambda_o) with either Lambda of
/// micrograin_projected_area. Reciprocal. Lobes `grains` and `bulk`.
/// Left out, because the supplement that defines it is not at hand: the dielectric grain (its
/// integrated transmittance) and the series of eq. 25, for which quadrature stands in.
[[nodiscard]] ModelInfo micrograin_model();

/// Where the projected area of the grains' normals is from.
enum class MicrograinShadowing {
  ggx,   ///< GGX of the equivalent roughness (the paper's alternative): its Smith G_1 is off by up
         ///< to 0.10
  smith  ///< the exact one of D, by quadrature
};

/// Distribution of the grains' normals D [1/sr], its integral times the cosine 1:
///   D = lambda / tau0 beta^2 / (pi q^2) exp(-lambda sin^2 / q), q = beta^2 cos^2 + sin^2,
/// which is GGX of roughness beta in the limit tau0 = 0 (eqs. 16, 17).
[[nodiscard]] double micrograin_ndf(double mu, double tau0, double beta);

/// Probability that a normal's cosine is at least mu (eq. 19).
[[nodiscard]] double micrograin_ndf_cdf(double mu, double tau0, double beta);

/// Cosine of a normal from a uniform xi in [0, 1): the inverse of micrograin_ndf_cdf (eq. 20 with
/// the sign of its radicand corrected).
[[nodiscard]] double micrograin_ndf_sample(double xi, double tau0, double beta);

/// Roughness of the GGX that equals D at the normal: beta sqrt(tau0 / lambda) (eq. 18).
[[nodiscard]] double micrograin_equivalent_roughness(double tau0, double beta);

/// Filling factor seen from mu by whole ellipsoids: 1 - (1 - tau0)^(gamma / mu) with
/// gamma / mu = sqrt(1 + beta^2 tan^2) (eq. 21).
[[nodiscard]] double micrograin_tau(double mu, double tau0, double beta);

/// Visible filling factor, of the upper halves: 1 - sqrt((1 - tau)(1 - tau0)) (eq. 22).
[[nodiscard]] double micrograin_tau_plus(double mu, double tau0, double beta);

/// Share of the light paths that meet grains, 1 - sqrt((1 - tau_i)(1 - tau_o)) (eq. 24). Exact for
/// opposite azimuths only: for equal ones it is max(tau_plus_i, tau_plus_o).
[[nodiscard]] double micrograin_weight(double mu_i, double mu_o, double tau0, double beta);

/// (1 + Lambda(mu)) mu = integral of D(m) <w, m> dm, in [mu, ...). smith: relative error below
/// 1e-9.
[[nodiscard]] double micrograin_projected_area(double mu, double tau0, double beta,
                                               MicrograinShadowing shadowing);

}  // namespace lamella
