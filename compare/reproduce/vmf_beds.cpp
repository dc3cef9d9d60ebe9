#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/judge/projection.h"
#include "compare/judge/side_by_side.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"
#include "compare/reproduce/vmf_figures.h"
#include "phase/stack/stack_file.h"
#include "volume/grains/grain_measure.h"
#include "volume/grains/grain_scene.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// The light that reaches the viewer by one bounce: a square window of a bed, seen from straight
// above, under a lamp at 45 degrees.
PreviewColumn picture_of(const std::string& name, const GrainGeometry& geometry, double width,
                         std::uint64_t seed) {
  constexpr int kSize = 160;
  const auto centres = place_grains(geometry, seed, 0);
  const GrainScene scene(geometry, centres);
  const Direction lamp = direction_from_degrees(45, 135);
  PreviewColumn column{name,
                       {.width = kSize,
                        .height = kSize,
                        .radiance = std::vector<Rgb>(kSize * kSize),
                        .covered = std::vector<bool>(kSize * kSize, true)}};
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const Direction from{std::fmod((x + 0.5) / kSize * width, geometry.tile),
                           std::fmod((kSize - y - 0.5) / kSize * width, geometry.tile),
                           geometry.top()};
      const GrainHit hit = scene.trace(from, {0, 0, -1});
      if (hit.end != RayEnd::grain) continue;
      const double cosine = dot(hit.normal, lamp);
      if (cosine > 0 && scene.is_free(hit.point, lamp))
        column.image.radiance[static_cast<std::size_t>(y) * kSize + x] = Rgb(cosine);
    }
  return column;
}

}  // namespace

Json reproduce_vmf_figure_2(ReproductionContext& context) {
  // One sphere per cubic unit; depth 12 radii at least, which no light passes in dense beds.
  constexpr double kDensity = 1, kAlbedo = 0.9;
  const std::vector<double> packings = context.quality == Quality::draft
                                           ? std::vector<double>{0.5, 3}
                                           : std::vector<double>{0.02, 0.1, 0.3, 1, 2, 4};
  const Direction wi = direction_from_degrees(45, 0);
  const CellGrid cells{8, 16, false};
  const std::uint64_t walks = std::max<std::uint64_t>(kBatches, context.walks / packings.size());
  NumberRows rows(context, {{"packing", "g"},
                            {"radius", ".4f"},
                            {"filled", ".4f"},
                            {"roughness", ".4f"},
                            {"roughness_error", ".1e", "+-"},
                            {"reflected", ".4f"},
                            {"model", ".4f"},
                            {"relative_rmse", ".4f", "RMSE"},
                            {"noise", ".4f"}});
  rows.header(
      "beds of Lambertian spheres, one per cubic unit, albedo 0.9; r of the normals that light "
      "from above\nmeets first; reflected light at theta_i 45 of the bed and of vmf_diffuse at "
      "that "
      "r; relative RMSE over\n8 x 16 cells, without noise");
  std::vector<PreviewColumn> columns;
  std::vector<double> fitted, errors;
  for (const double packing : packings) {
    if (is_set(context.stop)) return rows.rows();
    const double radius = std::cbrt(3 * packing / (4 * kPi * kDensity));
    const double depth = 12 / (kDensity * kPi * radius * radius);
    const Stack bed = parse_stack(
        fmt::format("[[layer]]\nmedium = \"sphere_bed\"\nradius = {}\npacking = {}\nthickness = "
                    "{}\nalbedo = {}\n",
                    radius, packing, std::max(depth, 12 * radius), kAlbedo),
        "reproduction", "bed");
    const GrainMeasurement measured = measure_grains(
        *bed.grains(), context.seed, context.by_quality<std::uint64_t>(8, 32, 64), 4000);
    const double r = measured.vmf.roughness.value;
    Simulation simulation(bed, make_plan(bed, {.max_order = 1000}), wi, Estimator::analog, cells,
                          context.seed);
    run(simulation, {.walks = walks, .target_error = {}, .seconds = {}}, {}, context.stop);
    const RunResult result = reduce(simulation);
    const BoundModel model =
        figure_model(fmt::format("vmf_diffuse,roughness={},albedo={}", r, kAlbedo));
    const ProjectedLobes lobes = project(*model.model, *model.info, wi, result.grid, true, 1);
    const RelativeError error =
        relative_error(result.reflected.lobes[Order::all], lobes.lobes[Order::all]);
    fitted.push_back(r);
    errors.push_back(error.rmse);
    rows.add({packing, radius, -std::expm1(-packing), r, measured.vmf.roughness.standard_error,
              result.reflected.total[0].value, model.model->albedo(wi).g, error.rmse, error.noise});
    columns.push_back(picture_of(fmt::format("packing {:g}, r = {:.2f}", packing, r), *bed.grains(),
                                 12, context.seed));
  }
  write_gallery(context, "beds", "spheres of one number density, seen from above, one bounce",
                columns, 1.0);
  bool falls = true;
  for (std::size_t k = 1; k < fitted.size(); ++k) falls = falls && fitted[k] < fitted[k - 1];
  context.find(
      "the roughness goes through this class of geometry, from height fields (low) to "
      "Lambert spheres far apart (1)",
      fmt::format("r falls from {:.3f} to {:.3f} as spheres of one density grow", fitted.front(),
                  fitted.back()),
      falls && fitted.front() > 0.9);
  context.find("the closed form stands for porous, connected beds",
               fmt::format("relative RMSE {:.1f} % to {:.1f} %, the hot spot included",
                           100 * *std::min_element(errors.begin(), errors.end()),
                           100 * *std::max_element(errors.begin(), errors.end())),
               *std::max_element(errors.begin(), errors.end()) < 0.15);
  return rows.rows();
}

}  // namespace lamella
