#include "compare/truth/lobe_table.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/request/errors.h"
#include "compare/request/first_look.h"
#include "compare/truth/estimator_choice.h"
#include "compare/truth/lobe_cells.h"
#include "volume/solver/answer_check.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

using Grid = HalfVectorGrid;

// Of the solver: what it aims for, and what is still far better than walks are; both relative to
// the mean over the azimuth.
constexpr double kTolerance = 1e-4, kStillUseful = 5e-3;
// What `auto` lets the solver spend. Nodes and modes end it, not the clock: equal runs are equal.
constexpr int kMostNodes = 64, kMostModes = 96;
constexpr double kMostSeconds = 30;
// Of walks whose number is not asked for.
constexpr double kWalkSeconds = 60;
// Incoming cosines between which solved modes are interpolated: less than a degree apart.
constexpr int kSolvedCosines = 120;

Rgb order_one(const Stack& stack, Direction wi, Direction wo) {
  return closed_orders(stack, wi, wo).one;
}

// Scales stand at this many places for every step between two nodes in mu_o.
constexpr std::size_t kScalesPerNode = 8;

// A place among equally spaced values, by the cubic through the four nearest.
double interpolated(const std::vector<double>& v, double place) {
  const auto node = static_cast<std::size_t>(place);
  const std::size_t from = std::min(node > 0 ? node - 1 : 0, v.size() - 4);
  const double x = place - static_cast<double>(from);
  return (-v[from] * (x - 1) * (x - 2) * (x - 3) + 3 * v[from + 1] * x * (x - 2) * (x - 3) -
          3 * v[from + 2] * x * (x - 1) * (x - 3) + v[from + 3] * x * (x - 1) * (x - 2)) /
         6;
}

}  // namespace

std::function<Rgb(Direction)> LobeTable::towards(Direction wo) const {
  // Away from the limit: where both directions graze, single scattering has none.
  const Direction o = raised_to(wo, Grid::kLeastMu);
  const double place = kScalesPerNode * Grid::place_of_mu(o.z);
  const auto k = std::min(static_cast<std::size_t>(place), scales_.size() - 2);
  const double x = place - static_cast<double>(k);
  const Rgb scale = (1 - x) * scales_[k] + x * scales_[k + 1];
  return [this, o, scale, rest = rest_.towards(o)](Direction wi) {
    const Direction i = raised_to(wi, Grid::kLeastMu);
    return order_one(stack_, i, o) + scale * rest(i);
  };
}

std::optional<std::string> LobeTable::solve(const Stack& stack, bool must, const StopFlag* stop,
                                            const SolverReport& report) {
  DeterministicOptions options;
  options.tolerance = kTolerance;
  options.stop = stop;
  options.report = report;
  if (!must) {
    options.max_nodes = kMostNodes;
    options.max_modes = kMostModes;
    options.max_seconds = kMostSeconds;
  }
  const DeterministicSolution solution = solve_deterministic(stack, options);
  if (auto reason = why_no_answer(solution.accuracy())) return reason;
  const double reached = solution.accuracy().error;
  if (!must && !(reached <= kStillUseful)) return fmt::format("its error is {:.1e}", reached);
  const auto solved_mu = [](int k) {
    return Grid::node_mu(k * (Grid::kOut - 1.0) / (kSolvedCosines - 1));
  };
  std::vector<double> in, out;
  for (int k = 0; k < kSolvedCosines; ++k) in.push_back(solved_mu(k));
  for (int k = 0; k < Grid::kOut; ++k) out.push_back(Grid::node_mu(k));
  const DeterministicField field = solution.field(in, out);
  tbb::parallel_for(0, Grid::kOut, [&](int o) {
    for (int a = 0; a < Grid::kAlpha; ++a)
      for (int b = 0; b < Grid::kBeta; ++b) {
        const Direction wi = Grid::node_wi(Grid::node_mu(o), a, b);
        const double place = Grid::place_of_mu(wi.z) * (kSolvedCosines - 1) / (Grid::kOut - 1.0);
        const int i = std::clamp(static_cast<int>(place), 0, kSolvedCosines - 2);
        const double x = place - i, angle = kPi - azimuth(wi);
        const auto value = [&](int node) {
          return field.multiple(static_cast<std::size_t>(node), static_cast<std::size_t>(o), angle)
              .order[4];
        };
        rest_.at(o, a, b) = (1 - x) * value(i) + x * value(i + 1);
      }
  });
  for (int o = 0; o < Grid::kOut; ++o)
    for (int a = 0; a < Grid::kAlpha; ++a)
      for (int b = 0; b < Grid::kBeta; ++b)
        if (const Rgb f = rest_.at(o, a, b); !std::isfinite(f.r + f.g + f.b))
          return "its numbers are not finite";
  for (const DeterministicEnergies& e : solution.energies(out)) {
    RestEnergy energy;
    // Beams are in no table.
    energy.total = e.reflected[4] - e.specular_of[4];
    energy.direct = energy.total - (e.reflected[0] - e.specular_of[0]);
    for (int c = 0; c < 3; ++c) {
      energy.direct_error[c] = reached * energy.direct[c];
      energy.total_error[c] = std::abs(e.sum()[c] - 1);
    }
    energies_.push_back(energy);
  }
  source_ = fmt::format("adding and doubling, {} {:.1g}",
                        solution.accuracy().reached ? "tolerance" : "no further than",
                        solution.accuracy().reached ? kTolerance : reached);
  return std::nullopt;
}

void LobeTable::walk(const TruthRequest& request, const StopFlag* stop) {
  const Plan plan = plan_of(request);
  double mirrored_by_flakes = 0;
  FirstLook look(request, Grid::kOut, kWalkSeconds, kPreviewWalks);
  std::uint64_t fewest = request.effort.walks;
  for (int o = 0; o < Grid::kOut; ++o) {
    // Reflection is reciprocal here: the walks begin where the viewer is.
    const double mu = Grid::node_mu(o);
    std::vector<Direction> points;
    for (int a = 0; a < Grid::kAlpha; ++a)
      for (int b = 0; b < Grid::kBeta; ++b) points.push_back(Grid::node_wi(mu, a, b));
    Simulation simulation(request.stack, plan, direction_from_mu_phi(mu, 0), points, request.seed);
    run(simulation, look.next(), {}, stop);
    fewest = std::min(fewest, simulation.walks());
    RestEnergy energy;
    for (int c = 0; c < 3; ++c) {
      const int channel = std::min(c, plan.channels - 1);
      for (std::size_t j = 0; j < points.size(); ++j) {
        const auto rest = [&](const BatchTally& b) {
          double sum = 0;
          for (int order = 1; order < kTallyOrders; ++order)
            sum +=
                b.f[static_cast<std::size_t>(order * plan.channels + channel) * points.size() + j];
          return sum;
        };
        rest_.at(o, static_cast<int>(j) / Grid::kBeta, static_cast<int>(j) % Grid::kBeta)[c] =
            batch_estimate(simulation.batches(), rest).value;
      }
      const auto reflected = [&](int from) {
        return batch_estimate(simulation.batches(), [&](const BatchTally& b) {
          double sum = 0;
          for (int order = from; order < kTallyOrders; ++order) sum += b.energy.up[order][channel];
          return sum;
        });
      };
      // What thinning has taken is 0 on average. With it a half space that absorbs nothing
      // reflects 1 in every batch, without noise.
      const Estimate total = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
        double sum = b.energy.thinned[channel];
        for (int order = 0; order < kTallyOrders; ++order) sum += b.energy.up[order][channel];
        return sum;
      });
      const Estimate direct = reflected(1);
      energy.total[c] = total.value;
      energy.total_error[c] = total.standard_error;
      energy.direct[c] = direct.value;
      energy.direct_error[c] = direct.standard_error;
      for (const BatchTally& b : simulation.batches())
        mirrored_by_flakes += b.energy.specular_up[channel];
    }
    energies_.push_back(energy);
  }
  source_ =
      fmt::format("{} next-event walks for each of {} outgoing cosines{}", fewest, Grid::kOut,
                  fewest < request.effort.walks && !is_set(stop)
                      ? fmt::format(" or more, of {} in {:g} s", request.effort.walks, kWalkSeconds)
                      : "");
  // Straight on every azimuth is the same: what walks found at each of them is one value.
  for (int a = 0; a < Grid::kAlpha; ++a) {
    Rgb mean;
    for (int b = 0; b < Grid::kBeta; ++b) mean += 1.0 / Grid::kBeta * rest_.at(0, a, b);
    for (int b = 0; b < Grid::kBeta; ++b) rest_.at(0, a, b) = mean;
  }
  // Light that met mirrors only leaves as a delta, which no picture here has: energies with it say
  // nothing of the table.
  if (mirrored_by_flakes > 0) {
    energies_.clear();
    source_ += ", without the mirror image of its delta flakes";
  }
}

void LobeTable::scale_to_energies() {
  const std::size_t count = kScalesPerNode * (Grid::kOut - 1) + 1;
  scales_.assign(count, Rgb(1));
  if (energies_.empty()) return;
  std::vector<Rgb> first(count), shape(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t k) {
    const double mu = Grid::node_mu(static_cast<double>(k) / kScalesPerNode);
    const Direction wo = direction_from_mu_phi(mu, 0);
    const auto raised = [](Direction wi) { return raised_to(wi, Grid::kLeastMu); };
    first[k] =
        lobe_cells([&](Direction wi) { return order_one(stack_, raised(wi), wo); }, mu).energy;
    shape[k] =
        lobe_cells([&, rest = rest_.towards(wo)](Direction wi) { return rest(raised(wi)); }, mu)
            .energy;
  });
  for (int c = 0; c < 3; ++c) {
    // At the nodes: of the table's orders, and of all.
    std::vector<double> rest, all;
    bool total_is_better = true;
    for (std::size_t o = 0; o < energies_.size(); ++o) {
      const RestEnergy& e = energies_[o];
      const double order_one_energy = first[kScalesPerNode * o][c];
      const bool better = e.total_error[c] + kLobeTolerance * order_one_energy < e.direct_error[c];
      total_is_better = total_is_better && better;
      rest.push_back(std::max(better ? e.total[c] - order_one_energy : e.direct[c], 0.0));
      all.push_back(e.total[c]);
    }
    for (std::size_t k = 0; k < count; ++k) {
      if (!(shape[k][c] > 0)) continue;
      // Order 1 is known everywhere: where the energy of all orders is better known it is what is
      // interpolated, so that a white half space stays white between the nodes.
      const double place = static_cast<double>(k) / kScalesPerNode;
      const double wanted =
          total_is_better ? interpolated(all, place) - first[k][c] : interpolated(rest, place);
      scales_[k][c] = std::max(wanted, 0.0) / shape[k][c];
    }
  }
}

LobeTable LobeTable::make(const TruthRequest& request, const StopFlag* stop,
                          const SolverReport& report) {
  LobeTable table;
  table.stack_ = request.stack;
  check_estimator(request, TruthAt::pairs);
  // The lobe of a rough boundary is too narrow for a table, and order 1 is not closed behind it.
  const bool solvable = !why_not_deterministic(request.stack) && is_first_closed(request.stack) &&
                        request.given.empty();
  const bool must = request.estimator == Estimator::deterministic;
  std::optional<std::string> unsolved = "not tried";
  if (must || (solvable && !request.estimator)) {
    unsolved = table.solve(request.stack, must, stop, report);
    if (unsolved && must) refuse_answer(request.stack, *unsolved);
  }
  if (unsolved) table.walk(request, stop);
  table.scale_to_energies();
  return table;
}

void check_preview(const std::string& what, const Stack& stack) {
  const char* found = !stack.is_symmetric_about_z() ? "a stack with a preferred azimuth"
                      : stack.grains()              ? "explicit geometry"
                      : stack.has_grid()            ? "a density grid"
                      : stack.has_interfaces()      ? "interfaces"
                      : stack.has_boundaries()      ? "a substrate beyond Lambert's law"
                                                    : nullptr;
  if (found)
    throw UsageError(fmt::format(
        "{} {}: found {}; allowed: homogeneous layers of one index, symmetric about z, over "
        "Lambert's substrate or none",
        what, stack.name, found));
}

}  // namespace lamella
