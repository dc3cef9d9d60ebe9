#include "volume/deterministic_run.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "phase/single_scattering.h"
#include "volume/cell_quadrature.h"
#include "volume/quadrature.h"

namespace lamella {
namespace {

// Panels in mu that hold whole rows of cells, and how many points the first round gives each.
constexpr int kPanels = 16, kPoints = 6, kMaxPoints = 48;
// Shares of the tolerance for the quadratures in mu and of order 1.
constexpr double kQuadratureShare = 0.1;
constexpr int kModeOrders = 3;  // orders 2, 3, 4+

// Where f is steep within a panel: at one of its ends, or nowhere.
enum class Steep { nowhere, low, high };

// Rows of cells, the first and last perhaps in part, with the points that sample them, in a
// parameter t from 0 to 1 of the elevation e, mu = sin e: odd modes behave like the sine of the
// polar angle, which is smooth in the angle only.
struct Panel {
  int first_row, end_row;
  double low, high;  // elevations
  Steep steep = Steep::nowhere;
  int points = kPoints;

  // Radiance behaves like mu log mu at grazing, and that of mirror flakes likewise about |mu_i|:
  // the distance from there as t^3 makes that smooth.
  [[nodiscard]] double elevation(double t) const {
    const double length = high - low, back = 1 - t;
    return steep == Steep::low    ? low + length * t * t * t
           : steep == Steep::high ? high - length * back * back * back
                                  : low + length * t;
  }
  [[nodiscard]] double mu(double t) const { return std::sin(elevation(t)); }
  // d mu / dt
  [[nodiscard]] double slope(double t) const {
    const double from = steep == Steep::high ? 1 - t : t;
    return std::cos(elevation(t)) * (high - low) * (steep == Steep::nowhere ? 1 : 3 * from * from);
  }
  // Within [0, 1], whatever mu is.
  [[nodiscard]] double parameter(double m) const {
    const double part = std::clamp((std::asin(m) - low) / (high - low), 0.0, 1.0);
    return steep == Steep::low    ? std::cbrt(part)
           : steep == Steep::high ? 1 - std::cbrt(1 - part)
                                  : part;
  }
};

// steep_at: cosines about which f is steep, besides 0.
std::vector<Panel> make_panels(const CellGrid& grid, const std::vector<double>& steep_at) {
  constexpr double kSame = 1e-9;  // elevations
  std::vector<double> steep{0}, ends;
  for (const double mu : steep_at) steep.push_back(std::asin(std::abs(mu)));
  const int count = std::min(grid.rows(), kPanels);
  for (int p = 0; p <= count; ++p) ends.push_back(std::asin(grid.edge_mu(p * grid.rows() / count)));
  for (const double e : steep) ends.push_back(e);
  std::sort(ends.begin(), ends.end());
  ends.erase(
      std::unique(ends.begin(), ends.end(), [](double x, double y) { return y - x < kSame; }),
      ends.end());
  const auto is_steep = [&](double e) {
    return std::any_of(steep.begin(), steep.end(),
                       [&](double s) { return std::abs(s - e) < kSame; });
  };
  std::vector<Panel> panels;
  const auto add = [&](double low, double high, Steep where) {
    Panel panel{grid.rows(), 0, low, high, where};
    for (int row = 0; row < grid.rows(); ++row)
      if (std::asin(grid.edge_mu(row)) > low + kSame &&
          std::asin(grid.edge_mu(row + 1)) < high - kSame) {
        panel.first_row = std::min(panel.first_row, row);
        panel.end_row = row + 1;
      }
    panels.push_back(panel);
  };
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    const double low = ends[k], high = ends[k + 1], middle = (low + high) / 2;
    const bool at_low = is_steep(low), at_high = is_steep(high);
    if (at_low && at_high) {
      add(low, middle, Steep::low);
      add(middle, high, Steep::high);
    } else {
      add(low, high, at_low ? Steep::low : at_high ? Steep::high : Steep::nowhere);
    }
  }
  return panels;
}

// Weights of a panel's points for its part of the cosine-weighted mean over each of its rows: the
// integral of the interpolating polynomial.
Eigen::MatrixXd row_weights(const Panel& panel, const CellGrid& grid) {
  const Quadrature& nodes = cached_gauss_legendre(panel.points);
  const Quadrature& rule = cached_gauss_legendre(panel.points + 4);
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(panel.end_row - panel.first_row, panel.points);
  for (int row = panel.first_row; row < panel.end_row; ++row) {
    const double t0 = panel.parameter(grid.edge_mu(row + 1));
    const double t1 = panel.parameter(grid.edge_mu(row));
    for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
      const double t = t0 + (t1 - t0) * rule.points[k];
      const double measure = (t1 - t0) * rule.weights[k] * panel.mu(t) * panel.slope(t);
      for (int j = 0; j < panel.points; ++j) {
        double basis = 1;
        for (int l = 0; l < panel.points; ++l)
          if (l != j) basis *= (t - nodes.points[l]) / (nodes.points[j] - nodes.points[l]);
        weights(row - panel.first_row, j) += measure * basis;
      }
    }
    const double above = grid.edge_mu(row), below = grid.edge_mu(row + 1);
    weights.row(row - panel.first_row) /= (above - below) * (above + below) / 2;
  }
  return weights;
}

// Rows k: values at a panel's points to the k-th coefficient of their Legendre series.
Eigen::MatrixXd legendre_transform(int points) {
  const Quadrature& nodes = cached_gauss_legendre(points);
  Eigen::MatrixXd transform(points, points);
  for (int j = 0; j < points; ++j) {
    const double x = 2 * nodes.points[j] - 1;
    double before = 0, now = 1;
    for (int k = 0; k < points; ++k) {
      transform(k, j) = (2 * k + 1) * nodes.weights[j] * now;
      const double next = ((2 * k + 1) * x * now - k * before) / (k + 1);
      before = now;
      now = next;
    }
  }
  return transform;
}

// What the terms beyond the last leave of an error in the means over a panel's rows, from the decay
// of the last two thirds of the series. Gauss's rule sees a whole panel to twice the degree of the
// interpolation that serves its parts.
double series_error(const Eigen::VectorXd& coefficients, bool one_row) {
  const Eigen::Index n = coefficients.size(), third = n / 3;
  const double middle = coefficients.segment(n - 2 * third, third).cwiseAbs().maxCoeff();
  const double last = coefficients.tail(third).cwiseAbs().maxCoeff();
  if (last == 0) return 0;
  const double decay = std::min(1.0, last / std::max(middle, last));
  return last * std::pow(decay, one_row ? 3 : 0.5);
}

// Means over one row of cells, or a panel's part of them.
struct RowModes {
  std::array<std::vector<double>, kModeOrders> mode;  // of orders 2, 3, 4+
  double scale = 0;                                   // what errors are relative to
  double error = 0;                                   // of all orders together, but order 1

  RowModes& operator+=(const RowModes& part) {
    for (int order = 0; order < kModeOrders; ++order) {
      std::vector<double>& sum = mode[order];
      sum.resize(std::max(sum.size(), part.mode[order].size()), 0.0);
      for (std::size_t m = 0; m < part.mode[order].size(); ++m) sum[m] += part.mode[order][m];
    }
    scale += part.scale;
    error += part.error;
    return *this;
  }
};

class RowSampler {
 public:
  RowSampler(const DeterministicSolution& solution, const CellGrid& grid, int channels,
             bool both_sides, std::vector<double> mu_i, bool steep_about_mu_i, double tolerance)
      : solution_(solution),
        grid_(grid),
        channels_(channels),
        sides_(both_sides ? 2 : 1),
        mu_i_(std::move(mu_i)),
        tolerance_(tolerance),
        rows_(mu_i_.size() * channels * sides_ * grid.rows()) {
    std::vector<Panel> panels = make_panels(grid, steep_about_mu_i ? mu_i_ : std::vector<double>());
    while (!panels.empty()) panels = sample(panels);
  }

  [[nodiscard]] const RowModes& row(std::size_t i, int channel, bool up, int row) const {
    return rows_[index(i, channel, up, row)];
  }

 private:
  [[nodiscard]] std::size_t index(std::size_t i, int channel, bool up, int row) const {
    return ((i * channels_ + channel) * sides_ + (up ? 0 : 1)) * grid_.rows() + row;
  }

  // Solves for the panels' points; returns those that need more of them.
  std::vector<Panel> sample(const std::vector<Panel>& panels) {
    std::vector<double> mu_o;
    for (const Panel& panel : panels) {
      const Quadrature& nodes = cached_gauss_legendre(panel.points);
      for (int j = 0; j < panel.points; ++j) mu_o.push_back(panel.mu(nodes.points[j]));
    }
    const std::size_t below = mu_o.size();
    if (sides_ == 2)
      for (std::size_t o = 0; o < below; ++o) mu_o.push_back(-mu_o[o]);
    const DeterministicField field = solution_.field(mu_i_, mu_o, true);
    std::vector<Panel> refined;
    std::size_t first = 0;
    for (const Panel& panel : panels) {
      const Eigen::MatrixXd weights = row_weights(panel, grid_);
      const Eigen::MatrixXd transform = legendre_transform(panel.points);
      const std::size_t rows = panel.end_row - panel.first_row;
      std::vector<RowModes> parts(mu_i_.size() * channels_ * sides_ * rows);
      std::atomic<bool> good = true;
      tbb::parallel_for(std::size_t{0}, mu_i_.size(), [&](std::size_t i) {
        for (int channel = 0; channel < channels_; ++channel)
          for (int side = 0; side < sides_; ++side)
            if (!take(panel, weights, transform, field, i, channel, first + side * below,
                      &parts[((i * channels_ + channel) * sides_ + side) * rows]))
              good = false;
      });
      first += panel.points;
      if (!good && panel.points < kMaxPoints) {
        refined.push_back(panel);
        refined.back().points *= 2;
        continue;
      }
      for (std::size_t k = 0; k < parts.size(); ++k)
        rows_[k / rows * grid_.rows() + panel.first_row + k % rows] += parts[k];
    }
    return refined;
  }

  // The panel's part of its rows, and whether its points are enough for this direction, channel and
  // side, whose points begin at `first`.
  bool take(const Panel& panel, const Eigen::MatrixXd& weights, const Eigen::MatrixXd& transform,
            const DeterministicField& field, std::size_t i, int channel, std::size_t first,
            RowModes* parts) const {
    const int n = panel.points, rows = panel.end_row - panel.first_row;
    const int modes = field.modes(channel);
    Eigen::VectorXd scale(n), error(n);
    for (int j = 0; j < n; ++j) {
      scale[j] = field.scale(channel, i, first + j);
      error[j] = field.error_of_mean(channel, i, first + j, grid_.edge_phi(1));
    }
    // One row's mean is Gauss's rule for f times its weight, which is smooth where f is not: f
    // grows like log mu at grazing for light that grazes.
    Eigen::VectorXd weight = Eigen::VectorXd::Ones(n);
    if (rows == 1)
      weight = weights.row(0).transpose().cwiseQuotient(cached_gauss_legendre(n).weights);
    double left = 0;
    Eigen::MatrixXd values(n, kModeOrders);
    std::vector<Eigen::MatrixXd> means;
    for (int m = 0; m < modes; ++m) {
      for (int j = 0; j < n; ++j)
        for (int order = 0; order < kModeOrders; ++order)
          values(j, order) = field.mode(channel, order + 1, m, i, first + j);
      means.emplace_back(weights * values);
      left += (m == 0 ? 1 : 2) *
              series_error(transform * weight.cwiseProduct(values.rowwise().sum()), rows == 1);
    }
    const Eigen::VectorXd row_scale = weights * scale, row_error = weights.cwiseAbs() * error;
    for (int r = 0; r < rows; ++r) {
      RowModes& row = parts[r];
      row.scale = row_scale[r];
      row.error = row_error[r] + left;
      for (int order = 0; order < kModeOrders; ++order) {
        row.mode[order].resize(modes);
        for (int m = 0; m < modes; ++m) row.mode[order][m] = means[m](r, order);
      }
    }
    return left <= kQuadratureShare * tolerance_ * row_scale.minCoeff();
  }

  const DeterministicSolution& solution_;
  const CellGrid& grid_;
  int channels_, sides_;
  std::vector<double> mu_i_;
  double tolerance_;
  std::vector<RowModes> rows_;
};

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
    return std::holds_alternative<MirrorFlakes<Sggx>>(layer.medium) ||
           std::holds_alternative<MirrorFlakes<Vmf>>(layer.medium);
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
      const int modes = static_cast<int>(sampler.row(i, c, up, 0).mode[0].size());
      const Eigen::MatrixXd cosines = column_cosines(grid, modes);
      for (int row = 0; row < grid.rows(); ++row) {
        const RowModes& means = sampler.row(i, c, up, row);
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
          if (means.scale > 0) worst = std::max(worst, error / means.scale);
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
                                          double tolerance) {
  const auto start = std::chrono::steady_clock::now();
  grid.folded = plan.folded && grid.phi_cells % 2 == 0;
  std::vector<double> mu_i;
  for (const Direction wi : incident) mu_i.push_back(with_grazing_limit(wi).z);
  // Quadratures finer than what the solver reached would cost time for nothing.
  const double quadrature = std::max(tolerance, solution.accuracy().error / 2);
  const RowSampler sampler(solution, grid, plan.channels, plan.transmits, mu_i,
                           has_mirrors(solution.stack()), quadrature);
  const std::vector<DeterministicEnergies> energies = solution.energies(mu_i);
  const Assembly assembly{solution, sampler, grid, plan.channels, quadrature};
  std::vector<RunResult> runs(incident.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
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
      if (up || plan.transmits) error = std::max(error, assembly.lobes(side, i, run.incident, up));
      assembly.energies(side, reflected                          ? energies[i].reflected
                              : solution.stack().is_half_space() ? energies[i].escaped
                                                                 : energies[i].transmitted);
    }
    run.accuracy->reached = error <= tolerance;
    for (int c = 0; c < plan.channels; ++c) {
      const double defect = std::abs(energies[i].sum()[c] - 1);
      run.uncollided[c] = {energies[i].uncollided[c], 0};
      run.absorbed[c] = {energies[i].absorbed[c],
                         defect + solution.accuracy().node_error * energies[i].absorbed[c]};
    }
  }
  const double seconds =
      solution.accuracy().seconds +
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (RunResult& run : runs) run.seconds = seconds / static_cast<double>(runs.size());
  return runs;
}

}  // namespace lamella
