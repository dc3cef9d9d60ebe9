#include "compare/reproduce/micrograin_figures.h"

namespace lamella {

std::vector<Reproduction> micrograin_figures() {
  const auto source = [](const char* place) {
    return std::string("Lucas et al. 2023, Micrograin BSDF, ") + place;
  };
  return {
      {"micrograin_figure_4", "distances to the closest grain, and the filling factor",
       source("figure 4"), 1000000, true, reproduce_micrograin_figure_4},
      {"micrograin_figure_5", "distribution of the grains' normals", source("figure 5"), 1000000,
       true, reproduce_micrograin_figure_5},
      {"micrograin_figure_9", "visible filling factor", source("figure 9"), 1000000, true,
       reproduce_micrograin_figure_9},
      {"micrograin_figure_10",
       "masking of the grains: five terms of the series, twenty, all, and GGX", source("figure 10"),
       1, false, reproduce_micrograin_figure_10},
      {"micrograin_figure_11",
       "weights of grains and bulk: this model's and d'Eon's of equation 26", source("figure 11"),
       1, false, reproduce_micrograin_figure_11},
      {"micrograin_figure_12",
       "spheres with metallic grains over a diffuse bulk beside d'Eon's mixture and GGX alone",
       source("figure 12"), 1, false, reproduce_micrograin_figure_12},
      {"micrograin_figure_13", "three kinds of grains over diffuse, plastic, metal and glass",
       source("figure 13"), 1, false, reproduce_micrograin_figure_13},
      {"micrograin_figure_14",
       "textures of the filling factor at several scales: filtered parameters against filtered "
       "radiance",
       source("figure 14"), 1, false, reproduce_micrograin_figure_14},
  };
}

}  // namespace lamella
