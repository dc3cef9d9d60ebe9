#include "phase/medium/media.h"

#include <algorithm>

namespace lamella {
namespace {

const ParameterInfo kFlake{.name = "flake",
                           .kind = ParameterKind::choice,
                           .unit = "1",
                           .doc = "surface of a flake",
                           .choices = {"mirror", "lambert"}};
const ParameterInfo kF0{.name = "f0",
                        .kind = ParameterKind::color,
                        .unit = "1",
                        .doc =
                            "Schlick's reflectance at normal incidence of mirror flakes; 1: no "
                            "Fresnel factor",
                        .min = 0,
                        .max = 1};

ParameterInfo axis(std::string doc) {
  return {.name = "axis", .kind = ParameterKind::vector, .unit = "1", .doc = std::move(doc)};
}

std::vector<double> elements(Direction v) { return {v.x, v.y, v.z}; }

template <class Ndf>
Medium with_flake(Ndf ndf, Parameters& p, const std::string& default_flake) {
  if (!p.has("flake")) p.set("flake", default_flake);
  if (p.choice("flake") == "mirror") {
    if (!p.has("f0")) p.set("f0", Rgb(1));
    return MirrorFlakes<Ndf>{std::move(ndf)};
  }
  if (p.has("f0"))
    throw ParameterError("f0", to_text(p.at("f0")), "nothing: only mirror flakes have f0");
  return LambertFlakes<Ndf>{std::move(ndf)};
}

Medium make_sggx(Parameters& p) {
  std::array<double, 6> s{};
  if (p.has("matrix")) {
    for (const char* other : {"shape", "roughness", "axis"})
      if (p.has(other))
        throw ParameterError(other, to_text(p.at(other)),
                             "nothing beside \"matrix\", which replaces shape, roughness and axis");
    const auto& given = std::get<std::vector<double>>(p.at("matrix"));
    std::copy(given.begin(), given.end(), s.begin());
    if (!Sggx::is_positive_definite(s))
      throw ParameterError("matrix", to_text(p.at("matrix")),
                           "six numbers [xx, yy, zz, xy, xz, yz] of a matrix that is positive "
                           "definite beyond rounding, its diagonal in [1e-12, 1e12]");
  } else {
    if (!p.has("shape")) p.set("shape", std::string("surface"));
    const bool fiber = p.choice("shape") == "fiber";
    if (!p.has("axis")) p.set("axis", elements(fiber ? Direction{1, 0, 0} : Direction{0, 0, 1}));
    if (!p.has("roughness"))
      throw ParameterError("roughness", "nothing", "a number in [0.001, 1] (or \"matrix\")");
    const double alpha = p.number("roughness");
    s = fiber ? Sggx::fiber_matrix(alpha, p.vector("axis"))
              : Sggx::surface_matrix(alpha, p.vector("axis"));
  }
  return with_flake(Sggx(s), p, "mirror");
}

Medium make_vmf(Parameters& p) {
  if (p.has("roughness") && p.has("alpha"))
    throw ParameterError("alpha", to_text(p.at("alpha")), "nothing beside \"roughness\"");
  if (!p.has("roughness") && !p.has("alpha"))
    throw ParameterError("roughness", "nothing", "a number in [0, 1] (or \"alpha\")");
  const double alpha = p.has("alpha") ? p.number("alpha") : vmf_alpha(p.number("roughness"));
  if (!p.has("axis")) p.set("axis", elements({0, 0, 1}));
  return with_flake(Vmf(alpha, p.vector("axis")), p, "lambert");
}

}  // namespace

const std::vector<MediumInfo>& media() {
  static const std::vector<MediumInfo> list{
      {.name = "sggx",
       .doc = "two-sided flakes whose normals are those of an ellipsoid; sigma(w) = sqrt(w^T S w)",
       .source =
           "Heitz et al. 2015, The SGGX microflake distribution; Wang et al. 2022, SpongeCake",
       .parameters =
           {{.name = "shape",
             .kind = ParameterKind::choice,
             .unit = "1",
             .doc = "surface: S = diag(alpha^2, alpha^2, 1) about the axis; fiber: S = "
                    "diag(1, 1, alpha^2) (default surface)",
             .choices = {"surface", "fiber"}},
            {.name = "roughness",
             .unit = "1",
             .doc = "alpha; 1 is isotropic",
             .min = 0.001,
             .max = 1},
            axis("mean normal of a surface (default z), direction of a fiber (default x)"),
            {.name = "matrix",
             .kind = ParameterKind::matrix,
             .unit = "1",
             .doc = "S as [xx, yy, zz, xy, xz, yz], instead of shape, roughness and axis"},
            kFlake,
            kF0},
       .make = make_sggx},
      {.name = "vmf_flake",
       .doc = "one-sided flakes, normals by von Mises-Fisher about the axis; sigma <= 1",
       .source = "d'Eon and Weidlich 2024, VMF Diffuse",
       .parameters =
           {{.name = "roughness",
             .unit = "1",
             .doc = "r; alpha = -log(1 - sqrt(r)); 0: all normals along the axis, 1: uniform",
             .min = 0,
             .max = 1},
            {.name = "alpha",
             .unit = "1",
             .doc = "instead of roughness; D is proportional to exp(2 cos / alpha^2)",
             .min = 0},
            axis("mean normal (default z)"),
            kFlake,
            kF0},
       .make = make_vmf},
      {.name = "lambert_sphere",
       .doc = "opaque Lambertian spheres, far apart; sigma = 1",
       .source = "d'Eon 2021, An analytic BRDF for materials with spherical Lambertian scatterers",
       .parameters = {},
       .make = [](Parameters&) -> Medium { return LambertSphere{}; }},
      {.name = "henyey_greenstein",
       .doc = "particles with the Henyey-Greenstein phase function; sigma = 1",
       .source = "Henyey and Greenstein 1941; Wang et al. 2022, SpongeCake",
       .parameters = {{.name = "g",
                       .unit = "1",
                       .doc = "mean cosine of the deflection; > 0 scatters forward, 0 isotropic",
                       .default_value = "0",
                       .min = -1,
                       .max = 1,
                       .min_open = true,
                       .max_open = true}},
       .make = [](Parameters& p) -> Medium { return HenyeyGreenstein{p.number("g")}; }},
      {.name = "rayleigh",
       .doc = "particles much smaller than the wavelength, unpolarised light; sigma = 1",
       .source = "Lord Rayleigh 1871; Chandrasekhar 1960, Radiative Transfer",
       .parameters = {},
       .make = [](Parameters&) -> Medium { return Rayleigh{}; }},
  };
  return list;
}

const MediumInfo* find_medium(std::string_view name) {
  const auto& list = media();
  const auto it = std::find_if(list.begin(), list.end(),
                               [&](const MediumInfo& info) { return info.name == name; });
  return it == list.end() ? nullptr : &*it;
}

}  // namespace lamella
