#pragma once

#include <span>

#include "phase/stack/stack.h"

namespace lamella {

/// Optical depth of a layer along a direction with projected area s and |cosine| m; 0 for an empty
/// layer even where the cosine is at its limit.
[[nodiscard]] inline double optical_depth(double depth, double s, double m) {
  return s == 0 || depth == 0 ? 0 : depth * s / m;
}

/// The two parts of single scattering [1/sr].
struct SingleScattering {
  Rgb layers;     ///< one event in one of the layers
  Rgb substrate;  ///< one reflection from the substrate, attenuated by the layers
};

/// Exact single scattering of any stack, from either side, reflection and transmission:
///   sum over layers of rho sigma(w_i) a p(w_i -> w_o) / (|mu_i| |mu_o|) times the integral over
///   depth of exp(-tau_i - tau_o), tau_i built from sigma(w_i), tau_o from sigma(-w_o);
///   plus f_sub exp(-tau_i - tau_o) through all layers.
/// w_i, w_o: unit, point away from the stack; mu = 0 is the limit from above, at most one of the
/// two. Wang et al. 2022, "SpongeCake", eqs. 8-16 for any medium and side. Delta transmission and
/// the mirror image of delta flakes are not included. Relative error below 1e-12, where p is a
/// closed form, for depths from 0 to infinity.
[[nodiscard]] SingleScattering single_scattering(const Stack& stack, Direction wi, Direction wo);

/// What one event in a layer gives at albedo 1 [1/sr]: of flakes without a Fresnel factor (f0 = 1),
/// and the part that is left at f0 = 0. At albedo a and f0: a (f0 full + (1 - f0) edge).
struct LayerSingle {
  double full = 0, edge = 0;
};
/// The layers' parts of single_scattering apart, into `layers`, one per layer of the stack.
void single_scattering_by_layer(const Stack& stack, Direction wi, Direction wo,
                                std::span<LayerSingle> layers);

/// The layers' parts of single_scattering at albedo 1 without their phase functions p(w_i -> w_o),
/// into `layers`, one per layer of the stack [dimensionless]. Returns the share of the light that
/// passes all layers on the way down and up again; 0 of transmission.
double single_scattering_transport(const Stack& stack, Direction wi, Direction wo,
                                   std::span<double> layers);

}  // namespace lamella
