#include "phase/stack/coated_stacks.h"

#include <fmt/format.h>

namespace lamella {
namespace {

std::string ggx(double ior, double alpha, const std::string& more = "") {
  return fmt::format("[[layer]]\ninterface = \"ggx\"\nior = {}\nroughness = {}\n{}\n", ior, alpha,
                     more);
}

std::string beckmann(double ior, double alpha) {
  return fmt::format("[[layer]]\ninterface = \"beckmann\"\nior = {}\nroughness = {}\n\n", ior,
                     alpha);
}

std::string medium(const std::string& keys) { return "[[layer]]\n" + keys + "\n"; }

std::string substrate(const std::string& keys) { return "[substrate]\n" + keys; }

const std::string kSand = "[0.518, 0.331, 0.184]";

}  // namespace

std::vector<BuiltinStack> coated_stacks() {
  const std::string standard = "standard case of an interface";
  const std::string vmf = "d'Eon and Weidlich 2024, VMF Diffuse, figure 9";
  const std::string spheres = "d'Eon 2021, Lambert-sphere BRDF, figure 13";
  const std::string open_pbr = "OpenPBR specification";
  const std::string copper =
      "bsdf = \"conductor\"\neta = [0.2, 0.92, 1.1]\nk = [3.91, 2.45, 2.14]\n"
      "distribution = \"ggx\"\nroughness = 0.3\n";
  std::vector<BuiltinStack> list{
      {"coated_lambert", "GGX 0.1, index 1.5, over Lambert's law at albedo 0.8", standard,
       ggx(1.5, 0.1) + substrate("bsdf = \"lambert\"\nalbedo = 0.8\n")},
      {"coated_lambert_flakes",
       "the same with a half space of vMF flakes at r = 0, which is Lambert's law", standard,
       ggx(1.5, 0.1) +
           medium("medium = \"vmf_flake\"\nroughness = 0\nalbedo = 0.8\nthickness = inf\n")},
      {"coated_eon", "OpenPBR's glossy diffuse: GGX 0.09 (roughness 0.3), index 1.5, over EON 0.5",
       open_pbr, ggx(1.5, 0.09) + substrate("bsdf = \"eon\"\nalbedo = 0.8\nroughness = 0.5\n")},
      {"coated_vmf_sand",
       "GGX 0.1, index 1.4, over a half space of vMF flakes; the paper tells no "
       "roughness of the coat",
       vmf,
       ggx(1.4, 0.1) + medium("medium = \"vmf_flake\"\nroughness = 0.5\nalbedo = " + kSand +
                              "\nthickness = inf\n")},
      {"coated_vmf_diffuse", "the same coat over the closed form of the half space", vmf,
       ggx(1.4, 0.1) +
           substrate("bsdf = \"vmf_diffuse\"\nroughness = 0.5\nalbedo = " + kSand + "\n")},
      {"coated_lambert_sphere",
       "Beckmann 0.05, index 1.5, over a half space of Lambert spheres; albedo 0.9 is chosen here",
       spheres,
       beckmann(1.5, 0.05) +
           medium("medium = \"lambert_sphere\"\nalbedo = 0.9\nthickness = inf\n")},
      {"coated_lambert_sphere_form", "the same coat over the closed form of the half space",
       spheres, beckmann(1.5, 0.05) + substrate("bsdf = \"lambert_sphere\"\nalbedo = 0.9\n")},
      {"coated_copper", "GGX 0.1, index 1.5, over copper of roughness 0.3", standard,
       ggx(1.5, 0.1) + substrate(copper)},
      {"rough_metal", "copper of roughness 0.3, single scattering", standard, substrate(copper)},
      {"rough_metal_multiple", "the same with every reflection between its facets", standard,
       substrate(copper + "scattering = \"multiple\"\n")},
      {"frosted_plate", "glass, GGX 0.4 above and smooth below, single scattering", standard,
       ggx(1.5, 0.4) + medium("interface = \"smooth\"\nior = 1\n")},
      {"frosted_plate_multiple", "the same with all that happens between the facets", standard,
       ggx(1.5, 0.4, "scattering = \"multiple\"\n") + medium("interface = \"smooth\"\nior = 1\n")},
      {"lacquer", "GGX 0.1, index 1.5, an absorbing film of depth 0.3, over Lambert's law",
       standard,
       ggx(1.5, 0.1) + medium("medium = \"henyey_greenstein\"\nalbedo = 0\nthickness = 0.3\n") +
           substrate("bsdf = \"lambert\"\nalbedo = [0.7, 0.3, 0.2]\n")},
      {"coat_over_dark", "OpenPBR's coat, index 1.6, roughness 0, over EON at albedo 0.1", open_pbr,
       medium("interface = \"smooth\"\nior = 1.6\n") +
           substrate("bsdf = \"eon\"\nalbedo = 0.1\nroughness = 0\n")},
      {"coat_over_bright", "OpenPBR's coat, index 1.6, roughness 0, over EON at albedo 0.9",
       open_pbr,
       medium("interface = \"smooth\"\nior = 1.6\n") +
           substrate("bsdf = \"eon\"\nalbedo = 0.9\nroughness = 0\n")},
  };
  // alpha is the square of OpenPBR's roughness.
  for (const double diffuse : {0.0, 0.5, 1.0})
    for (const double gloss : {0.05, 0.3, 0.6})
      list.push_back(
          {fmt::format("glossy_diffuse_{}_{}", diffuse, gloss),
           fmt::format("OpenPBR's glossy diffuse: diffuse roughness {}, gloss roughness {}",
                       diffuse, gloss),
           open_pbr,
           ggx(1.5, gloss * gloss) +
               substrate(fmt::format("bsdf = \"eon\"\nalbedo = 0.8\nroughness = {}\n", diffuse))});
  return list;
}

}  // namespace lamella
