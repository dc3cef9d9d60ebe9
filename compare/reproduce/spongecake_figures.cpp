#include "compare/reproduce/spongecake_figures.h"

namespace lamella {

std::vector<Reproduction> spongecake_figures() {
  return {
      {"spongecake_figure_1",
       "a window shade of fibers in sunlight from outside, under a lamp inside, and both: truth by "
       "walks and the closed form",
       "Wang et al. 2022, SpongeCake, figure 1; the shade is generated", 1, true,
       reproduce_spongecake_figure_1},
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
      {"spongecake_figure_17",
       "a woven cloth: walks, the closed form and a table at equal time, noise and bias apart",
       "Wang et al. 2022, SpongeCake, figure 17; cloth and weave are generated", 1, true,
       reproduce_spongecake_figure_17},
      {"spongecake_figure_18",
       "a leaf lit from the front and from behind: truth, closed form, Lambertian transmission",
       "Wang et al. 2022, SpongeCake, figure 18; leaf and maps are generated", 1, true,
       reproduce_spongecake_figure_18},
      {"spongecake_figure_19",
       "three varnished woods: walks and the closed form at equal time, noise and bias apart",
       "Wang et al. 2022, SpongeCake, figure 19; boards and textures are generated", 1, true,
       reproduce_spongecake_figure_19},
  };
}

}  // namespace lamella
