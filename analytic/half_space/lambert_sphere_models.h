#pragma once

#include "analytic/half_space/three_term.h"
#include "analytic/half_space/three_term_constants.h"
#include "analytic/model/model.h"
#include "analytic/model/reflection_angles.h"

namespace lamella {

// A half space of opaque Lambertian spheres far apart (phase/medium/lambert_sphere.h), albedo c.
// d'Eon 2021, "An analytic BRDF for materials with spherical Lambertian scatterers"; equation
// numbers are his. phi = 0 is back scattering. All these models have the lobes `single`, exact
// single scattering, and `multiple`, the rest.

/// The analytic form, eqs. 18-45, with two corrections: the cos phi term of multiple scattering is
/// twice the one of eqs. 27, 34 and 35, and H1 is not that of eq. 28 (see lambert_sphere_h1).
/// Reciprocal. Against the exact three-term form: relative error below 0.073, rms 0.0041.
[[nodiscard]] ModelInfo lambert_sphere_model();

/// The fast form, eq. 48: absolute error below 0.11, rms 0.033, most of it at grazing pairs.
[[nodiscard]] ModelInfo lambert_sphere_fast_model();

/// Hapke's model without opposition effect: c / (4 pi (mu_i + mu_o)) (4 pi p + H H - 1) with the
/// isotropic H in his rational form. Absolute error below 0.17, rms 0.030. Hapke 1981,
/// "Bidirectional reflectance spectroscopy: 1".
[[nodiscard]] ModelInfo hapke_lambert_sphere_model();

/// The albedo with which the stack is a half space of Lambert spheres, as parameters; or nothing.
[[nodiscard]] std::optional<Parameters> lambert_sphere_parameters(const Stack& stack);

/// Exact single scattering for c = 1: p / (mu_i + mu_o) (eq. 17).
[[nodiscard]] double lambert_sphere_single(const ReflectionAngles& a);

/// Legendre coefficients A_k of the phase function, p = 1 / (4 pi) sum A_k P_k (eqs. 2-4). Spheres
/// average two clamped cosines over their normals, so A_k = (-1)^k (2k + 1) a_k^2, a_k = 2 *
/// integral over x in (0, 1) of x P_k(x).
[[nodiscard]] double lambert_sphere_legendre(int k);

/// The first three, times the albedo (eq. 15).
[[nodiscard]] ThreeTermPhase lambert_sphere_phase_terms(double albedo);

/// The constants of its exact half space, and those of the analytic form: A and E exact, B, C, D, F
/// fitted within 4.3e-3, 8.2e-4, 4.3e-4, 1.4e-3, l and m within 8.7e-5 and 1.8e-3. albedo in [0,
/// 1]; at 0 the exact ones are the limit, within 1e-7.
[[nodiscard]] ThreeTermConstants exact_lambert_sphere_constants(double albedo);
[[nodiscard]] ThreeTermConstants fitted_lambert_sphere_constants(double albedo);

/// Fitted H0 of the azimuthal mean, eq. 37, with its limit at c = 1: relative error below 0.0082.
[[nodiscard]] double lambert_sphere_h0(double mu, double albedo);

/// Fitted H1 of the first azimuthal mode: exp((0.0242851 c^2 - 0.144839 c) mu^E(mu)), E as in
/// eq. 29. Relative error below 0.0031; eq. 28 as printed is off by 0.11.
[[nodiscard]] double lambert_sphere_h1(double mu, double albedo);

/// Particle albedo c for the Bond albedo k_d of the half space, both in [0, 1] (eq. 46): absolute
/// error below 0.0063.
[[nodiscard]] double lambert_sphere_albedo(double bond_albedo);

/// Bond albedo k_d of the half space for the particle albedo c (eq. 47): absolute error below
/// 0.0020, largest at c = 0.
[[nodiscard]] double lambert_sphere_bond_albedo(double albedo);

}  // namespace lamella
