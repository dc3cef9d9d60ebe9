#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// One half space of vertical one-sided Lambertian von Mises-Fisher flakes, fitted by scattering
/// order:
///   f = c f_1 + c^2 f_2 + c^3 f_3 + f_m [1/sr]
/// c: albedo of the flakes; r: roughness in [0, 1], 0 is Lambert's surface, 1 Lambert spheres.
/// With modes in the azimuth, f_k = f_k^(0) + 2 f_k^(1) cos phi + 2 f_k^(2) cos 2 phi: the printed
/// f_k^(1), f_k^(2) are half of the cosine coefficients. Each lobe is clamped at 0, and r = 0 is
/// c / pi in f_1 alone. Reciprocal. Directional albedo of a white half space (which should be 1):
/// 0.89 to 1.14, the most at grazing. Relative rms error of f for c = 1 and cosines from 0.15 to
/// 0.9, at r = 0.1, 0.5 and 1: 0.023, 0.022, 0.048 (as printed 0.17, 0.15, 0.13). Where both
/// cosines are 0.02, off by up to 0.33 [1/sr]. Sampler: vmf_diffuse_sampler.h. Lobes f1, f2, f3,
/// fm: orders 1, 2, 3 and 4+. d'Eon and Weidlich 2024, "VMF Diffuse: A unified rough diffuse BRDF".
[[nodiscard]] ModelInfo vmf_diffuse_model();

/// VMF Diffuse with the formulas as printed, but for the sign in eq. 4, without which sigma is
/// unbounded: no factor 2, no clamp, no special case at r = 0.
[[nodiscard]] ModelInfo vmf_diffuse_printed_model();

/// Printed mode m (0, 1, 2) of f_k, k = order (1, 2, 3), for unit albedo, without its cosine.
/// u_i, u_o: cosines in (0, 1]. Section 3.3 and appendix A.
[[nodiscard]] double vmf_diffuse_mode(int order, int m, double roughness, double u_i, double u_o);

/// Printed f_m, eq. 9: not clamped.
[[nodiscard]] double vmf_diffuse_higher_orders(double albedo, double roughness, double u_i,
                                               double u_o);

/// The flake albedo c for which the diffuse albedo at normal incidence is about k_d in [0, 1]
/// (section 5). Rough: at r = 1 it returns 0.826 where 0.9 is exact.
[[nodiscard]] double vmf_diffuse_albedo(double k_d, double roughness);

}  // namespace lamella
