#pragma once

#include <string>
#include <vector>

#include "tests/volume/run/stacks.h"

namespace lamella::testing {

inline std::string interface(const std::string& keys) {
  return "[[layer]]\ninterface = " + keys + "\n";
}

struct BoundaryCase {
  const char* what;
  std::string toml;
  double theta, phi;
};

inline const std::vector<BoundaryCase>& boundary_cases() {
  const std::string spheres = "medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = ";
  static const std::vector<BoundaryCase> list{
      {"a GGX coat over a half space",
       interface("'ggx'\nior = 1.5\nroughness = 0.3") + layer(spheres + "inf"), 40, 0},
      {"the same in colour",
       interface("'ggx'\nior = 1.5\nroughness = 0.3") +
           layer("medium = 'lambert_sphere'\nalbedo = [0.95, 0.5, 0.2]\nthickness = inf"),
       70, 20},
      {"a GGX coat over Lambert",
       interface("'ggx'\nior = 1.5\nroughness = 0.2") + "[substrate]\nalbedo = 0.8\n", 60, 0},
      {"an anisotropic coat over Lambert, correlated masking, near grazing",
       interface("'ggx'\nior = 1.8\nroughness = [0.6, 0.1]\nmasking = 'correlated'") +
           "[substrate]\nalbedo = 0.95\n",
       84, 25},
      {"a coat of an index below 1 over Lambert",
       interface("'ggx'\nior = 0.7\nroughness = 0.3") + "[substrate]\nalbedo = 0.9\n", 65, 0},
      {"a coat over Lambert, separable masking",
       interface("'ggx'\nior = 1.5\nroughness = 0.3\nmasking = 'separable'") +
           "[substrate]\nalbedo = 0.8\n",
       20, 0},
      {"a smooth coat over coloured Lambert",
       interface("'smooth'\nior = 1.5") + "[substrate]\nalbedo = [0.2, 0.6, 0.95]\n", 50, 30},
      {"a frosted plate",
       interface("'ggx'\nior = 1.5\nroughness = 0.4") +
           interface("'ggx'\nior = 1\nroughness = 0.4"),
       35, 0},
      {"a frosted plate from below, one side smooth",
       interface("'smooth'\nior = 1.5") + interface("'ggx'\nior = 1\nroughness = [0.2, 0.6]"), 130,
       50},
      {"a smooth plate of spheres",
       interface("'smooth'\nior = 1.4") + layer(spheres + "2") + interface("'smooth'\nior = 1"), 75,
       0},
      {"lacquer: two interfaces, absorption, separable masking",
       interface("'ggx'\nior = 1.5\nroughness = [0.3, 0.1]\nmasking = 'separable'") +
           layer("medium = 'henyey_greenstein'\ng = 0.5\nalbedo = [0.1, 0.5, 0.9]\n"
                 "thickness = 0.3") +
           interface("'ggx'\nior = 1.8\nroughness = 0.5\nmasking = 'correlated'") +
           "[substrate]\nalbedo = [0.9, 0.5, 0.3]\n",
       65, 10},
      {"dust on varnish over flakes",
       layer(spheres + "0.4") + interface("'ggx'\nior = 1.5\nroughness = 0.15") +
           layer("medium = 'sggx'\nroughness = 0.4\nf0 = 0.3\nthickness = 1") +
           layer("medium = 'vmf_flake'\nroughness = 0.5\nalbedo = 0.7\nthickness = inf"),
       55, 0},
      {"an air gap, alpha 1",
       interface("'ggx'\nior = 1.6\nroughness = 1") + layer(spheres + "0.5") +
           interface("'ggx'\nior = 0.8\nroughness = 1") + layer(spheres + "1"),
       80, 0},
      {"light from inside glass",
       layer(spheres + "0.5") + interface("'ggx'\nior = 1.5\n"
                                          "roughness = 0.1"),
       140, 0},
      {"a deep layer under an index of 3",
       interface("'ggx'\nior = 3\nroughness = 0.05") + layer("medium = 'rayleigh'\nalbedo = 0.95\n"
                                                             "thickness = 30"),
       89, 0},
      {"a Beckmann coat over a half space",
       interface("'beckmann'\nior = 1.5\nroughness = 0.4") + layer(spheres + "inf"), 50, 0},
      {"Beckmann facets of both kinds of masking, light near grazing",
       interface("'beckmann'\nior = 1.5\nroughness = [0.9, 0.4]") +
           layer("medium = 'rayleigh'\nalbedo = 0.9\nthickness = 0.5") +
           interface("'ggx'\nior = 1.2\nroughness = 0.3\nmasking = 'correlated'") +
           interface("'beckmann'\nior = 1\nroughness = 1\nmasking = 'separable'"),
       86, 15},
      {"a narrow Beckmann coat over Lambert",
       interface("'beckmann'\nior = 1.5\nroughness = 0.001") + "[substrate]\nalbedo = 0.7\n", 30,
       0},
      {"hardly an index, smooth and rough",
       interface("'ggx'\nior = 1.0001\nroughness = 1e-4") + layer(spheres + "1") +
           interface("'smooth'\nior = 1.3") + "[substrate]\nalbedo = 0.5\n",
       85, 0},
      {"narrow flakes under a rough coat: terms of next-event estimation need more bits",
       interface("'ggx'\nior = 1.5\nroughness = 0.4") +
           layer("medium = 'sggx'\nroughness = 0.1\nalbedo = 0.9\nthickness = 1") +
           "[substrate]\nalbedo = 0.5\n",
       30, 0},
      {"a forward peak under a smooth coat, in colour",
       interface("'smooth'\nior = 1.5") +
           layer("medium = 'henyey_greenstein'\ng = 0.9\nalbedo = [0.9, 0.6, 0.3]\n"
                 "thickness = 2") +
           layer("medium = 'rayleigh'\nalbedo = 0.8\nthickness = 1"),
       60, 0},
  };
  return list;
}

}  // namespace lamella::testing
