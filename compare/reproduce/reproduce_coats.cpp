#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/reproduce/lambert_sphere_figures.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/vmf_figures.h"
#include "compare/request/interrupt.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Viewing angles of a table of walks.
constexpr std::uint64_t kAngles = HalfVectorGrid::kOut;

std::string half_space(const std::string& medium, double albedo) {
  return fmt::format("[[layer]]\n{}\nalbedo = {}\nthickness = inf\n", medium, albedo);
}

std::string coat(const std::string& shape, double ior, double alpha) {
  return fmt::format("[[layer]]\ninterface = \"{}\"\nior = {}\nroughness = {}\n", shape, ior,
                     alpha);
}

// The share of light along the normal that a stack reflects.
double normal_reflectance(const std::string& toml, const ReproductionContext& context) {
  const double normal[] = {1};
  context.go_on();
  return solve_deterministic(figure_stack("remap", toml),
                             {.tolerance = context.by_quality(3e-2, 1e-3, 1e-3)})
      .energies(normal)[0]
      .reflected[Order::all]
      .g;
}

// The albedo of flakes at which a half space reflects `color` of light along the normal: the
// paper's remapping, without the error of its fit. Halving; the reflectance grows with the albedo.
double remapped(double roughness, double color, const ReproductionContext& context) {
  if (roughness == 0) return color;
  double low = color, high = 1;
  while (high - low > context.by_quality(0.03, 1e-3, 1e-3)) {
    const double middle = (low + high) / 2;
    const std::string medium = fmt::format("medium = \"vmf_flake\"\nroughness = {}", roughness);
    (normal_reflectance(half_space(medium, middle), context) < color ? low : high) = middle;
  }
  return (low + high) / 2;
}

Json json_of(const SphereDifference& d) {
  return {{"relative_rmse", d.rmse}, {"relative_rmse_of_rim", d.rim}, {"mean", d.mean}};
}

void print_row(const ReproductionContext& context, const std::string& what, double mean,
               const SphereDifference& d) {
  if (!context.table) return;
  fmt::print(context.table, "{:<44} {:>9.5f} {:>9.4f} {:>9.4f} {:>+9.4f}\n", what, mean, d.rmse,
             d.rim, d.mean);
  std::fflush(context.table);
}

void print_header(const ReproductionContext& context, const std::string& what) {
  if (!context.table) return;
  fmt::print(context.table, "\n{:<44} {:>9} {:>9} {:>9} {:>9}\n", what, "luminance", "RMSE",
             "at rim", "mean");
}

// A picture beside the one that it is measured by: a row of the table, and of the answer.
void add_row(const ReproductionContext& context, Json& rows, Json keys, const std::string& what,
             const PreviewColumn& picture, const PreviewColumn& from) {
  const SphereDifference d = difference(picture, from);
  const double mean = luminance_of(picture).mean;
  print_row(context, what, mean, d);
  keys["picture"] = picture.name;
  keys["from"] = from.name;
  keys["luminance"] = mean;
  keys["difference"] = json_of(d);
  rows.push_back(std::move(keys));
}

}  // namespace

Json reproduce_vmf_figure_9(ReproductionContext& context) {
  // The paper tells neither the coat's roughness nor the colour.
  constexpr double kIndex = 1.4, kColor = 0.6;
  // Narrow faces take many of the solver's nodes.
  const double alpha = context.by_quality(0.4, 0.1, 0.1);
  const std::vector<double> roughnesses = context.quality == Quality::draft
                                              ? std::vector<double>{0, 1}
                                              : std::vector<double>{0, 0.5, 1};
  const std::uint64_t walks =
      std::max<std::uint64_t>(kBatches, context.walks / (roughnesses.size() * kAngles));
  Json rows = Json::array();
  if (context.table)
    fmt::print(context.table,
               "GGX {:g}, index {:g}, over vMF flakes of roughness r, their albedo such that the "
               "bare half space\nreflects {:g} along the normal; spheres under a lamp at {:g} "
               "degrees; differences of luminance,\nrelative: root mean square, at the rim (mu_o < "
               "{:g}), of the mean\n",
               alpha, kIndex, kColor, kSphereLamp, kRimCosine);
  std::vector<PreviewColumn> bare, coated;
  for (const double r : roughnesses) {
    if (is_set(context.stop)) return rows;
    const double albedo = remapped(r, kColor, context);
    const std::string medium =
        half_space(fmt::format("medium = \"vmf_flake\"\nroughness = {}", r), albedo);
    const std::string base =
        fmt::format("base=vmf_diffuse,base.roughness={},base.albedo={}", r, albedo);
    print_header(context, fmt::format("r = {:g}, albedo {:.3f}", r, albedo));
    const Stack below = figure_stack("bare", medium);
    bare.push_back(lit_sphere(fmt::format("bare, r = {:g}", r), solved_table(below, context)));
    const Json keys{{"roughness", r}, {"albedo", albedo}};
    const PreviewColumn form = lit_sphere(
        "bare vmf_diffuse",
        *figure_model(fmt::format("vmf_diffuse,roughness={},albedo={}", r, albedo)).model);
    add_row(context, rows, keys, "bare vmf_diffuse - bare solver", form, bare.back());

    const Stack stack = figure_stack("coated", coat("ggx", kIndex, alpha) + medium);
    std::vector<PreviewColumn> columns{lit_sphere("solver", solved_table(stack, context))};
    columns.push_back(lit_sphere("walks", walked_table(stack, walks, context)));
    for (const std::string layering : {"albedo_scaling", "saunderson"})
      columns.push_back(lit_sphere(
          layering, *figure_model(fmt::format("coated,ior={},roughness={},layering={},{}", kIndex,
                                              alpha, layering, base))
                         .model));
    for (std::size_t k = 1; k < columns.size(); ++k)
      add_row(context, rows, keys,
              fmt::format("coated {} - coated solver",
                          k == 1 ? fmt::format("{} walks per angle", walks) : columns[k].name),
              columns[k], columns[0]);
    write_spheres(context, fmt::format("coated_r_{:g}", r),
                  fmt::format("GGX coat over vMF flakes, r = {:g}", r), columns);
    columns[0].name = fmt::format("coated, r = {:g}", r);
    coated.push_back(columns[0]);
  }
  print_header(context, "roughness against r = 0, by the solver");
  const auto against_smooth = [&](const std::vector<PreviewColumn>& columns) {
    for (std::size_t k = 1; k < columns.size(); ++k)
      add_row(context, rows, {{"roughness", roughnesses[k]}},
              fmt::format("{} - r = 0", columns[k].name), columns[k], columns[0]);
  };
  against_smooth(bare);
  against_smooth(coated);
  write_spheres(context, "bare", "bare vMF flakes over their roughness", bare);
  write_spheres(context, "coated", "the same under a GGX coat", coated);
  const double rim_bare = difference(bare.back(), bare[0]).rim;
  const double rim_coated = difference(coated.back(), coated[0]).rim;
  context.find(
      "the roughness shows less at grazing angles under a coat",
      fmt::format("at the rim r = 1 differs from r = 0 by {:.0f} % bare and {:.0f} % coated",
                  100 * rim_bare, 100 * rim_coated),
      rim_coated < rim_bare);
  const double dark_smooth = -difference(coated[0], bare[0]).mean;
  const double dark_rough = -difference(coated.back(), bare.back()).mean;
  context.find(
      "the coated versions are darker",
      fmt::format("the coat takes {:.0f} % of the mean luminance at r = 0 and {:.0f} % at r "
                  "= 1",
                  100 * dark_smooth, 100 * dark_rough),
      dark_smooth > 0 && dark_rough > 0);
  return rows;
}

Json reproduce_lambert_sphere_figure_13(ReproductionContext& context) {
  // The paper tells neither the index nor the albedo; Henyey-Greenstein's g is the mean cosine of
  // a Lambert sphere.
  constexpr double kIndex = 1.5, kAlbedo = 0.9, kMeanCosine = -4.0 / 9;
  // Narrow faces take many of the solver's nodes.
  const double alpha = context.by_quality(0.4, 0.05, 0.05);
  const std::uint64_t walks = std::max<std::uint64_t>(kBatches, context.walks / (2 * kAngles));
  Json rows = Json::array();
  const std::string spheres = half_space("medium = \"lambert_sphere\"", kAlbedo);
  const std::string haze =
      half_space(fmt::format("medium = \"henyey_greenstein\"\ng = {}", kMeanCosine), kAlbedo);
  // As bright along the normal as the spheres.
  const double bright = normal_reflectance(spheres, context);
  const std::string lambert = fmt::format("[substrate]\nbsdf = \"lambert\"\nalbedo = {}\n", bright);
  const std::string form =
      fmt::format("[substrate]\nbsdf = \"lambert_sphere\"\nalbedo = {}\n", kAlbedo);
  const std::string top = coat("beckmann", kIndex, alpha);
  if (context.table)
    fmt::print(
        context.table,
        "Beckmann {:g}, index {:g}; albedo {:g}, Lambert's {:.4f} as bright along the normal; "
        "spheres under a\nlamp at {:g} degrees; differences of luminance, relative: root mean "
        "square, at the rim (mu_o < {:g}),\nof the mean\n",
        alpha, kIndex, kAlbedo, bright, kSphereLamp, kRimCosine);
  const auto solved = [&](const std::string& name, const std::string& toml) {
    return lit_sphere(name, solved_table(figure_stack(name, toml), context));
  };
  std::vector<PreviewColumn> bare, coated;
  double lambert_rim[2] = {0, 0}, haze_rim[2] = {0, 0};
  for (const bool is_coated : {false, true}) {
    if (is_set(context.stop)) return rows;
    std::vector<PreviewColumn>& columns = is_coated ? coated : bare;
    const std::string above = is_coated ? top : "";
    print_header(context, is_coated ? "coated" : "bare");
    columns.push_back(solved("Lambert spheres, solver", above + spheres));
    columns.push_back(solved("their BRDF, solver", above + form));
    columns.push_back(solved("Henyey-Greenstein", above + haze));
    columns.push_back(solved("Lambert", above + lambert));
    const Json keys{{"coated", is_coated}};
    for (std::size_t k = 1; k < columns.size(); ++k)
      add_row(context, rows, keys, columns[k].name + " - spheres", columns[k], columns[0]);
    haze_rim[is_coated] = difference(columns[2], columns[0]).rim;
    lambert_rim[is_coated] = difference(columns[3], columns[0]).rim;
    write_spheres(context, is_coated ? "coated" : "bare",
                  is_coated ? "Beckmann coat over diffuse bases" : "diffuse bases", columns);
  }
  if (is_set(context.stop)) return rows;
  print_header(context, "coated, other ways to the same");
  const Json keys{{"coated", true}};
  std::vector<PreviewColumn> ways{coated[0]};
  ways.push_back(lit_sphere("spheres, walks",
                            walked_table(figure_stack("spheres", top + spheres), walks, context)));
  add_row(context, rows, keys, fmt::format("spheres, {} walks per angle - solver", walks),
          ways.back(), coated[0]);
  ways.push_back(
      lit_sphere("BRDF, walks", walked_table(figure_stack("form", top + form), walks, context)));
  add_row(context, rows, keys, fmt::format("BRDF, {} walks per angle - solver", walks), ways.back(),
          coated[1]);
  for (const std::string layering : {"albedo_scaling", "saunderson"}) {
    ways.push_back(lit_sphere(
        layering, *figure_model(fmt::format("coated,ior={},roughness={},distribution=beckmann,"
                                            "layering={},base=lambert_sphere,base.albedo={}",
                                            kIndex, alpha, layering, kAlbedo))
                       .model));
    add_row(context, rows, keys, layering + " - spheres", ways.back(), coated[0]);
  }
  write_spheres(context, "ways", "Beckmann coat over Lambert spheres", ways);
  const double noise = difference(ways[2], coated[1]).rmse;
  context.find("position-free evaluation over the BRDF matches the doubling method",
               fmt::format("walks and solver differ by {:.1f} %, noise included", 100 * noise),
               noise < 0.1);
  context.find(
      "the differences between the bases are less apparent under the coat",
      fmt::format("at the rim Lambert differs from the spheres by {:.0f} % bare and {:.0f} % "
                  "coated, Henyey-Greenstein by {:.0f} % and {:.0f} %",
                  100 * lambert_rim[0], 100 * lambert_rim[1], 100 * haze_rim[0], 100 * haze_rim[1]),
      lambert_rim[1] < lambert_rim[0] && haze_rim[1] < haze_rim[0]);
  return rows;
}

}  // namespace lamella
