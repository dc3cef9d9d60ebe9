#include "compare/reproduce/eon_figures.h"

namespace lamella {

std::vector<Reproduction> eon_figures() {
  const auto source = [](const char* place) {
    return std::string("Portsmouth, Kutz and Hill 2025, EON, ") + place;
  };
  return {
      {"eon_figure_1",
       "Lambert, the qualitative Oren-Nayar model and EON, lit from the front and from the side: "
       "brightness, flatness, back scattering",
       source("figures 1 and 2"), 1, false, reproduce_eon_figure_1},
      {"eon_figure_3",
       "slices of all Oren-Nayar models at albedo 0.8 and half the roughness, and how far each is "
       "from the full model",
       source("figure 3"), 1, false, reproduce_eon_figure_3},
      {"eon_figure_4", "spheres of Lambert and of all Oren-Nayar models", source("figure 4"), 1,
       false, reproduce_eon_figure_4},
      {"eon_figure_5", "the qualitative model at sigma = pi / 2: lamp, furnace, the dark ring",
       source("figure 5"), 1, false, reproduce_eon_figure_5},
      {"eon_figure_6",
       "albedos of the qualitative model, directional and average: closed form against quadrature",
       source("figure 6"), 1, false, reproduce_eon_figure_6},
      {"eon_figure_7",
       "albedos of FON, directional and average: closed form against quadrature; the fit's error",
       source("figure 7"), 1, false, reproduce_eon_figure_7},
      {"eon_figure_8", "FON at r = 1: lamp, furnace, the dark ring", source("figure 8"), 1, false,
       reproduce_eon_figure_8},
      {"eon_figure_9", "EON at r = 1: lamp, furnace, the dark ring", source("figure 9"), 1, false,
       reproduce_eon_figure_9},
      {"eon_figure_10", "EON's single and multiple scattering beside the qualitative model",
       source("figure 10"), 1, false, reproduce_eon_figure_10},
      {"eon_figure_11",
       "variance, largest and mean weight of EON's samplers over the angle, one with d = 0 fitted "
       "here",
       source("figure 11"), 3000000, false, reproduce_eon_figure_11},
      {"eon_figure_13", "variance and largest weight of EON's sampler over the roughness",
       source("figure 13"), 3000000, false, reproduce_eon_figure_13},
      {"eon_table_1", "nanoseconds per evaluation and per sample of the models", source("table 1"),
       1, false, reproduce_eon_table_1},
  };
}

}  // namespace lamella
