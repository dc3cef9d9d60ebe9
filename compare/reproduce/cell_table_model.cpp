#include "compare/reproduce/cell_table_model.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "compare/truth/ground_truth.h"

namespace lamella {
namespace {

constexpr CellGrid kCells{8, 16, false};
constexpr int kViews = 2 * 8 * 16;

// Two neighbours among the middles of cells and the share of the second.
struct Between {
  int first, second;
  double share;
};

Between row_at(double mu) {
  const double x = (1 - mu * mu) * kCells.mu_cells - 0.5;
  const int first = std::clamp(static_cast<int>(std::floor(x)), 0, kCells.mu_cells - 2);
  return {first, first + 1, std::clamp(x - first, 0.0, 1.0)};
}

Between column_at(double phi) {
  const double turns = phi / (2 * kPi);
  const double x = (turns - std::floor(turns)) * kCells.phi_cells - 0.5;
  const int first = static_cast<int>(std::floor(x)), count = kCells.phi_cells;
  return {(first + count) % count, (first + 1) % count, x - first};
}

Direction turned(Direction w, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * w.x - s * w.y, s * w.x + c * w.y, w.z};
}

int view_index(bool below, int row, int column) {
  return (below ? kCells.cells() : 0) + row * kCells.phi_cells + column;
}

}  // namespace

CellTable::CellTable(const Stack& stack, std::uint64_t walks, const ReproductionContext& context) {
  TruthRequest request{.stack = stack};
  request.directions.clear();
  for (const double side : {1.0, -1.0})
    for (int row = 0; row < kCells.mu_cells; ++row)
      for (int column = 0; column < kCells.phi_cells; ++column) {
        const double mu = side * std::sqrt(1 - (row + 0.5) / kCells.mu_cells);
        request.directions.push_back(
            direction_from_mu_phi(mu, 2 * kPi * (column + 0.5) / kCells.phi_cells));
      }
  request.estimator = Estimator::analog;
  request.given = {WalkSetting::walks};
  request.effort.walks = walks;
  request.cells = kCells;
  request.seed = context.seed;
  request.isa = isa_from_text("auto");
  RunMonitor monitor;
  monitor.stop = context.stop;
  GroundTruth truth(request, Estimator::analog, monitor);
  const auto cells = static_cast<std::size_t>(kCells.cells());
  values_.resize(kViews * 2 * cells);
  for (std::size_t k = 0; k < kViews && truth.goes_on(k); ++k) {
    const RunResult run = truth.find(k).run;
    const bool from_below = k >= cells;
    for (const bool below : {false, true}) {
      // Reflected light leaves on the side that it came from.
      const SideResult& side = below == from_below ? run.reflected : run.transmitted;
      const std::vector<double>& lobe = side.lobes[Order::multiple].value;
      if (lobe.empty()) continue;
      for (std::size_t i = 0; i < cells; ++i)
        for (int c = 0; c < 3; ++c)
          values_[(2 * k + below) * cells + i][c] =
              lobe[(run.channels == 1 ? 0 : static_cast<std::size_t>(c)) * cells + i];
    }
  }
}

Rgb CellTable::cell(int view, bool below, int row, int column) const {
  const auto cells = static_cast<std::size_t>(kCells.cells());
  return values_[(2 * static_cast<std::size_t>(view) + below) * cells +
                 static_cast<std::size_t>(row * kCells.phi_cells + column)];
}

Rgb CellTable::operator()(Direction wi, Direction wo) const {
  const Between view_row = row_at(wo.z), view_column = column_at(azimuth(wo));
  const Between row = row_at(wi.z);
  // Cells count the azimuth from that of the view, which lies in the middle of its own cell.
  const Between column = column_at(azimuth(wi) - azimuth(wo));
  Rgb sum;
  for (const auto& [vr, vr_weight] :
       {std::pair(view_row.first, 1 - view_row.share), std::pair(view_row.second, view_row.share)})
    for (const auto& [vc, vc_weight] : {std::pair(view_column.first, 1 - view_column.share),
                                        std::pair(view_column.second, view_column.share)})
      for (const auto& [r, r_weight] :
           {std::pair(row.first, 1 - row.share), std::pair(row.second, row.share)})
        for (const auto& [c, c_weight] :
             {std::pair(column.first, 1 - column.share), std::pair(column.second, column.share)})
          sum += vr_weight * vc_weight * r_weight * c_weight *
                 cell(view_index(wo.z < 0, vr, vc), wi.z < 0, r, c);
  return sum;
}

Rgb TabulatedStack::eval_lobe(int, Direction wi, Direction wo) const {
  return first_.eval(wi, wo) + (*table_)(turned(wi, -angle_), turned(wo, -angle_));
}

}  // namespace lamella
