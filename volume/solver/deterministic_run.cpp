#include "volume/solver/deterministic_run.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "phase/math/larger_error.h"
#include "volume/quadrature/cell_quadrature.h"
#include "volume/solver/closed_cells.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/critical_cosines.h"
#include "volume/solver/diffuse_rows.h"
#include "volume/solver/row_sampler.h"

namespace lamella {
namespace {

// Errors of the nodes above it, as a share of f, say that they know no digit.
constexpr double kNoDigit = 0.1;
// How often the error of f at the probes an energy on the nodes may be off by, before cells are
// held against it: facets of alpha 1 have twice that error.
constexpr double kNodesReach = 4;
constexpr double kRounding = 1e-11;

// Whether there are mirror flakes, whose phase functions jump straight on.
bool has_mirrors(const Stack& stack) {
  return std::any_of(stack.layers.begin(), stack.layers.end(), [](const Layer& layer) {
    return !layer.interface && traits(layer.medium).shape == PhaseShape::jump;
  });
}

// Mirror flakes are steep about w_o = -w_i.
PanelEdges edges_of_panels(const Stack& stack, const std::vector<double>& mu_i) {
  PanelEdges edges{{}, critical_cosines(stack, true)};
  for (const double mu : critical_cosines(stack, false)) edges.root.push_back(mu);
  if (has_mirrors(stack))
    for (const double mu : mu_i) {
      edges.steep.push_back(std::abs(mu));
      edges.steep.push_back(bent_through(stack, mu));
    }
  return edges;
}

struct Assembly {
  const DeterministicSolution& solution;
  const RowSampler& sampler;
  const CellGrid& grid;
  int channels;
  double tolerance;

  // The lobes of one side; returns the largest error of a cell relative to the scale of its row.
  double lobes(SideResult& side, std::size_t i, Direction wi, bool up) const {
    const std::size_t cells = grid.cells();
    for (LobeEstimate& lobe : side.lobes) {
      // Lobes of order 0 and of orders 1 and up: only where a rough boundary makes one of order 0.
      const bool of_interfaces =
          &lobe == &side.lobes[Order::zero] || &lobe == &side.lobes[Order::scattered];
      if (of_interfaces && is_first_closed(solution.stack())) continue;
      lobe.value.assign(channels * cells, 0);
      lobe.standard_error.assign(channels * cells, 0);
    }
    std::vector<Rgb> allowed(grid.rows());
    for (int row = 0; row < grid.rows(); ++row)
      for (int c = 0; c < 3; ++c)
        allowed[row][c] = kQuadratureShare * std::max(tolerance, 1e-12) *
                          sampler.row(i, std::min(c, channels - 1), up, row).scale;
    const Stack& stack = solution.stack();
    const auto closed = [&](Rgb ClosedOrders::*order) {
      return closed_cells(stack, grid, wi, up, allowed,
                          [&, order](Direction wo) { return closed_orders(stack, wi, wo).*order; });
    };
    const bool is_rough = !is_first_closed(stack);
    const std::vector<CellMean> single =
        is_rough ? std::vector<CellMean>(cells) : closed(&ClosedOrders::one);
    const std::vector<CellMean> zero =
        is_rough ? closed(&ClosedOrders::zero) : std::vector<CellMean>();
    double worst = 0;
    for (int c = 0; c < channels; ++c) {
      // Rows have as many modes as their points needed.
      std::size_t most = 0;
      for (int row = 0; row < grid.rows(); ++row)
        most = std::max(most, sampler.row(i, c, up, row).mode[0].size());
      const Eigen::MatrixXd cosines = column_cosines(grid, static_cast<int>(most));
      for (int row = 0; row < grid.rows(); ++row) {
        const RowModes& means = sampler.row(i, c, up, row);
        const int modes = static_cast<int>(means.mode[0].size());
        for (int column = 0; column < grid.columns(); ++column) {
          const int cell = row * grid.columns() + column;
          const std::size_t k = c * cells + cell;
          side.lobes[0].value[k] = single[cell].value[c];
          side.lobes[0].standard_error[k] = single[cell].error[c];
          double all = single[cell].value[c];
          double error = means.error + single[cell].error[c];
          const auto sum_of = [&](const std::vector<double>& mode) {
            double f = 0;
            for (int m = 0; m < modes; ++m) f += (m == 0 ? 1 : 2) * mode[m] * cosines(column, m);
            return f;
          };
          double multiple = 0;
          for (int order = 0; order < kModeOrders; ++order) {
            const double f = sum_of(means.mode[order]);
            side.lobes[order + 1].value[k] = f;
            side.lobes[order + 1].standard_error[k] = means.error;
            multiple += f;
          }
          all += multiple;
          side.lobes[Order::multiple].value[k] = multiple;
          side.lobes[Order::multiple].standard_error[k] = means.error;
          if (is_rough) {
            const double first = sum_of(means.mode[kFirstInModes]);
            const double rest = sum_of(means.mode[kZeroInModes]);
            side.lobes[0].value[k] += first;
            side.lobes[0].standard_error[k] += means.error;
            side.lobes[Order::zero].value[k] = zero[cell].value[c] + rest;
            side.lobes[Order::zero].standard_error[k] = zero[cell].error[c] + means.error;
            all += first;
            side.lobes[Order::scattered].value[k] = all;
            side.lobes[Order::scattered].standard_error[k] = error;
            all += rest + zero[cell].value[c];
            error += zero[cell].error[c];
          }
          side.lobes[Order::all].value[k] = all;
          side.lobes[Order::all].standard_error[k] = error;
          if (means.scale != 0) worst = larger_error(worst, error / means.scale);
        }
      }
    }
    return worst;
  }

  // An energy from the solver's nodes: its error is theirs and how far the cells are from it, which
  // tells that of order 2 where only the cells have it integrated.
  // beams: what the cells do not hold of it.
  [[nodiscard]] Estimate energy(double on_nodes, double beams, const SideResult& side, int lobe,
                                int c) const {
    const DeterministicAccuracy& accuracy = solution.accuracy();
    const std::size_t cells = grid.cells();
    double off = 0, error = accuracy.node_error;
    if (side.lobes[lobe].value.empty() || !solution.integrates_second())
      error += accuracy.second_error;
    if (!side.lobes[lobe].value.empty()) {
      double sum = 0;
      for (std::size_t k = 0; k < cells; ++k) sum += side.lobes[lobe].value[c * cells + k];
      off = std::abs(grid.projected_solid_angle() * sum + beams - on_nodes);
    }
    return {on_nodes, off + error * std::abs(on_nodes)};
  }

  // Cells that miss a lobe between their points have bounds that miss it too. Their sum is known
  // from the nodes: what it lacks beyond the bounds of both may be in any one cell. Returns the
  // share of the mean f that a bound is then.
  double cover_shortfall(SideResult& side, double on_nodes, double beams, int lobe, int c) const {
    LobeEstimate& cells_of = side.lobes[lobe];
    if (cells_of.value.empty()) return 0;
    const DeterministicAccuracy& accuracy = solution.accuracy();
    const double error = accuracy.node_error + accuracy.second_error;
    // Nodes of which no digit is known cover nothing.
    const double covered =
        kRounding + (error < kNoDigit ? kNodesReach * error * std::abs(on_nodes) : 0);
    const std::size_t cells = grid.cells();
    double sum = 0, bound = 0;
    for (std::size_t k = c * cells; k < (c + 1) * cells; ++k) {
      sum += cells_of.value[k];
      bound += cells_of.standard_error[k];
    }
    const double one = grid.projected_solid_angle();
    const double off = std::abs(one * sum + beams - on_nodes) - covered;
    if (!(off > one * bound)) return 0;
    for (std::size_t k = c * cells; k < (c + 1) * cells; ++k)
      cells_of.standard_error[k] = std::max(cells_of.standard_error[k], off / one);
    return off / one / std::max(std::abs(on_nodes - beams) / kPi, kRounding);
  }

  struct SideEnergies {
    const OrderMap<Rgb>& orders;
    Rgb zero;
    const DeterministicEnergies* beams;  // of the side that has them
  };
  // Returns the largest share of the mean f that bounds of cells are for the sake of an energy.
  double energies(SideResult& side, const SideEnergies& on_nodes) const {
    double worst = 0;
    for (int c = 0; c < channels; ++c) {
      const auto beam = [&](int series) {
        return on_nodes.beams ? on_nodes.beams->specular_of[series][c] : 0;
      };
      const auto cover = [&](Order order, double energy, double beams) {
        worst = larger_error(worst, cover_shortfall(side, energy, beams, place(order), c));
      };
      const double all = on_nodes.orders[kTallyOrders][c], zero = on_nodes.zero[c];
      cover(Order::all, all, beam(kTallyOrders));
      cover(Order::zero, zero, beam(kTallyOrders + 1));
      cover(Order::scattered, all - zero, beam(kTallyOrders) - beam(kTallyOrders + 1));
      for (int o = 0; o < kTallyOrders; ++o)
        side.orders[o][c] = energy(on_nodes.orders[o][c], beam(o), side, o, c);
      side.multiple[c] = {};
      for (int o = place(Order::two); o < kTallyOrders; ++o) {
        side.multiple[c].value += side.orders[o][c].value;
        side.multiple[c].standard_error += side.orders[o][c].standard_error;
      }
      side.total[c] =
          energy(on_nodes.orders[kTallyOrders][c], beam(kTallyOrders), side, kTallyOrders, c);
      side.zero[c] = energy(on_nodes.zero[c], beam(kTallyOrders + 1), side, place(Order::zero), c);
      side.specular[c] = {beam(kTallyOrders), 0};
    }
    return worst;
  }
};

}  // namespace

std::vector<RunResult> deterministic_runs(const DeterministicSolution& solution, const Plan& plan,
                                          std::span<const Direction> incident, CellGrid grid,
                                          double tolerance, const std::atomic<bool>* stop,
                                          const SolverReport& report) {
  const auto start = std::chrono::steady_clock::now();
  // Half of the work is the rows' modes, half order 1 of the cells; more or less.
  const auto tell = [&](double share) {
    if (report)
      report({.task = SolverProgress::Task::cells,
              .nodes = solution.accuracy().nodes,
              .modes = solution.accuracy().modes,
              .error = solution.accuracy().error,
              .share = share,
              .seconds =
                  std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()});
  };
  tell(0);
  grid.folded = plan.folded && grid.phi_cells % 2 == 0;
  std::vector<double> mu_i;
  for (const Direction wi : incident) mu_i.push_back(with_grazing_limit(wi).z);
  // Quadratures finer than what the solver reached would cost time for nothing.
  const double quadrature = std::max(tolerance, solution.accuracy().error / 2);
  std::optional<RowSampler> sampler;
  std::vector<DeterministicEnergies> energies;
  tbb::parallel_invoke([&] { energies = solution.energies(mu_i); },
                       [&] {
                         sampler.emplace(solution, grid, plan.channels, plan.transmits, mu_i,
                                         edges_of_panels(solution.stack(), mu_i), quadrature, stop,
                                         [&](double share) { tell(share / 2); });
                       });
  const Assembly assembly{solution, *sampler, grid, plan.channels, quadrature};
  std::vector<RunResult> runs(incident.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    tell(0.5 + 0.5 * static_cast<double>(i) / static_cast<double>(runs.size()));
    RunResult& run = runs[i];
    run.incident = with_grazing_limit(incident[i]);
    run.estimator = Estimator::deterministic;
    run.grid = grid;
    run.channels = plan.channels;
    run.accuracy = solution.accuracy();
    double& error = run.accuracy->error;
    error = 0;
    for (const bool reflected : {true, false}) {
      SideResult& side = reflected ? run.reflected : run.transmitted;
      const bool up = (run.incident.z > 0) == reflected;
      if (up || plan.transmits)
        error = larger_error(error, assembly.lobes(side, i, run.incident, up));
      const DeterministicEnergies& e = energies[i];
      const bool half = solution.stack().is_half_space();
      const double added = assembly.energies(
          side, reflected ? Assembly::SideEnergies{e.reflected, e.zero_reflected, &e}
                : half    ? Assembly::SideEnergies{e.escaped, e.zero_escaped, nullptr}
                          : Assembly::SideEnergies{e.transmitted, e.zero_transmitted, nullptr});
      error = larger_error(error, added);
    }
    for (int c = 0; c < plan.channels; ++c) {
      const double defect = std::abs(energies[i].sum()[c] - 1);
      run.uncollided[c] = {energies[i].uncollided[c], 0};
      run.absorbed[c] = {energies[i].absorbed[c],
                         defect + solution.accuracy().node_error * energies[i].absorbed[c]};
      run.lost[c] = {energies[i].lost[c], solution.accuracy().node_error * energies[i].lost[c]};
      run.accuracy->energy_defect = larger_error(c == 0 ? 0 : run.accuracy->energy_defect, defect);
    }
    run.accuracy->reached = error <= tolerance && run.accuracy->energy_defect <= tolerance;
  }
  const double seconds =
      solution.accuracy().seconds +
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (RunResult& run : runs) run.seconds = seconds / static_cast<double>(runs.size());
  return runs;
}

}  // namespace lamella
