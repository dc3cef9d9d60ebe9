#include "compare/nearest/fit_target.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "analytic/model/batched_model.h"
#include "compare/judge/cell_pieces.h"
#include "compare/judge/missing_light.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

constexpr int kAll = kTallyOrders;  // of SideResult::lobes
constexpr std::size_t kPairsPerTask = 2048, kPairsPerCall = 1 << 16;

// Nodes and weights of Gauss's rules on [-1, 1].
struct Node {
  double x, weight;
};
std::vector<Node> gauss_nodes(int points) {
  if (points == 2) return {{-std::sqrt(1.0 / 3), 1}, {std::sqrt(1.0 / 3), 1}};
  const double inner = std::sqrt(3.0 / 7 - 2.0 / 7 * std::sqrt(1.2));
  const double outer = std::sqrt(3.0 / 7 + 2.0 / 7 * std::sqrt(1.2));
  const double of_inner = (18 + std::sqrt(30.0)) / 36, of_outer = (18 - std::sqrt(30.0)) / 36;
  return {{-outer, of_outer}, {-inner, of_inner}, {inner, of_inner}, {outer, of_outer}};
}

}  // namespace

FitTarget fit_target(const std::vector<Truth>& truths, bool transmitted) {
  const RunResult& first = truths.front().run;
  FitTarget target{.grid = first.grid,
                   .channels = first.channels,
                   .is_bounded = first.is_bounded(),
                   .lobes = {},
                   .value = {},
                   .error = {}};
  for (std::size_t k = 0; k < truths.size(); ++k)
    for (const bool reflected : {true, false}) {
      if (!reflected && !transmitted) continue;
      const RunResult& run = truths[k].run;
      const LobeEstimate& lobe = (reflected ? run.reflected : run.transmitted).lobes[kAll];
      if (lobe.value.empty()) continue;
      target.lobes.push_back({with_grazing_limit(run.incident), reflected, k,
                              luminance(missing_energy(run, Order::all))});
      target.value.insert(target.value.end(), lobe.value.begin(), lobe.value.end());
      std::vector<double> error = lobe.standard_error;
      error.resize(lobe.value.size());
      target.error.insert(target.error.end(), error.begin(), error.end());
    }
  if (std::none_of(target.value.begin(), target.value.end(), [](double f) { return f > 0; }))
    throw std::invalid_argument("there is no light to fit to, deltas apart");
  return target;
}

CellPoints cell_points(const FitTarget& target, int points) {
  const std::vector<Node> nodes = gauss_nodes(points);
  CellPoints all;
  for (const TargetLobe& lobe : target.lobes) {
    const double side = (lobe.wi.z > 0) == lobe.reflected ? 1 : -1;
    const double phi_i = azimuth(lobe.wi);
    for (int cell = 0; cell < target.grid.cells(); ++cell) {
      const double norm = cell_norm(target.grid, cell);
      for (const CellPiece& piece : cell_pieces(target.grid, cell, lobe.wi)) {
        const double dmu = (piece.mu1 - piece.mu0) / 2, dphi = (piece.phi1 - piece.phi0) / 2;
        for (const Node& a : nodes)
          for (const Node& b : nodes) {
            const double mu = piece.mu0 + dmu * (1 + a.x);
            const double phi = phi_i + piece.phi0 + dphi * (1 + b.x);
            all.pairs.push_back({lobe.wi, direction_from_mu_phi(side * mu, phi)});
            all.weights.push_back(norm * dmu * dphi * a.weight * b.weight * mu);
          }
      }
      all.ends.push_back(all.pairs.size());
    }
  }
  return all;
}

std::vector<double> cell_means(const Model& model, const FitTarget& target,
                               const CellPoints& points, Isa isa) {
  const std::size_t count = points.pairs.size();
  std::vector<Rgb> values(count);
  const auto ask = [&](std::size_t from, std::size_t to) {
    model.eval(std::span(points.pairs).subspan(from, to - from),
               std::span(values).subspan(from, to - from), isa);
  };
  if (dynamic_cast<const BatchedModel*>(&model)) {
    for (std::size_t from = 0; from < count; from += kPairsPerCall)
      ask(from, std::min(from + kPairsPerCall, count));
  } else {
    // Blocks of one size, whichever thread takes them: lanes round in the same way then.
    const std::size_t tasks = (count + kPairsPerTask - 1) / kPairsPerTask;
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
      ask(task * kPairsPerTask, std::min((task + 1) * kPairsPerTask, count));
    });
  }
  const auto cells = static_cast<std::size_t>(target.grid.cells());
  std::vector<double> means(target.value.size());
  for (std::size_t k = 0; k < points.ends.size(); ++k) {
    Rgb mean;
    for (std::size_t n = k == 0 ? 0 : points.ends[k - 1]; n < points.ends[k]; ++n)
      mean += points.weights[n] * values[n];
    for (std::size_t c = 0; c < static_cast<std::size_t>(target.channels); ++c)
      means[(k / cells * static_cast<std::size_t>(target.channels) + c) * cells + k % cells] =
          mean[static_cast<int>(c)];
  }
  return means;
}

}  // namespace lamella
