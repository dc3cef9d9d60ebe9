#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/model/model.h"
#include "compare/drawing/chart.h"
#include "compare/judge/projection.h"
#include "compare/judge/side_by_side.h"
#include "compare/reproduce/lambert_sphere_figures.h"
#include "compare/reproduce/vmf_figures.h"
#include "compare/request/interrupt.h"
#include "compare/request/model_request.h"
#include "phase/stack/stack_file.h"
#include "volume/grains/grain_measure.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr CellGrid kCells{8, 16, false};
// Realisations that a bed's roughness is measured with, and rays of each.
std::uint64_t realisations(const ReproductionContext& context) {
  return context.by_quality<std::uint64_t>(2, 32, 64);
}
constexpr std::uint64_t kRays = 4000;

Stack sphere_bed(double radius, double packing, double thickness, double albedo) {
  return parse_stack(
      fmt::format("[[layer]]\nmedium = \"sphere_bed\"\nradius = {}\npacking = {}\nthickness = {}\n"
                  "albedo = {}\n",
                  radius, packing, thickness, albedo),
      "reproduction", fmt::format("packing {:g}", packing));
}

RunResult walked(const Stack& stack, Direction wi, const CellGrid& grid, std::uint64_t walks,
                 const ReproductionContext& context, std::uint64_t max_order = 1000) {
  Simulation simulation(stack, make_plan(stack, {.max_order = max_order}), wi, Estimator::analog,
                        grid, context.seed);
  run(simulation, {.walks = walks, .target_error = {}, .seconds = {}}, {}, context.stop);
  return reduce(simulation);
}

ProjectedLobes projected(const std::string& request, const Stack* stack, Direction wi,
                         const CellGrid& grid) {
  const BoundModel bound = bind_model(parse_model_request(request), stack);
  return project(*bound.model, *bound.info, wi, grid, true, 1);
}

// The lobe of all orders.
LobeEstimate without_error(const ProjectedLobes& lobes) {
  const std::vector<double>& all = lobes.lobes[Order::all];
  return {all, std::vector<double>(all.size())};
}

Json json_of(const Estimate& e) { return {e.value, e.standard_error}; }

}  // namespace

Json reproduce_lambert_sphere_dilute(ReproductionContext& context) {
  // Deep enough: exp(-12) passes straight.
  constexpr double kAlbedo = 0.9, kRadius = 1, kDepth = 12;
  const Direction wi = direction_from_degrees(60, 0);
  const std::vector<double> packings = context.quality == Quality::draft
                                           ? std::vector<double>{1, 0.1}
                                           : std::vector<double>{1, 0.3, 0.1, 0.03, 0.01, 0.003};
  const std::uint64_t walks = std::max<std::uint64_t>(kBatches, context.walks / packings.size());
  Json rows = Json::array();
  if (context.table)
    fmt::print(
        context.table,
        "theta_i 60, albedo {:g}, optical depth {:g}; bed - medium, relative to the medium: "
        "energies of\norder 1, 2 and all; rel. RMSE over {}x{} cells without noise, of order "
        "1, of all (RMSE), of all\nagainst the BRDF\n"
        "{:>7} {:>8} | {:>8} {:>7} {:>8} {:>7} {:>8} {:>7} | {:>6} {:>6} {:>6} {:>6}\n",
        kAlbedo, kDepth, kCells.mu_cells, kCells.phi_cells, "packing", "fraction", "energy 1", "+-",
        "energy 2", "+-", "all", "+-", "RMSE 1", "RMSE", "BRDF", "noise");
  std::vector<ChartSeries> series(4);
  const char* const labels[] = {"energy of order 1", "energy of all orders",
                                "relative RMSE of order 1",
                                "relative RMSE of the BRDF, all orders"};
  for (int k = 0; k < 4; ++k) series[k].label = labels[k];
  for (const double packing : packings) {
    if (is_set(context.stop)) break;
    const double extinction = 3 * packing / (4 * kRadius), thickness = kDepth / extinction;
    const Stack bed = sphere_bed(kRadius, packing, thickness, kAlbedo);
    const Stack medium = parse_stack(
        fmt::format(
            "[[layer]]\nmedium = \"lambert_sphere\"\nalbedo = {}\nthickness = {}\ndensity = "
            "{}\n",
            kAlbedo, thickness, extinction),
        "reproduction", "medium");
    const RunResult grains = walked(bed, wi, kCells, walks, context);
    const RunResult flat = walked(medium, wi, kCells, 8 * walks, context);
    const auto compared = [&](const Estimate& a, const Estimate& b) {
      return Estimate{a.value / b.value - 1,
                      std::hypot(a.standard_error, b.standard_error) / b.value};
    };
    const Estimate one = compared(grains.reflected.orders[0][0], flat.reflected.orders[0][0]);
    const Estimate two = compared(grains.reflected.orders[1][0], flat.reflected.orders[1][0]);
    const Estimate all = compared(grains.reflected.total[0], flat.reflected.total[0]);
    const RelativeError first =
        relative_error(without_error(projected("single_scattering", &medium, wi, grains.grid)),
                       grains.reflected.lobes[0].value, grains.reflected.lobes[0].standard_error);
    const LobeEstimate& bed_all = grains.reflected.lobes[Order::all];
    const RelativeError medium_all =
        relative_error(flat.reflected.lobes[Order::all], bed_all.value, bed_all.standard_error);
    const RelativeError brdf = relative_error(
        without_error(projected(fmt::format("lambert_sphere_three_term,albedo={}", kAlbedo),
                                nullptr, wi, grains.grid)),
        bed_all.value, bed_all.standard_error);
    const double fraction = -std::expm1(-packing);
    if (context.table) {
      fmt::print(
          context.table,
          "{:>7g} {:>8.5f} | {:>8.5f} {:>7.1e} {:>8.5f} {:>7.1e} {:>8.5f} {:>7.1e} | {:>6.4f} "
          "{:>6.4f} {:>6.4f} {:>6.4f}\n",
          packing, fraction, one.value, one.standard_error, two.value, two.standard_error,
          all.value, all.standard_error, first.rmse, medium_all.rmse, brdf.rmse, brdf.noise);
      std::fflush(context.table);
    }
    rows.push_back({{"packing", packing},
                    {"fraction", fraction},
                    {"order_1", json_of(one)},
                    {"order_2", json_of(two)},
                    {"all", json_of(all)},
                    {"relative_rmse_order_1", first.rmse},
                    {"relative_rmse_medium", medium_all.rmse},
                    {"relative_rmse_brdf", brdf.rmse},
                    {"noise", brdf.noise}});
    const double x = std::log10(fraction);
    const double ys[] = {one.value, all.value, first.rmse, brdf.rmse};
    for (int k = 0; k < 4; ++k) {
      series[k].x.push_back(x);
      series[k].y.push_back(ys[k]);
      if (k < 2) series[k].error.push_back(k == 0 ? one.standard_error : all.standard_error);
    }
  }
  if (!series[3].y.empty())
    context.find(
        "the appearance of the beds approaches the BRDF as they grow sparse",
        fmt::format("relative RMSE of the BRDF from {:.1f} % at the densest to {:.1f} % at "
                    "the sparsest",
                    100 * series[3].y.front(), 100 * series[3].y.back()),
        series[3].y.back() < 0.5 * series[3].y.front());
  context.write("convergence",
                {.title = "A bed of Lambertian spheres against the Lambert-sphere medium",
                 .subtitle = "relative differences at \u03b8_i = 60\u00b0, with standard errors",
                 .x_label = "log\u2081\u2080 of the volume fraction",
                 .y_label = "relative difference",
                 .series = std::move(series)});
  return rows;
}

Json reproduce_vmf_figure_5(ReproductionContext& context) {
  constexpr double kAlbedo = 0.9, kThickness = 1;
  const Direction wi = direction_from_degrees(45, 0);
  const std::vector<double> radii = context.quality == Quality::draft
                                        ? std::vector<double>{0.2, 0.05}
                                        : std::vector<double>{0.2, 0.1, 0.05, 0.025, 0.0125};
  const std::vector<double> packings{0.8, 0.3};
  const std::uint64_t walks =
      std::max<std::uint64_t>(kBatches, context.walks / (radii.size() * packings.size()));
  Json rows = Json::array();
  Chart chart{.title = "Successively smaller spheres in a slab of one thickness",
              .subtitle = "relative RMSE of vmf_diffuse against the bed, all orders, no noise",
              .x_label = "log\u2082 of thickness over radius",
              .y_label = "relative RMSE",
              .series = {}};
  for (const double packing : packings) {
    if (is_set(context.stop)) break;
    const Stack finest = sphere_bed(radii.back(), packing, kThickness, kAlbedo);
    const GrainMeasurement measured =
        measure_grains(*finest.grains(), context.seed, realisations(context), kRays);
    const double r = measured.vmf.roughness.value;
    const ProjectedLobes model =
        projected(fmt::format("vmf_diffuse,roughness={},albedo={}", r, kAlbedo), nullptr, wi,
                  CellGrid{kCells.mu_cells, kCells.phi_cells, true});
    if (context.table)
      fmt::print(
          context.table,
          "packing {:g}: vMF roughness of the finest bed {:.4f} +- {:.1e}; theta_i 45, albedo "
          "{:g}\n{:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n",
          packing, r, measured.vmf.roughness.standard_error, kAlbedo, "radius", "leaks",
          "reflected", "+-", "order 1", "order 2", "RMSE 1", "RMSE all", "noise");
    ChartSeries curve{
        .label = fmt::format("packing {:g}, r = {:.3f}", packing, r), .x = {}, .y = {}};
    for (const double radius : radii) {
      if (is_set(context.stop)) break;
      const Stack bed = sphere_bed(radius, packing, kThickness, kAlbedo);
      const RunResult run = walked(bed, wi, kCells, walks, context);
      const double leaks = run.transmitted.total[0].value + run.uncollided[0].value;
      const RelativeError one = relative_error(run.reflected.lobes[0], model.lobes[0]);
      const RelativeError all = relative_error(run.reflected.lobes[Order::all], model.lobes[4]);
      if (context.table) {
        fmt::print(
            context.table,
            "{:>9g} {:>9.5f} {:>9.5f} {:>9.1e} {:>9.5f} {:>9.5f} {:>9.4f} {:>9.4f} {:>9.4f}\n",
            radius, leaks, run.reflected.total[0].value, run.reflected.total[0].standard_error,
            run.reflected.orders[0][0].value, run.reflected.orders[1][0].value, one.rmse, all.rmse,
            all.noise);
        std::fflush(context.table);
      }
      rows.push_back({{"packing", packing},
                      {"roughness", json_of(measured.vmf.roughness)},
                      {"radius", radius},
                      {"leaks", leaks},
                      {"reflected", json_of(run.reflected.total[0])},
                      {"order_1", json_of(run.reflected.orders[0][0])},
                      {"order_2", json_of(run.reflected.orders[1][0])},
                      {"relative_rmse_order_1", one.rmse},
                      {"relative_rmse", all.rmse},
                      {"noise", all.noise}});
      curve.x.push_back(std::log2(kThickness / radius));
      curve.y.push_back(all.rmse);
    }
    if (context.table) fmt::print(context.table, "\n");
    if (curve.y.size() == radii.size())
      context.find(
          "smaller spheres at a fixed ratio of radius to density come nearer to the BRDF, and "
          "the finest are near",
          fmt::format("packing {:g}: relative RMSE from {:.1f} % to {:.1f} %", packing,
                      100 * curve.y.front(), 100 * curve.y.back()),
          curve.y.back() < curve.y.front() && curve.y.back() < 0.15);
    chart.series.push_back(std::move(curve));
  }
  context.write("error", chart);
  return rows;
}

Json reproduce_vmf_figure_6(ReproductionContext& context) {
  // The packing at which a deep bed shows light from above normals of r = 0.4 (lamella measure);
  // the paper does not give its own.
  constexpr double kPacking = 2, kRadius = 1, kThickness = 40, kRoughness = 0.4, kAlpha = 1.4;
  const Stack bed = sphere_bed(kRadius, kPacking, kThickness, 1);
  const GrainMeasurement measured =
      measure_grains(*bed.grains(), context.seed, realisations(context), kRays);
  const BoundModel vmf = bind_model(
      parse_model_request(fmt::format("vmf_diffuse,roughness={},albedo=1", kRoughness)), nullptr);
  std::optional<BoundModel> beckmann;
  if (find_model("beckmann_diffuse"))
    beckmann = bind_model(
        parse_model_request(fmt::format("beckmann_diffuse,alpha={},albedo=1", kAlpha)), nullptr);
  const auto equivalent = equivalent_stack(bed, measured, Equivalent::vmf_flake);
  if (context.table)
    fmt::print(
        context.table,
        "white spheres, packing {:g}, {:g} radii deep; normals met first by light from above:\n"
        "r = {:.4f} +- {:.1e}\n",
        kPacking, kThickness / kRadius, measured.vmf.roughness.value,
        measured.vmf.roughness.standard_error);
  Json rows = Json::array();
  for (const double theta_i : {30.0, 60.0}) {
    if (is_set(context.stop)) break;
    const Direction wi = direction_from_degrees(theta_i, 0);
    std::vector<double> angles;
    std::vector<Direction> points;
    for (int a = -80; a <= 80; a += 8) {
      angles.push_back(a);
      points.push_back(direction_from_degrees(std::abs(a), a < 0 ? 180 : 0));
    }
    Simulation simulation(bed, make_plan(bed, {.max_order = 2}), wi, points, context.seed);
    run(simulation, {.walks = context.walks / 4, .target_error = {}, .seconds = {}}, {},
        context.stop);
    for (int order = 0; order < 2; ++order) {
      const auto model_value = [&](const BoundModel& m, Direction wo) {
        return m.model->eval_lobe(order, wi, wo).g;
      };
      ChartSeries grains{.label = "sphere bed", .x = angles, .y = {}, .error = {}, .dots = true};
      ChartSeries flakes{
          .label = fmt::format("vmf_diffuse, r = {:g}", kRoughness), .x = angles, .y = {}};
      ChartSeries field{.label = fmt::format("Beckmann height field, \u03b1 = {:g}", kAlpha),
                        .x = angles,
                        .y = {}};
      if (context.table)
        fmt::print(context.table, "\ntheta_i {:g}, bounce {}\n{:>8} {:>10} {:>9} {:>10} {:>10}\n",
                   theta_i, order + 1, "theta_o", "bed", "+-", "vMF", beckmann ? "Beckmann" : "");
      double square = 0, error_vmf = 0, error_beckmann = 0, variance = 0, above = 0, sum = 0;
      for (std::size_t k = 0; k < points.size(); ++k) {
        const std::size_t slot = static_cast<std::size_t>(order) * points.size() + k;
        const Estimate e =
            batch_estimate(simulation.batches(), [&](const BatchTally& b) { return b.f[slot]; });
        const double f = model_value(vmf, points[k]);
        const double g = beckmann ? model_value(*beckmann, points[k]) : 0;
        grains.y.push_back(e.value);
        grains.error.push_back(e.standard_error);
        flakes.y.push_back(f);
        field.y.push_back(g);
        if (context.table) {
          fmt::print(context.table, "{:>8g} {:>10.5f} {:>9.1e} {:>10.5f}", angles[k], e.value,
                     e.standard_error, f);
          fmt::print(context.table, "{}\n", beckmann ? fmt::format(" {:>10.5f}", g) : "");
        }
        // The hot spot, which no medium has, is left out of the error, as the paper says.
        const bool hot = std::abs(angles[k] - theta_i) < 12;
        Json entry{{"theta_i", theta_i},
                   {"bounce", order + 1},
                   {"theta_o", angles[k]},
                   {"bed", e.value},
                   {"standard_error", e.standard_error},
                   {"vmf", f},
                   {"hot_spot", hot}};
        if (beckmann) entry["beckmann"] = g;
        rows.push_back(std::move(entry));
        if (hot) continue;
        square += e.value * e.value;
        variance += e.standard_error * e.standard_error;
        error_vmf += (f - e.value) * (f - e.value);
        error_beckmann += (g - e.value) * (g - e.value);
        above += g - e.value;
        sum += e.value;
      }
      if (beckmann && order == 1)
        context.find(
            "at the second bounce the height field over-predicts, the porous BRDF has less "
            "error",
            fmt::format("theta_i {:g}: the height field is {:+.0f} % off on average; "
                        "relative RMSE {:.1f} %, vmf_diffuse {:.1f} %",
                        theta_i, 100 * above / sum,
                        100 * std::sqrt(std::max(0.0, error_beckmann - variance) / square),
                        100 * std::sqrt(std::max(0.0, error_vmf - variance) / square)),
            above > 0 && error_vmf < error_beckmann);
      if (context.table) {
        fmt::print(context.table,
                   "relative RMSE outside of the hot spot, without noise: vMF {:.4f}",
                   std::sqrt(std::max(0.0, error_vmf - variance) / square));
        if (beckmann)
          fmt::print(context.table, ", Beckmann {:.4f}",
                     std::sqrt(std::max(0.0, error_beckmann - variance) / square));
        fmt::print(context.table, "; noise {:.4f}\n", std::sqrt(variance / square));
      }
      Chart chart{.title = fmt::format("\u03b8_i = {:g}\u00b0, bounce {}", theta_i, order + 1),
                  .subtitle = "in the plane of incidence; \u03b8_o > 0 on the side of the light",
                  .x_label = "\u03b8_o [degrees]",
                  .y_label = "f [sr\u207b\u00b9]",
                  .series = {grains, flakes}};
      if (beckmann) chart.series.push_back(field);
      context.write(fmt::format("theta_{:g}_bounce_{}", theta_i, order + 1), chart);
    }
  }
  return rows;
}

}  // namespace lamella
