#include "volume/solver/deterministic_run.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "phase/math/larger_error.h"
#include "phase/stack/single_scattering.h"
#include "volume/quadrature/cell_quadrature.h"
#include "volume/solver/row_sampler.h"

namespace lamella {
namespace {

// Mean over a column of cells of cos(m (pi - phi)), by column and mode.
Eigen::MatrixXd column_cosines(const CellGrid& grid, int modes) {
  Eigen::MatrixXd cosines(grid.columns(), modes);
  const double width = grid.edge_phi(1);
  for (int column = 0; column < grid.columns(); ++column)
    for (int m = 0; m < modes; ++m) {
      const double half = m * width / 2;
      cosines(column, m) = std::cos(m * (kPi - grid.edge_phi(column) - width / 2)) *
                           (m == 0 ? 1 : std::sin(half) / half);
    }
  return cosines;
}

// Order 1 on the cells of one side.
std::vector<CellMean> single_scattering_cells(const Stack& stack, const CellGrid& grid,
                                              Direction wi, bool up,
                                              const std::vector<Rgb>& tolerance_of_row) {
  std::vector<CellMean> cells(grid.cells());
  // Mirror flakes and strong forward scattering peak about the mirror direction and straight on.
  const double mu_i = std::abs(wi.z);
  const std::vector<std::pair<double, double>> peaks{{mu_i, 0}, {mu_i, kPi}, {mu_i, 2 * kPi}};
  const double turn = azimuth(wi), side = up ? 1 : -1;
  tbb::parallel_for(0, grid.cells(), [&](int cell) {
    const int row = cell / grid.columns(), column = cell % grid.columns();
    cells[cell] = cell_mean(
        [&](double mu, double phi) {
          const SingleScattering s =
              single_scattering(stack, wi, direction_from_mu_phi(side * mu, turn + phi));
          return s.layers + s.substrate;
        },
        {grid.edge_mu(row + 1), grid.edge_mu(row), grid.edge_phi(column),
         grid.edge_phi(column + 1)},
        tolerance_of_row[row], peaks);
  });
  return cells;
}

// Whether there are mirror flakes, whose phase functions jump straight on.
bool has_mirrors(const Stack& stack) {
  return std::any_of(stack.layers.begin(), stack.layers.end(), [](const Layer& layer) {
    return traits(layer.medium).shape == PhaseShape::jump;
  });
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
      lobe.value.assign(channels * cells, 0);
      lobe.standard_error.assign(channels * cells, 0);
    }
    std::vector<Rgb> allowed(grid.rows());
    for (int row = 0; row < grid.rows(); ++row)
      for (int c = 0; c < 3; ++c)
        allowed[row][c] = kQuadratureShare * std::max(tolerance, 1e-12) *
                          sampler.row(i, std::min(c, channels - 1), up, row).scale;
    const std::vector<CellMean> single =
        single_scattering_cells(solution.stack(), grid, wi, up, allowed);
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
          for (int order = 0; order < kModeOrders; ++order) {
            double f = 0;
            for (int m = 0; m < modes; ++m)
              f += (m == 0 ? 1 : 2) * means.mode[order][m] * cosines(column, m);
            side.lobes[order + 1].value[k] = f;
            side.lobes[order + 1].standard_error[k] = means.error;
            all += f;
          }
          const double error = means.error + single[cell].error[c];
          side.lobes[kTallyOrders].value[k] = all;
          side.lobes[kTallyOrders].standard_error[k] = error;
          if (means.scale != 0) worst = larger_error(worst, error / means.scale);
        }
      }
    }
    return worst;
  }

  // An energy from the solver's nodes: its error is theirs and how far the cells are from it, which
  // tells that of order 2 where only the cells have it integrated.
  [[nodiscard]] Estimate energy(double on_nodes, const SideResult& side, int lobe, int c) const {
    const DeterministicAccuracy& accuracy = solution.accuracy();
    const std::size_t cells = grid.cells();
    double off = 0, error = accuracy.node_error;
    if (side.lobes[lobe].value.empty() || !solution.integrates_second())
      error += accuracy.second_error;
    if (!side.lobes[lobe].value.empty()) {
      double sum = 0;
      for (std::size_t k = 0; k < cells; ++k) sum += side.lobes[lobe].value[c * cells + k];
      off = std::abs(grid.projected_solid_angle() * sum - on_nodes);
    }
    return {on_nodes, off + error * std::abs(on_nodes)};
  }

  void energies(SideResult& side, const std::array<Rgb, kSolvedOrders>& on_nodes) const {
    for (int c = 0; c < channels; ++c) {
      for (int o = 0; o < kTallyOrders; ++o) side.orders[o][c] = energy(on_nodes[o][c], side, o, c);
      side.total[c] = energy(on_nodes[kTallyOrders][c], side, kTallyOrders, c);
    }
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
  const RowSampler sampler(solution, grid, plan.channels, plan.transmits, mu_i,
                           has_mirrors(solution.stack()), quadrature, stop,
                           [&](double share) { tell(share / 2); });
  const std::vector<DeterministicEnergies> energies = solution.energies(mu_i);
  const Assembly assembly{solution, sampler, grid, plan.channels, quadrature};
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
      assembly.energies(side, reflected                          ? energies[i].reflected
                              : solution.stack().is_half_space() ? energies[i].escaped
                                                                 : energies[i].transmitted);
    }
    for (int c = 0; c < plan.channels; ++c) {
      const double defect = std::abs(energies[i].sum()[c] - 1);
      run.uncollided[c] = {energies[i].uncollided[c], 0};
      run.absorbed[c] = {energies[i].absorbed[c],
                         defect + solution.accuracy().node_error * energies[i].absorbed[c]};
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
