#include "phase/stack/builtin_stacks.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "phase/stack/coated_stacks.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/text_file.h"

namespace lamella {
namespace {

std::string layer(const std::string& keys) { return "[[layer]]\n" + keys + "\n"; }

std::string lambert_spheres(const std::string& albedo) {
  return layer("medium = \"lambert_sphere\"\nalbedo = " + albedo + "\nthickness = inf\n");
}

std::string vmf_half_space(double roughness, const std::string& albedo) {
  return layer(fmt::format("medium = \"vmf_flake\"\nroughness = {}\nalbedo = {}\nthickness = inf\n",
                           roughness, albedo));
}

std::vector<BuiltinStack> make_list() {
  const std::string spongecake = "Wang et al. 2022, SpongeCake";
  const std::string lambert_sphere = "d'Eon 2021, Lambert-sphere BRDF";
  const std::string vmf = "d'Eon and Weidlich 2024, VMF Diffuse";
  std::vector<BuiltinStack> list{
      {"spongecake_two_layer", "the two-layer validation; its albedo, not given there, is 0.9 here",
       spongecake + ", figure 7",
       layer("medium = \"sggx\"\nshape = \"surface\"\nroughness = 0.5\nalbedo = 0.9\n"
             "thickness = 0.5\n") +
           layer("medium = \"sggx\"\nshape = \"surface\"\nroughness = 0.9\nalbedo = 0.9\n"
                 "thickness = 2\n")},
      {"spongecake_window_shade",
       "specular fibers over rough ones; the orientation map is replaced by fibers along x",
       spongecake + ", figure 1 and table 2",
       layer("medium = \"sggx\"\nshape = \"fiber\"\nroughness = 0.1\nalbedo = [0.9, 0.9, 0.7]\n"
             "thickness = 1\n") +
           layer("medium = \"sggx\"\nshape = \"fiber\"\nroughness = 1\nalbedo = [0.9, 0.9, 0.7]\n"
                 "thickness = 1\n")},
      {"spongecake_fabric",
       "fibers over a rough surface; roughness 0.5 as in text and caption, fibers along x",
       spongecake + ", figure 17 and table 2",
       layer("medium = \"sggx\"\nshape = \"fiber\"\nroughness = 0.5\nalbedo = [0.7, 0.1, 0.1]\n"
             "thickness = 1\n") +
           layer("medium = \"sggx\"\nshape = \"surface\"\nroughness = 0.8\n"
                 "albedo = [0.7, 0.1, 0.1]\nthickness = 5\n")},
      {"spongecake_fabric_table", "the fabric with the fiber roughness 0.1 that the table gives",
       spongecake + ", table 2",
       layer("medium = \"sggx\"\nshape = \"fiber\"\nroughness = 0.1\nalbedo = [0.7, 0.1, 0.1]\n"
             "thickness = 1\n") +
           layer("medium = \"sggx\"\nshape = \"surface\"\nroughness = 0.8\n"
                 "albedo = [0.7, 0.1, 0.1]\nthickness = 5\n")},
      {"spongecake_plant",
       "a leaf: forward scattering between two thin mirrors; the mapped middle thickness is 1 "
       "here, "
       "maps of orientation are z",
       spongecake + ", figure 18 and table 2",
       layer("medium = \"sggx\"\nroughness = 0.05\nf0 = 0.1\nthickness = 0.05\n") +
           layer("medium = \"henyey_greenstein\"\ng = 0.7\nthickness = 1\n") +
           layer("medium = \"sggx\"\nroughness = 0.05\nthickness = 0.002\n")},
      {"spongecake_wood",
       "varnish, secondary specular fibers, diffuse base; the mapped fiber albedo is (0.6, 0.4, "
       "0.2) "
       "here, fibers along x",
       spongecake + ", figure 19 and table 2",
       layer("medium = \"sggx\"\nroughness = 0.05\nf0 = 0.1\nthickness = 0.1\n") +
           layer("medium = \"sggx\"\nshape = \"fiber\"\nroughness = 0.2\n"
                 "albedo = [0.6, 0.4, 0.2]\nthickness = 1\n") +
           layer("medium = \"sggx\"\nroughness = 0.8\nthickness = 5\n")},
      {"spongecake_sheen",
       "fly-away fibers over a Lambertian base; the paper gives no numbers, all are chosen here",
       spongecake + ", figure 16",
       layer("medium = \"sggx\"\nshape = \"fiber\"\naxis = [0, 0, 1]\nroughness = 0.1\n"
             "thickness = 0.2\n") +
           "[substrate]\nbsdf = \"lambert\"\nalbedo = [0.3, 0.05, 0.05]\n"},
      {"spongecake_copper",
       "rough metal as a half space of mirror flakes; the paper gives no numbers, all are chosen "
       "here",
       spongecake + ", figure 20",
       layer("medium = \"sggx\"\nroughness = 0.5\nf0 = [0.95, 0.64, 0.54]\nthickness = inf\n")},
      {"spongecake_furnace", "the two-layer validation without absorption",
       spongecake + ", figures 7 and 21",
       layer("medium = \"sggx\"\nroughness = 0.5\nthickness = 0.5\n") +
           layer("medium = \"sggx\"\nroughness = 0.9\nthickness = 2\n")},
      {"lambert_sphere_halfspace", "albedo 0.9", lambert_sphere, lambert_spheres("0.9")},
      {"lambert_sphere_0.3", "albedo 0.3", lambert_sphere, lambert_spheres("0.3")},
      {"lambert_sphere_0.7", "albedo 0.7", lambert_sphere, lambert_spheres("0.7")},
      {"lambert_sphere_0.99", "albedo 0.99", lambert_sphere, lambert_spheres("0.99")},
      {"lambert_sphere_white", "albedo 1", lambert_sphere, lambert_spheres("1")},
      {"lambert_sphere_kd",
       "diffuse colour (0.18, 0.05, 0.6) mapped to albedo by the paper's eq. 46",
       lambert_sphere + ", figure 11", ""},
      {"vmf_sand", "r = 0.5", vmf + ", figure 1", vmf_half_space(0.5, "[0.518, 0.331, 0.184]")},
      {"vmf_halfspace", "r = 0.5, albedo 0.9", vmf, vmf_half_space(0.5, "0.9")},
      {"isotropic_halfspace", "albedo 0.9: Chandrasekhar's problem", "Chandrasekhar 1960",
       layer("medium = \"henyey_greenstein\"\nalbedo = 0.9\nthickness = inf\n")},
      {"isotropic_slab", "albedo 0.8, optical depth 2", "van de Hulst 1980, table 12",
       layer("medium = \"henyey_greenstein\"\nalbedo = 0.8\nthickness = 2\n")},
      {"woven_cloth", "a generated weave: fiber flakes along two directions of yarns",
       "standard case of a density grid",
       layer("medium = \"sggx\"\nshape = \"fiber\"\nroughness = 0.3\nalbedo = 0.9\ndensity = 12\n"
             "thickness = 0.4\ngrid = \"builtin:weave\"\nsize = [1, 1]\n")},
      {"settled_dust", "generated heaps of Lambert spheres on a grey base",
       "standard case of a density grid",
       layer("medium = \"lambert_sphere\"\nalbedo = 0.8\ndensity = 10\nthickness = 0.5\n"
             "grid = \"builtin:dust\"\nsize = [1, 1]\n") +
           "[substrate]\nbsdf = \"lambert\"\nalbedo = 0.2\n"},
      {"blotchy_layer", "generated noise in a forward scattering layer",
       "standard case of a density grid",
       layer(
           "medium = \"henyey_greenstein\"\ng = 0.5\nalbedo = 0.95\ndensity = 4\nthickness = 0.5\n"
           "grid = \"builtin:blotches\"\nsize = [1, 1]\n")},
      {"sphere_bed_dilute", "Lambertian spheres that fill 5 % of a deep slab, albedo 0.9",
       lambert_sphere + ", figure 1",
       layer("medium = \"sphere_bed\"\nradius = 0.02\npacking = 0.05\nthickness = 4\n"
             "albedo = 0.9\n")},
      {"sphere_bed_dense", "overlapping Lambertian spheres, porous yet connected, albedo 0.9",
       vmf + ", figure 2",
       layer("medium = \"sphere_bed\"\nradius = 0.02\npacking = 1\nthickness = 0.8\n"
             "albedo = 0.9\n")},
      {"sphere_bed_packed", "Lambertian spheres that do not overlap and fill 30 %, albedo 0.9",
       lambert_sphere + ", figure 12",
       layer("medium = \"packed_sphere_bed\"\nradius = 0.02\npacking = 0.3\nthickness = 0.8\n"
             "albedo = 0.9\n")},
      {"micrograins_dust", "Lambertian grains over half of a dark plane",
       "Lucas et al. 2023, Micrograin BSDF",
       layer("medium = \"micrograins\"\ntau0 = 0.5\nbeta = 0.5\nalbedo = 0.8\n") +
           "[substrate]\nalbedo = 0.2\n"},
      {"sggx_slab", "mirror flakes of roughness 0.5, depth 2, albedo 0.9", "standard case",
       layer("medium = \"sggx\"\nroughness = 0.5\nalbedo = 0.9\nthickness = 2\n")},
      {"hg_slab", "Henyey-Greenstein, g = 0.7, depth 4, albedo 0.9", "standard case",
       layer("medium = \"henyey_greenstein\"\ng = 0.7\nalbedo = 0.9\nthickness = 4\n")},
  };
  for (const double r : {0.025, 0.1, 0.2, 0.3, 0.4, 0.6, 0.7, 0.8, 0.9, 1.0})
    list.push_back({fmt::format("vmf_r_{}", r), fmt::format("r = {}, albedo 0.9", r),
                    vmf + ", figure 4", vmf_half_space(r, "0.9")});
  for (BuiltinStack& stack : coated_stacks()) list.push_back(std::move(stack));
  const auto kd = std::find_if(list.begin(), list.end(),
                               [](const auto& s) { return s.name == "lambert_sphere_kd"; });
  // c = (1 - (1 - k)^2.73556) / (1 - 0.184096 (1 - k)^2.48423)
  const auto albedo_of = [](double k) {
    return (1 - std::pow(1 - k, 2.73556)) / (1 - 0.184096 * std::pow(1 - k, 2.48423));
  };
  kd->toml = lambert_spheres(
      fmt::format("[{}, {}, {}]", albedo_of(0.18), albedo_of(0.05), albedo_of(0.6)));
  return list;
}

// Stack files in the folder of a path that leads nowhere, as that path would name them.
std::vector<std::string> stack_files_beside(const std::filesystem::path& path) {
  constexpr std::size_t kMost = 1000;
  namespace fs = std::filesystem;
  std::vector<std::string> names;
  const fs::path folder = path.parent_path();
  std::error_code error;
  for (fs::directory_iterator at(folder.empty() ? "." : folder, error), end;
       !error && at != end && names.size() < kMost; at.increment(error))
    if (at->path().extension() == ".toml")
      names.push_back((folder / at->path().filename()).string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

const std::vector<BuiltinStack>& builtin_stacks() {
  static const std::vector<BuiltinStack> list = make_list();
  return list;
}

MappedStack load_mapped_stack(const std::string& what) {
  for (const BuiltinStack& stack : builtin_stacks())
    if (stack.name == what) return {stack.toml, "<built-in " + what + ">", what};
  // A stack file of a thousand layers has some hundred kilobytes.
  constexpr std::size_t kMostBytes = std::size_t{16} << 20;
  namespace fs = std::filesystem;
  const bool in = what == "-";
  std::string text;
  try {
    text = read_text_file(what, kMostBytes);
  } catch (const TextFileError& error) {
    const std::string reason = error.what();
    std::vector<std::string> names;
    for (const BuiltinStack& stack : builtin_stacks()) names.push_back(stack.name);
    for (const std::string& name : stack_files_beside(what)) names.push_back(name);
    const std::string hint = suggestion(what, names);
    throw StackFileError(
        fmt::format("{}: {}; allowed: a TOML file, - for stdin, or a built-in stack (lamella "
                    "stacks lists them){}",
                    in ? "<stdin>" : what, reason, hint.empty() ? "" : "; " + hint));
  }
  return in ? MappedStack(text, "<stdin>", "stdin")
            : MappedStack(text, what, fs::path(what).stem().string());
}

Stack load_stack(const std::string& what) { return load_mapped_stack(what).plain(); }

}  // namespace lamella
