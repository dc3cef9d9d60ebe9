#pragma once

namespace lamella {

/// The fits of d'Eon and Weidlich 2024, "VMF Diffuse", to the projected area of one-sided von
/// Mises-Fisher flakes, sigma(u) = integral of D(m) <w, m> dm, u = w.n in [-1, 1], dimensionless.
/// alpha >= 0: see phase/vmf.h, whose vmf_sigma is the exact value. Errors are absolute, measured
/// against that.

/// Eq. 4 with the sign of its exponent corrected to exp(-u^2 / (alpha^2 (1 - u^2))). For alpha in
/// [0, 0.25); error below 9.5e-4 from alpha = 0.02, at 0 exact. sigma(u) - sigma(-u) is exact up
/// to exp(-2 / alpha^2).
[[nodiscard]] double vmf_sigma_fit_smooth(double u, double alpha);

/// Eq. 5 as printed. For alpha in [0.25, 0.9); error below 0.024 (at alpha = 0.8, u = 1), negative
/// down to -0.006 near u = -1.
[[nodiscard]] double vmf_sigma_fit_middle(double u, double alpha);

/// Eq. 6, two terms beyond 1/4, written in coth(kappa) - 1 / kappa, kappa = 2 / alpha^2, so that
/// nothing cancels for large alpha. For alpha in [0.9, infinity]; error below 2.1e-3.
[[nodiscard]] double vmf_sigma_fit_rough(double u, double alpha);

/// The one of the three that its range asks for. Jumps at the joints by up to 6.7e-3 (alpha =
/// 0.25, which the paper leaves out and which is eq. 5's here) and 1.7e-2 (alpha = 0.9).
[[nodiscard]] double vmf_sigma_fit(double u, double alpha);

}  // namespace lamella
