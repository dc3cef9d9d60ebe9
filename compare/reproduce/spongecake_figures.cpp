#include "compare/reproduce/spongecake_figures.h"

namespace lamella {

std::vector<Reproduction> spongecake_figures() {
  return {
      {"spongecake_figure_7",
       "single scattering of one layer: the model's samples against walks, and their variance",
       "Wang et al. 2022, SpongeCake, figure 7", 4000000, false, reproduce_spongecake_figure_7},
      {"spongecake_figure_14",
       "a half space of SGGX mirrors in single scattering, doubled, against microfacets",
       "Wang et al. 2022, SpongeCake, figure 14", 1, false, reproduce_spongecake_figure_14},
      {"spongecake_figure_15",
       "a map of normals on a microfacet surface, and the same map on the flakes of a layer: black "
       "spots",
       "Wang et al. 2022, SpongeCake, figure 15", 1, false, reproduce_spongecake_figure_15},
      {"spongecake_figure_16",
       "sheen: a layer of SGGX fibers that stand up against Conty and Kulla's facets",
       "Wang et al. 2022, SpongeCake, figure 16", 1, false, reproduce_spongecake_figure_16},
  };
}

}  // namespace lamella
