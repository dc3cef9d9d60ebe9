#include "compare/library/library_stacks.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "compare/request/substrate_model.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

// Built-in stacks by group.
struct Builtin {
  const char* group;
  std::vector<std::string> names;
};

const std::vector<Builtin>& builtin_names() {
  static const std::vector<Builtin> list{
      {"paper",
       {"spongecake_two_layer",
        "spongecake_window_shade",
        "spongecake_fabric",
        "spongecake_fabric_table",
        "spongecake_plant",
        "spongecake_wood",
        "spongecake_sheen",
        "spongecake_copper",
        "spongecake_furnace",
        "lambert_sphere_halfspace",
        "lambert_sphere_0.3",
        "lambert_sphere_0.7",
        "lambert_sphere_0.99",
        "lambert_sphere_white",
        "lambert_sphere_kd",
        "vmf_sand",
        "vmf_halfspace",
        "vmf_r_0.1",
        "vmf_r_0.3",
        "vmf_r_0.7",
        "vmf_r_1"}},
      {"coat",
       {"coated_lambert", "coated_lambert_flakes", "coated_eon", "coated_vmf_sand",
        "coated_vmf_diffuse", "coated_lambert_sphere", "coated_lambert_sphere_form",
        "coated_copper", "rough_metal", "rough_metal_multiple", "lacquer", "coat_over_dark",
        "coat_over_bright", "glossy_diffuse_0_0.3", "glossy_diffuse_0.5_0.05",
        "glossy_diffuse_0.5_0.3", "glossy_diffuse_1_0.6"}},
      {"plate", {"frosted_plate", "frosted_plate_multiple"}},
      {"problem", {"isotropic_halfspace", "isotropic_slab", "sggx_slab", "hg_slab"}},
      {"hard", {"blotchy_layer", "settled_dust", "micrograins_dust"}},
  };
  return list;
}

std::string medium(const std::string& keys) { return "[[layer]]\nmedium = " + keys + "\n"; }

std::string interface(const std::string& keys) { return "[[layer]]\ninterface = " + keys + "\n"; }

std::string lambert(double albedo) { return fmt::format("[substrate]\nalbedo = {}\n", albedo); }

struct Added {
  const char* group;
  const char* name;
  const char* about;
  std::string toml;
};

std::string many_layers() {
  std::string text;
  for (int k = 0; k < 24; ++k)
    text += k % 2 ? medium("\"henyey_greenstein\"\ng = 0.5\nalbedo = 0.95\nthickness = 0.1")
                  : medium("\"sggx\"\nroughness = 0.5\nalbedo = 0.9\nthickness = 0.1");
  return text;
}

std::vector<Added> added() {
  const std::string glass_below = interface("\"smooth\"\nior = 1");
  return {
      {"plate", "milky_plate", "forward scattering, depth 1, between smooth faces of index 1.5",
       interface("\"smooth\"\nior = 1.5") +
           medium("\"henyey_greenstein\"\ng = 0.6\nalbedo = 0.95\nthickness = 1") + glass_below},
      {"plate", "milky_rough_plate", "Rayleigh scattering, depth 1, below GGX 0.3 of index 1.33",
       interface("\"ggx\"\nior = 1.33\nroughness = 0.3") +
           medium("\"rayleigh\"\nalbedo = 0.98\nthickness = 1") + glass_below},
      {"plate", "ground_plate", "glass of index 1.5, GGX 0.3 above and 0.2 below",
       interface("\"ggx\"\nior = 1.5\nroughness = 0.3") +
           interface("\"ggx\"\nior = 1\nroughness = 0.2")},
      {"plate", "wet_spheres", "water of index 1.33 over a half space of Lambert spheres",
       interface("\"smooth\"\nior = 1.33") +
           medium("\"lambert_sphere\"\nalbedo = 0.9\nthickness = inf")},
      {"problem", "isotropic_white_slab", "isotropic scattering without absorption, depth 1",
       medium("\"henyey_greenstein\"\nthickness = 1")},
      {"problem", "isotropic_over_lambert", "isotropic scattering, depth 1, over albedo 0.5",
       medium("\"henyey_greenstein\"\nalbedo = 0.8\nthickness = 1") + lambert(0.5)},
      {"problem", "rayleigh_slab", "Rayleigh's phase function without absorption, depth 0.5",
       medium("\"rayleigh\"\nthickness = 0.5")},
      {"problem", "rayleigh_halfspace", "Rayleigh's phase function, albedo 0.9",
       medium("\"rayleigh\"\nalbedo = 0.9\nthickness = inf")},
      {"problem", "hg_backward_slab", "g = -0.5, albedo 0.9, depth 2",
       medium("\"henyey_greenstein\"\ng = -0.5\nalbedo = 0.9\nthickness = 2")},
      {"problem", "hg_haze_slab", "g = 0.85, albedo 0.99, depth 8",
       medium("\"henyey_greenstein\"\ng = 0.85\nalbedo = 0.99\nthickness = 8")},
      {"problem", "lambert_sphere_slab", "depth 2, albedo 0.8, over albedo 0.2",
       medium("\"lambert_sphere\"\nalbedo = 0.8\nthickness = 2") + lambert(0.2)},
      {"problem", "vmf_slab", "one-sided flakes, r = 0.5, albedo 0.9, depth 1.5, open below",
       medium("\"vmf_flake\"\nroughness = 0.5\nalbedo = 0.9\nthickness = 1.5")},
      {"problem", "fiber_slab", "upright fibers of roughness 0.3, albedo 0.9, depth 2",
       medium("\"sggx\"\nshape = \"fiber\"\naxis = [0, 0, 1]\nroughness = 0.3\nalbedo = 0.9\n"
              "thickness = 2")},
      {"hard", "thin_slab", "isotropic scattering of depth 1e-6",
       medium("\"henyey_greenstein\"\nalbedo = 0.9\nthickness = 1e-6")},
      {"hard", "thick_slab", "isotropic scattering of depth 1e4, albedo 0.999",
       medium("\"henyey_greenstein\"\nalbedo = 0.999\nthickness = 1e4")},
      {"hard", "dark_flakes", "SGGX mirrors of albedo 0.01, depth 2",
       medium("\"sggx\"\nroughness = 0.5\nalbedo = 0.01\nthickness = 2")},
      {"hard", "narrow_flakes", "SGGX mirrors of roughness 0.1, albedo 0.9, depth 2",
       medium("\"sggx\"\nroughness = 0.1\nalbedo = 0.9\nthickness = 2")},
      {"hard", "flat_lambert_flakes", "vMF flakes of r = 0.001, albedo 0.9, half space",
       medium("\"vmf_flake\"\nroughness = 0.001\nalbedo = 0.9\nthickness = inf")},
      {"hard", "leaning_flakes", "wide vMF flakes that lean by 20 degrees, depth 1",
       medium("\"vmf_flake\"\nroughness = 0.7\naxis = [0.3420201433, 0, 0.9396926208]\n"
              "albedo = 0.9\nthickness = 1")},
      {"hard", "lying_fibers", "fibers along x, roughness 0.5, albedo 0.8, depth 1",
       medium("\"sggx\"\nshape = \"fiber\"\nroughness = 0.5\nalbedo = 0.8\nthickness = 1")},
      {"hard", "nearly_matched_coat", "a smooth face of index 1.01 over albedo 0.8",
       interface("\"smooth\"\nior = 1.01") + lambert(0.8)},
      {"hard", "many_layers", "24 layers by turns of SGGX mirrors and forward scattering",
       many_layers()},
  };
}

}  // namespace

std::vector<LibraryStack> library_stacks() {
  std::vector<LibraryStack> list;
  const std::vector<Added> more = added();
  for (const Builtin& group : builtin_names()) {
    for (const std::string& name : group.names) {
      const auto& all = builtin_stacks();
      const auto found = std::find_if(
          all.begin(), all.end(), [&](const BuiltinStack& stack) { return stack.name == name; });
      if (found == all.end()) throw std::logic_error("no built-in stack " + name);
      list.push_back(
          {name, group.group, found->doc, found->source, with_surface_model(load_stack(name))});
    }
    for (const Added& a : more)
      if (std::string_view(a.group) == group.group)
        list.push_back(
            {a.name, a.group, a.about, "Lamella's own choice",
             with_surface_model(parse_stack(a.toml, fmt::format("<library {}>", a.name), a.name))});
  }
  return list;
}

std::vector<Direction> library_directions(const Stack& stack) {
  std::vector<double> thetas{0, 15, 30, 45, 60, 70, 80, 88};
  if (stack.is_open_below()) thetas = {0, 30, 45, 60, 80, 88, 120, 150};
  const bool turned = !stack.is_symmetric_about_z();
  std::vector<Direction> directions;
  // 37 degrees from one to the next meet no plane of symmetry twice.
  for (std::size_t k = 0; k < thetas.size(); ++k)
    directions.push_back(
        direction_from_degrees(thetas[k], turned ? 37.0 * static_cast<double>(k) : 0));
  return directions;
}

}  // namespace lamella
