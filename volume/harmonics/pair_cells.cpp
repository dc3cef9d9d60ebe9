#include "volume/harmonics/pair_cells.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "volume/harmonics/legendre_patch.h"
#include "volume/harmonics/pair_field.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

constexpr int kAlong = LegendrePatch::kAlong;
constexpr int kMaxHalvings = 12;
// From this number of cells on, one field serves all.
constexpr std::size_t kManyCells = 32;
constexpr double kShareOfPoint = 0.5;  // of the tolerance, for each point
// A part whose two middle lines leave this many times the tolerance is halved at once.
constexpr double kHopeless = 3;

// Rows and columns of cells whose f is summed up from polynomials.
class Block {
 public:
  Block(const MirrorPairs& pairs, const CellGrid& grid, Direction wi, bool up,
        const std::vector<Rgb>& tolerance_of_row, int row0, int row1, int column0, int column1)
      : pairs_(pairs),
        grid_(grid),
        wi_(wi),
        up_(up),
        row0_(row0),
        column0_(column0),
        columns_(column1 - column0) {
    means_.resize(static_cast<std::size_t>(row1 - row0) * columns_);
    tolerance_ = 1e300;
    for (int row = row0; row < row1; ++row)
      for (int c = 0; c < 3; ++c)
        if (tolerance_of_row[row][c] > 0)
          tolerance_ = std::min(tolerance_, tolerance_of_row[row][c]);
    // The row at grazing, where f behaves like mu log mu, in t = root of the elevation.
    is_grazing_ = row1 == grid.rows();
    for (int row = row0; row <= row1; ++row) t_edges_.push_back(t_of(grid.edge_mu(row)));
    for (int column = column0; column <= column1; ++column)
      phi_edges_.push_back(grid.edge_phi(column));
    add({t_edges_.back(), t_edges_.front(), phi_edges_.front(), phi_edges_.back()}, 0);
  }

  [[nodiscard]] const CellMean& mean(int row, int column) const {
    return means_[static_cast<std::size_t>(row - row0_) * columns_ + column - column0_];
  }

 private:
  struct Part {
    double t0, t1, phi0, phi1;
  };

  [[nodiscard]] double t_of(double mu) const {
    const double e = std::asin(mu);
    return is_grazing_ ? std::sqrt(e) : e;
  }

  void add(const Part& part, int halvings) {
    double of_points = 0;
    const auto f = [&](double u, double v) {
      const MirrorPairs::Value value =
          this->value(part.t0 + (part.t1 - part.t0) * u, part.phi0 + (part.phi1 - part.phi0) * v);
      of_points = std::max(of_points, value.error);
      return value.f;
    };
    const LegendrePatch::LeftOver on_axes = LegendrePatch::on_axes(f);
    if (on_axes.sum() > kHopeless * tolerance_ && halvings < kMaxHalvings) {
      halve(part, on_axes, halvings);
      return;
    }
    of_points = 0;
    const LegendrePatch patch(f);
    double error = patch.left_over().sum();
    if (error <= tolerance_ || halvings == kMaxHalvings) error = std::max(error, patch.off(f));
    if (error > tolerance_ && halvings < kMaxHalvings) {
      halve(part, patch.left_over(), halvings);
      return;
    }
    take(part, patch, error + of_points);
  }

  void halve(const Part& part, LegendrePatch::LeftOver left, int halvings) {
    Part first = part, second = part;
    if (left.u > left.v)
      first.t1 = second.t0 = cut(part.t0, part.t1, t_edges_);
    else
      first.phi1 = second.phi0 = cut(part.phi0, part.phi1, phi_edges_);
    add(first, halvings + 1);
    add(second, halvings + 1);
  }

  [[nodiscard]] MirrorPairs::Value value(double t, double phi) const {
    const double mu = std::sin(is_grazing_ ? t * t : t);
    return pairs_(wi_,
                  with_grazing_limit(direction_from_mu_phi(up_ ? mu : -mu, azimuth(wi_) + phi)),
                  kShareOfPoint * tolerance_);
  }

  // The edge between cells that is nearest to the middle, or the middle of a cell.
  static double cut(double from, double to, const std::vector<double>& edges) {
    const double middle = (from + to) / 2;
    double best = middle, distance = 1e300;
    for (const double edge : edges)
      if (edge > from + 1e-9 && edge < to - 1e-9 && std::abs(edge - middle) < distance) {
        best = edge;
        distance = std::abs(edge - middle);
      }
    return best;
  }

  // Adds a part to the means of the cells that it overlaps.
  void take(const Part& part, const LegendrePatch& patch, double error) {
    for (std::size_t row = 0; row + 1 < t_edges_.size(); ++row) {
      double of_weight = 0;
      const auto t = integrals(part.t0, part.t1, t_edges_[row + 1], t_edges_[row], true, of_weight);
      if (of_weight == 0) continue;
      for (std::size_t column = 0; column + 1 < phi_edges_.size(); ++column) {
        double width = 0;
        const auto phi = integrals(part.phi0, part.phi1, phi_edges_[column], phi_edges_[column + 1],
                                   false, width);
        if (width == 0) continue;
        CellMean& mean = means_[row * columns_ + column];
        const double size = grid_.projected_solid_angle() * (grid_.folded ? 0.5 : 1);
        for (int k = 0; k < kAlong; ++k)
          for (int l = 0; l < kAlong; ++l)
            mean.value += t[k] * phi[l] / size * patch.coefficient(k, l);
        mean.error += of_weight * width / size * Rgb(error);
      }
    }
  }

  // Of each polynomial of [from, to] over its part within [low, high]; total: of 1.
  [[nodiscard]] std::array<double, kAlong> integrals(double from, double to, double low,
                                                     double high, bool is_elevation,
                                                     double& total) const {
    std::array<double, kAlong> sum{};
    const double a = std::max(from, low), b = std::min(to, high);
    total = 0;
    if (b - a <= 1e-9) return sum;
    const Quadrature& rule = cached_gauss_legendre(kAlong + 4);
    for (Eigen::Index j = 0; j < rule.points.size(); ++j) {
      const double t = a + (b - a) * rule.points[j];
      double weight = (b - a) * rule.weights[j];
      if (is_elevation) {
        const double e = is_grazing_ ? t * t : t;
        weight *= std::sin(e) * std::cos(e) * (is_grazing_ ? 2 * t : 1);
      }
      const auto values = LegendrePatch::legendre(2 * (t - from) / (to - from) - 1);
      for (int k = 0; k < kAlong; ++k) sum[k] += weight * values[k];
      total += weight;
    }
    return sum;
  }

  const MirrorPairs& pairs_;
  const CellGrid& grid_;
  Direction wi_;
  bool up_, is_grazing_ = false;
  int row0_, column0_, columns_;
  double tolerance_;
  std::vector<double> t_edges_, phi_edges_;  // t falls with the row
  std::vector<CellMean> means_;
};

// Shares of a row's tolerance: the field's polynomials, and the quadrature over cells.
constexpr double kShareOfField = 0.7, kShareOfMean = 0.3;

double least_channel(Rgb tolerance) {
  double least = 1e300;
  for (int c = 0; c < 3; ++c)
    if (tolerance[c] > 0) least = std::min(least, tolerance[c]);
  return least;
}

bool has_field(const MirrorPairs& pairs, const std::vector<int>& cells) {
  return PairField::applies(pairs) && cells.size() >= kManyCells;
}

std::vector<std::optional<CellMean>> field_cells(const MirrorPairs& pairs, const CellGrid& grid,
                                                 Direction wi, bool up,
                                                 const std::vector<int>& cells,
                                                 const std::vector<Rgb>& tolerance_of_row,
                                                 const std::atomic<bool>* stop) {
  std::vector<std::optional<CellMean>> means(cells.size());
  const PairField field(
      pairs, wi, up,
      [&](double mu) {
        const int row = grid.cell(mu * mu, 0) / grid.columns();
        return kShareOfField * least_channel(tolerance_of_row[row]);
      },
      stop);
  if (!field.is_whole()) return means;
  tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t k) {
    const int row = cells[k] / grid.columns(), column = cells[k] % grid.columns();
    double of_field = 0;
    const auto f = [&](double mu, double phi) {
      const PairField::Value value =
          field.at(direction_from_mu_phi(up ? mu : -mu, azimuth(wi) + phi));
      of_field = std::max(of_field, value.error);
      return value.f;
    };
    const double allowed = kShareOfMean * least_channel(tolerance_of_row[row]);
    CellMean mean = cell_mean(f,
                              {grid.edge_mu(row + 1), grid.edge_mu(row), grid.edge_phi(column),
                               grid.edge_phi(column + 1)},
                              Rgb(allowed), {});
    mean.error += Rgb(of_field);
    means[k] = mean;
  });
  return means;
}

}  // namespace

std::vector<std::optional<CellMean>> pair_cells(const MirrorPairs& pairs, const CellGrid& grid,
                                                Direction wi, bool up,
                                                const std::vector<int>& cells,
                                                const std::vector<Rgb>& tolerance_of_row,
                                                double width, const std::atomic<bool>* stop) {
  if (has_field(pairs, cells))
    return field_cells(pairs, grid, wi, up, cells, tolerance_of_row, stop);
  std::vector<std::optional<CellMean>> means(cells.size());
  const auto along = [&](double cell) {
    return static_cast<int>(std::clamp(2 * width / cell, 1.0, 4.0));
  };
  const int rows = along(kPi / 2 / grid.rows()), columns = along(grid.edge_phi(1));
  // Blocks that hold a cell, in the order of the grid.
  std::vector<std::vector<std::size_t>> blocks;
  const int across = (grid.columns() + columns - 1) / columns;
  blocks.resize(static_cast<std::size_t>(across) * ((grid.rows() + rows - 1) / rows));
  for (std::size_t k = 0; k < cells.size(); ++k)
    blocks[cells[k] / grid.columns() / rows * across + cells[k] % grid.columns() / columns]
        .push_back(k);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
    if (blocks[b].empty() || (stop && *stop)) return;
    const int row = static_cast<int>(b) / across * rows;
    const int column = static_cast<int>(b) % across * columns;
    const Block block(pairs, grid, wi, up, tolerance_of_row, row, std::min(row + rows, grid.rows()),
                      column, std::min(column + columns, grid.columns()));
    for (const std::size_t k : blocks[b])
      means[k] = block.mean(cells[k] / grid.columns(), cells[k] % grid.columns());
  });
  return means;
}

std::optional<double> expected_seconds(const MirrorPairs& pairs, const CellGrid& grid, Direction wi,
                                       bool up, const std::vector<int>& cells,
                                       const std::vector<Rgb>& tolerance_of_row, double tolerance,
                                       double width) {
  if (!has_field(pairs, cells)) return std::nullopt;
  constexpr int kPairs = 24;
  const auto begin = std::chrono::steady_clock::now();
  tbb::parallel_for(0, kPairs, [&](int k) {
    const int row = k % grid.rows();
    const double mu = (grid.edge_mu(row) + grid.edge_mu(row + 1)) / 2;
    const double allowed = kShareOfField * least_channel(tolerance_of_row[row]);
    static_cast<void>(pairs(wi, direction_from_mu_phi(up ? mu : -mu, 2 * kPi * k / kPairs),
                            kShareOfPoint * allowed));
  });
  const double took =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return took / kPairs * PairField::expected_pairs(pairs, wi, tolerance, width);
}

}  // namespace lamella
