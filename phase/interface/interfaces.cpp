#include "phase/interface/interfaces.h"

#include <algorithm>

namespace lamella {
namespace {

const ParameterInfo kIor{.name = "ior",
                         .unit = "1",
                         .doc = "index of refraction of everything below, up to the next interface",
                         .min = 0.1,
                         .max = 10};
const ParameterInfo kRoughness{.name = "roughness",
                               .kind = ParameterKind::one_or_two,
                               .unit = "1",
                               .doc = "alpha of the facets' slopes, or [along x, along y]",
                               .min = 1e-6,
                               .max = 10};
const ParameterInfo kScattering{
    .name = "scattering",
    .kind = ParameterKind::choice,
    .unit = "1",
    .doc = "single: one facet, which loses light; multiple: all of Smith's surface",
    .default_value = "single",
    .choices = {"single", "multiple"}};
const ParameterInfo kMasking{
    .name = "masking",
    .kind = ParameterKind::choice,
    .unit = "1",
    .doc = "of single scattering: beta is Smith's surface, correlated pbrt's, separable Walter's",
    .default_value = "beta",
    .choices = {"beta", "correlated", "separable"}};

// What is left open is completed; what has no meaning is refused.
Facets facets_of(const Parameters& p, FacetShape shape) {
  if (shape == FacetShape::smooth) return {.shape = shape};
  if (!p.has("roughness")) throw ParameterError("roughness", "nothing", allowed_values(kRoughness));
  const ParameterValue& value = p.at("roughness");
  if (const double* alpha = std::get_if<double>(&value)) return {shape, *alpha, *alpha};
  const auto& both = std::get<std::vector<double>>(value);
  return {shape, both.at(0), both.at(1)};
}

void refuse_masking_of_multiple(const Parameters& p) {
  if (p.choice("scattering") == "multiple" && p.choice("masking") != "beta")
    throw ParameterError("masking", to_text(p.at("masking")),
                         "beta beside scattering = \"multiple\", which has the surface's own");
}

Interface rough(const Parameters& p, FacetShape shape) {
  refuse_masking_of_multiple(p);
  if (!p.has("ior")) throw ParameterError("ior", "nothing", allowed_values(kIor));
  return {.facets = facets_of(p, shape),
          .masking = masking_from(p.choice("masking")),
          .multiple = p.choice("scattering") == "multiple",
          .ior = p.number("ior")};
}

InterfaceInfo rough_info(FacetShape shape, std::string doc, std::string source) {
  return {.name = std::string(to_text(shape)),
          .doc = std::move(doc),
          .source = std::move(source),
          .parameters = {kIor, kRoughness, kScattering, kMasking},
          .make = [shape](const Parameters& p) { return rough(p, shape); }};
}

}  // namespace

const std::vector<InterfaceInfo>& interfaces() {
  static const std::vector<InterfaceInfo> list{
      {.name = "smooth",
       .doc = "smooth boundary: unpolarised Fresnel reflection, Snell's refraction",
       .source = "Born and Wolf, Principles of Optics",
       .parameters = {kIor},
       .make =
           [](const Parameters& p) {
             if (!p.has("ior")) throw ParameterError("ior", "nothing", allowed_values(kIor));
             return Interface{.ior = p.number("ior")};
           }},
      rough_info(FacetShape::ggx, "rough boundary, GGX facets",
                 "Walter et al. 2007; Heitz et al. 2016 (multiple)"),
      rough_info(FacetShape::beckmann, "rough boundary, Beckmann facets",
                 "Walter et al. 2007; Heitz et al. 2016 (multiple)"),
  };
  return list;
}

const InterfaceInfo* find_interface(std::string_view name) {
  const auto& list = interfaces();
  const auto it = std::find_if(list.begin(), list.end(),
                               [&](const InterfaceInfo& info) { return info.name == name; });
  return it == list.end() ? nullptr : &*it;
}

const std::vector<ParameterInfo>& conductor_parameters() {
  static const std::vector<ParameterInfo> list = [] {
    ParameterInfo roughness = kRoughness;
    roughness.doc += "; not beside distribution = \"smooth\"";
    return std::vector<ParameterInfo>{
        {.name = "eta",
         .kind = ParameterKind::color,
         .unit = "1",
         .doc = "real part of the index against vacuum",
         .min = 1e-3,
         .max = 100},
        {.name = "k",
         .kind = ParameterKind::color,
         .unit = "1",
         .doc = "imaginary part of the index against vacuum",
         .min = 0,
         .max = 100},
        {.name = "distribution",
         .kind = ParameterKind::choice,
         .unit = "1",
         .doc = "of the facets' normals",
         .default_value = "smooth",
         .choices = {"smooth", "ggx", "beckmann"}},
        std::move(roughness),
        kScattering,
        kMasking,
        {.name = "fresnel",
         .kind = ParameterKind::choice,
         .unit = "1",
         .doc = "of eta + i k, or one: reflects everything, for furnaces",
         .default_value = "conductor",
         .choices = {"conductor", "one"}}};
  }();
  return list;
}

Conductor::Setting conductor_setting(const Parameters& p, double above) {
  const FacetShape shape = facet_shape_from(p.choice("distribution"));
  for (const char* key : {"eta", "k"})
    if (!p.has(key))
      throw ParameterError(key, "nothing", allowed_values(*find(conductor_parameters(), key)));
  if (shape == FacetShape::smooth && p.has("roughness"))
    throw ParameterError("roughness", to_text(p.at("roughness")),
                         "nothing beside distribution = \"smooth\"");
  if (shape == FacetShape::smooth && p.choice("scattering") == "multiple")
    throw ParameterError("scattering", "\"multiple\"",
                         "single beside distribution = \"smooth\", which has no facets");
  refuse_masking_of_multiple(p);
  return {.facets = facets_of(p, shape),
          .masking = masking_from(p.choice("masking")),
          .multiple = p.choice("scattering") == "multiple",
          .eta = (1 / above) * p.color("eta"),
          .k = (1 / above) * p.color("k"),
          .white = p.choice("fresnel") == "one"};
}

}  // namespace lamella
