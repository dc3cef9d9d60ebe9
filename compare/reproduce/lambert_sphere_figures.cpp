#include "compare/reproduce/lambert_sphere_figures.h"

namespace lamella {

std::vector<Reproduction> lambert_sphere_figures() {
  const auto source = [](const char* place) {
    return std::string("d'Eon 2021, Lambert-sphere BRDF, ") + place;
  };
  return {
      {"lambert_sphere_dilute",
       "a deep bed of Lambertian spheres approaches the Lambert-sphere medium and its BRDF as the "
       "volume fraction falls",
       source("figures 1 and 12"), 1000000, true, reproduce_lambert_sphere_dilute},
      {"lambert_sphere_figure_3",
       "Fourier modes of multiple scattering by the solver: how weak the second one is",
       source("figure 3"), 1, false, reproduce_lambert_sphere_figure_3},
      {"lambert_sphere_figure_4", "the constants l and m of mode 1 against their fits",
       source("figure 4"), 1, false, reproduce_lambert_sphere_figure_4},
      {"lambert_sphere_figure_5",
       "error of the fitted mode 0 over the albedo: against the exact three-term form and against "
       "the solver",
       source("figure 5"), 1, false, reproduce_lambert_sphere_figure_5},
      {"lambert_sphere_figure_6", "the constants B, C, D and F of mode 0 against their fits",
       source("figure 6"), 1, false, reproduce_lambert_sphere_figure_6},
      {"lambert_sphere_figure_7",
       "slices of the analytic form, the fast form and Hapke's against the solver",
       source("figure 7"), 1, false, reproduce_lambert_sphere_figure_7},
      {"lambert_sphere_figure_8",
       "spheres of the BRDF, of two height fields and of Chandrasekhar's medium under lamps from "
       "the front to the back",
       source("figure 8"), 60000, false, reproduce_lambert_sphere_figure_8},
      {"lambert_sphere_figure_10",
       "the BRDF beside Lambert, Oren-Nayar and Chandrasekhar, lit from the front and the back",
       source("figures 9 and 10"), 1, false, reproduce_lambert_sphere_figure_10},
      {"lambert_sphere_figure_11",
       "time and noise of the analytic form, a table by the solver and walks; Henyey-Greenstein of "
       "the same mean cosine",
       source("figure 11"), 20000, false, reproduce_lambert_sphere_figure_11},
      {"lambert_sphere_figure_12",
       "beds of spheres from dense to sparse: which height field, or the BRDF, comes nearest",
       source("figure 12"), 400000, true, reproduce_lambert_sphere_figure_12},
      {"lambert_sphere_figure_13",
       "a rough coat over Lambert's law, Lambert spheres (the medium and its BRDF) and "
       "Henyey-Greenstein: by the solver, by walks and by closed forms",
       source("figure 13"), 20000, false, reproduce_lambert_sphere_figure_13},
  };
}

}  // namespace lamella
