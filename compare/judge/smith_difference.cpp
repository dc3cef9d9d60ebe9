#include "compare/judge/smith_difference.h"

#include <fmt/format.h>

#include "compare/request/errors.h"
#include "compare/request/percent.h"
#include "compare/truth/ground_truth.h"
#include "phase/math/degrees.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

// White facets of these slopes: once, or until the light leaves them.
Stack smith_surface(double alpha, Order order) {
  return parse_stack(
      fmt::format("[substrate]\nbsdf = \"conductor\"\neta = 1\nk = 0\nfresnel = \"one\"\n"
                  "distribution = \"beckmann\"\nroughness = {:.17g}\nscattering = \"{}\"\n",
                  alpha, order == Order::one ? "single" : "multiple"),
      "Smith's surface", "Smith's surface");
}

}  // namespace

std::vector<SmithDifference> smith_difference(const TruthRequest& request,
                                              const RunMonitor& monitor) {
  const GrainGeometry* field = request.stack.grains();
  if (!field || !field->is_height_field() || field->surface != GrainSurface::mirror)
    throw UsageError(fmt::format(
        "measure: found {}, which is no height_field of mirrors; allowed: surface = \"mirror\", "
        "whose reflection Smith's surface has, too",
        request.stack.name));
  TruthRequest of_field = request;
  of_field.estimator = Estimator::analog;
  of_field.given = {WalkSetting::walks};
  GroundTruth heights(of_field, Estimator::analog, monitor);
  std::vector<RunResult> runs;
  for (std::size_t k = 0; heights.goes_on(k); ++k) runs.push_back(heights.find(k).run);
  std::vector<SmithDifference> rows;
  for (const Order order : {Order::one, Order::all}) {
    TruthRequest of_smith = of_field;
    of_smith.stack = smith_surface(field->alpha, order);
    // Walks of their own.
    of_smith.seed += 1ULL << 33;
    GroundTruth smith(of_smith, Estimator::analog, monitor);
    for (std::size_t k = 0; k < runs.size() && smith.goes_on(k); ++k) {
      // The whole surface is one event of these walks, however many facets light meets.
      const SideResult &a = runs[k].reflected, b = smith.find(k).run.reflected;
      const Estimate of_a = order == Order::all ? a.total[0] : a.orders[0][0];
      const LobeEstimate& lobe = b.lobes[Order::all];
      rows.push_back({request.directions[k], order, of_a.value, of_a.standard_error,
                      b.total[0].value, b.total[0].standard_error,
                      relative_error(a.lobes[order], lobe.value, lobe.standard_error)});
    }
  }
  return rows;
}

std::string smith_difference_table(const std::vector<SmithDifference>& rows) {
  std::string text = fmt::format("  {:>8} {:>6} {:>9} {:>8} {:>9} {:>8} {:>10} {:>9}\n", "theta_i",
                                 "order", "heights", "+-", "Smith's", "+-", "rel. RMSE", "noise");
  for (const SmithDifference& r : rows)
    text += fmt::format("  {:>8.4g} {:>6} {:>9.5f} {:>8.1e} {:>9.5f} {:>8.1e} {:>10} {:>9}\n",
                        theta_degrees(r.wi), to_text(r.order), r.energy_field, r.energy_field_error,
                        r.energy_smith, r.energy_smith_error, percent_text(r.cells.rmse),
                        percent_text(r.cells.noise));
  return text +
         "\n  heights, Smith's: energies of the light that white mirrors reflect\n"
         "  rel. RMSE: of the cells, the noise of both removed; differences below about half the\n"
         "    noise are not seen\n";
}

}  // namespace lamella
