#pragma once

#include "analytic/model/model.h"
#include "phase/random/random.h"

namespace lamella {

// A porous layer of opaque half ellipsoids on a surface: discs of radius 1 at random (Poisson),
// height beta. Lucas et al. 2023, "A Micrograin BSDF Model for the Rendering of Porous Layers";
// equation numbers are theirs. tau0: filling factor, the share of the surface under grains, in
// [0, 1). beta: anfractuosity in (0, 1]. mu: cosine with the normal, in (0, 1].
// lambda = -log(1 - tau0) is the number of grains per area of a disc.

/// f = w f_S + (1 - w) f_B (eq. 1), w the weight of eq. 24, f_B any closed form here (`bulk`, its
/// keys with `bulk_` before them).
/// Lambertian grains: f_S = albedo / pi. Conductors: f_S = D(h) G F / (4 mu_i mu_o) (eq. 2), F
/// Schlick's factor of f0, G = 1 / (1 + Lambda_i + Lambda_o) with a Lambda of
/// micrograin_projected_area. Dielectric grains: the same with Fresnel's F of `ior`, over a
/// Lambertian base: f_S = D G F / (4 mu_i mu_o) + albedo / pi T(mu_i, mu_o),
///   T = (1 - E_i) (1 - E_o) / (1 - <E>),
/// E the specular part's directional albedo and <E> its average. The supplement that defines the
/// paper's own T is not at hand; this T keeps the energy of white grains at 1 and is reciprocal
/// (Kelemen and Szirmay-Kalos 2001; EON's eq. 17). Reciprocal if the bulk is. Lobes `grains` and
/// `bulk`. Specular grains are sampled by their visible normals, or, with normals=all, by eq. 20.
/// Over a bulk that transmits (glass): grains stand above it alone, so what passes is f_B times the
/// share of the bulk that the direction above sees, 1 - tau_plus (eq. 22), which is exact for what
/// meets the bulk once and no grain. From below, f = (1 - tau0) f_B + tau0 / pi times the grains'
/// albedo (f0 of conductors): their bases, which the paper leaves open, are Lambertian here. The
/// weight w counts grains that light would meet on its way up, of light that the bulk has let pass
/// as well: white grains over glass gain by what w exceeds tau_plus, up to 10 % (analytic/README.md
/// has the command).
/// `models`: those that may lie below, but for the ones that are built from a stack. The parameter
/// `bulk` names one; it selects that one's own parameters.
[[nodiscard]] ModelInfo micrograin_model(const std::vector<ModelInfo>& models);

/// Where the projected area of the grains' normals is from.
enum class MicrograinShadowing {
  ggx,    ///< GGX of the equivalent roughness (the paper's alternative): its Smith G_1 is off by up
          ///< to 0.10
  smith,  ///< the exact one of D: the series of eq. 25, as many terms as double precision takes
  series  ///< the same up to n = `terms`
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

/// (1 + Lambda(mu)) mu = integral of D(m) <w, m> dm, in [mu, ...). Lambda is the series of eq. 25,
///   Lambda = lambda / (2 (e^lambda - 1) cot) sum over n of lambda^n F_n(beta, cot),
/// whose F_n, defined in a supplement that is not at hand, were derived anew: with tan theta_m =
/// beta tan psi the normals become those of a hemisphere with density exp(-lambda sin^2 psi), which
/// is expanded about the pole, and the lune that faces away from w is integrated term by term:
///   F_n = 2 R / (pi n!) B_n J_n, R = sqrt(beta^2 + cot^2), B_n = sqrt(pi) Gamma(n + 3/2) / (n +
///   1)!, J_n = integral over a in (0, A) of sin^2n(a) sin(A - a), cos A = cot / R.
/// smith: relative error below 1e-12. The first five terms (n = 4) keep G_1 within 0.026 for tau0
/// up to 0.98.
[[nodiscard]] double micrograin_projected_area(double mu, double tau0, double beta,
                                               MicrograinShadowing shadowing, int terms = 4);

/// A normal with density D(m) <w, m> / projected area [1/sr]. w: unit, mu >= 0. A visible normal of
/// the isolated ellipsoid (Heitz 2018, "Sampling the GGX distribution of visible normals") is kept
/// with probability exp(-lambda sin^2 psi), the factor of D beyond GGX.
[[nodiscard]] Direction micrograin_visible_normal(Direction w, double tau0, double beta,
                                                  RandomStream& stream);

}  // namespace lamella
