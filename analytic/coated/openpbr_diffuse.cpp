#include "analytic/coated/openpbr_diffuse.h"

#include <cmath>

#include "analytic/coated/coat_of_stack.h"
#include "analytic/coated/coated_model.h"
#include "analytic/model/parameter_infos.h"
#include "analytic/rough_surface/eon.h"

namespace lamella {
namespace {

/// The index whose reflectance at normal incidence is `weight` times that of ior.
double weighted_index(double ior, double weight) {
  const double e = std::fmin(std::sqrt(weight) * (ior - 1) / (ior + 1), 0.6);
  return (1 + e) / (1 - e);
}

std::unique_ptr<Model> make_slab(const Parameters& p) {
  static const ModelInfo eon = eon_model();
  Parameters base;
  base.set("albedo", p.number("base_weight") * p.color("base_color"));
  base.set("roughness", p.number("base_diffuse_roughness"));
  fill_defaults(eon.parameters, base);
  const double r = p.number("specular_roughness");
  return make_coated(
      {.interface =
           coat_interface(FacetShape::ggx, r * r,
                          weighted_index(p.number("specular_ior"), p.number("specular_weight"))),
       .tint = p.color("specular_color"),
       .layering = p.choice("layering") == "albedo_scaling" ? Layering::albedo_scaling
                                                            : Layering::albedo_scaling_reciprocal,
       .base = eon.make(base, nullptr)});
}

}  // namespace

ModelInfo openpbr_diffuse_model() {
  return {
      .name = "openpbr_diffuse",
      .doc = "OpenPBR's glossy-diffuse slab: a dielectric over EON",
      .source = "OpenPBR Surface specification 1.1, Glossy-diffuse",
      .parameters = {number_parameter("base_weight", "factor of base_color", "1", 0, 1),
                     color_parameter("base_color", "albedo of EON", "0.8"),
                     number_parameter("base_diffuse_roughness", "EON's roughness", "0", 0, 1),
                     number_parameter("specular_weight",
                                      "factor of the reflectance at normal incidence", "1", 0, 4),
                     color_parameter("specular_color", "tint of the dielectric's reflection", "1"),
                     number_parameter("specular_roughness",
                                      "r = sqrt(alpha); below 0.01 smooth: the lobe is a delta",
                                      "0.3", 0, 1),
                     number_parameter("specular_ior", "refractive index", "1.5", 1, 3),
                     choice_parameter("layering", "factor of the base's lobe",
                                      {"albedo_scaling", "albedo_scaling_reciprocal"})},
      .lobes = {{"coat", "the dielectric's reflection", Order::zero},
                {"base", "light that reached the diffuse base", Order::scattered}},
      .reciprocal = false,
      .make = [](const Parameters& p, const Stack*) { return make_slab(p); },
      .applies_to = [](const Stack& stack) -> std::optional<Parameters> {
        const auto coat = coat_of(stack, {eon_model()});
        if (!coat || coat->shape == FacetShape::beckmann || coat->color != Rgb(1) ||
            (coat->base != "eon" && coat->base != "lambert") || coat->ior < 1 || coat->ior > 3 ||
            coat->alpha > 1)
          return std::nullopt;
        Parameters p;
        p.set("base_color", coat->parameters.color("albedo"));
        if (coat->base == "eon")
          p.set("base_diffuse_roughness", coat->parameters.number("roughness"));
        p.set("specular_roughness", std::sqrt(coat->alpha));
        p.set("specular_ior", coat->ior);
        return p;
      }};
}

}  // namespace lamella
