#include "volume/harmonics/pair_cells.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

constexpr int kAlong = 8;  // points of a part, both ways
constexpr int kMaxHalvings = 12;
// Places between the points, as shares of a part, where its polynomial is held against f.
constexpr std::array<double, 3> kOffT{0.055, 0.5, 0.83}, kOffPhi{0.17, 0.5, 0.945};
constexpr double kShareOfPoint = 0.2;  // of the tolerance, for each point

using Coefficients = std::array<std::array<Rgb, kAlong>, kAlong>;  // by t, phi

// Legendre polynomials P_k(x).
std::array<double, kAlong> legendre(double x) {
  std::array<double, kAlong> values{1, x};
  for (int k = 1; k + 1 < kAlong; ++k)
    values[k + 1] = ((2 * k + 1) * x * values[k] - k * values[k - 1]) / (k + 1);
  return values;
}

// Column k: (2 k + 1) times the weight of each point times P_k there, which sum to coefficients.
const std::array<std::array<double, kAlong>, kAlong>& projection() {
  static const auto table = [] {
    std::array<std::array<double, kAlong>, kAlong> t{};
    const Quadrature& rule = cached_gauss_legendre(kAlong);
    for (int j = 0; j < kAlong; ++j) {
      const auto values = legendre(2 * rule.points[j] - 1);
      for (int k = 0; k < kAlong; ++k) t[j][k] = (2 * k + 1) * rule.weights[j] * values[k];
    }
    return t;
  }();
  return table;
}

// What a series leaves whose last coefficients are these: a geometric one by the ratio of pairs.
double left_over(const std::array<double, kAlong>& sizes) {
  const double last = std::max(sizes[kAlong - 1], sizes[kAlong - 2]);
  const double before = std::max(sizes[kAlong - 3], sizes[kAlong - 4]);
  if (last == 0) return 0;
  const double ratio = std::min(0.7, last / before);
  return last * ratio / (1 - ratio);
}

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

  // A part's polynomial.
  struct Fit {
    Part part;
    Coefficients c;

    [[nodiscard]] Rgb at(double t, double phi) const {
      const auto along_t = legendre(2 * (t - part.t0) / (part.t1 - part.t0) - 1);
      const auto along_phi = legendre(2 * (phi - part.phi0) / (part.phi1 - part.phi0) - 1);
      Rgb sum;
      for (int k = 0; k < kAlong; ++k)
        for (int l = 0; l < kAlong; ++l) sum += along_t[k] * along_phi[l] * c[k][l];
      return sum;
    }
  };

  void add(const Part& part, int halvings) {
    const Quadrature& rule = cached_gauss_legendre(kAlong);
    Fit fit{part, {}};
    Coefficients by_t{};
    Coefficients& c = fit.c;
    double of_points = 0;
    for (int a = 0; a < kAlong; ++a) {
      const double t = part.t0 + (part.t1 - part.t0) * rule.points[a];
      for (int b = 0; b < kAlong; ++b) {
        const double phi = part.phi0 + (part.phi1 - part.phi0) * rule.points[b];
        const MirrorPairs::Value f = value(t, phi);
        of_points += rule.weights[a] * rule.weights[b] * f.error;
        for (int k = 0; k < kAlong; ++k) by_t[k][b] += projection()[a][k] * f.f;
      }
    }
    for (int k = 0; k < kAlong; ++k)
      for (int b = 0; b < kAlong; ++b)
        for (int l = 0; l < kAlong; ++l) c[k][l] += projection()[b][l] * by_t[k][b];
    double along_t = 0, along_phi = 0;
    for (int channel = 0; channel < 3; ++channel) {
      std::array<double, kAlong> of_t{}, of_phi{};
      for (int k = 0; k < kAlong; ++k)
        for (int l = 0; l < kAlong; ++l) {
          const double square = c[k][l][channel] * c[k][l][channel];
          of_t[k] += square / (2 * l + 1);
          of_phi[l] += square / (2 * k + 1);
        }
      for (std::array<double, kAlong>* sizes : {&of_t, &of_phi})
        for (int k = 0; k < kAlong; ++k) (*sizes)[k] = std::sqrt((*sizes)[k] / (2 * k + 1));
      along_t = std::max(along_t, left_over(of_t));
      along_phi = std::max(along_phi, left_over(of_phi));
    }
    if (halvings < kMaxHalvings &&
        (along_t + along_phi > tolerance_ || off_points(fit) > tolerance_)) {
      Part first = part, second = part;
      if (along_t > along_phi)
        first.t1 = second.t0 = cut(part.t0, part.t1, t_edges_);
      else
        first.phi1 = second.phi0 = cut(part.phi0, part.phi1, phi_edges_);
      add(first, halvings + 1);
      add(second, halvings + 1);
      return;
    }
    take(part, c, std::max(along_t + along_phi, off_points(fit)) + of_points);
  }

  [[nodiscard]] MirrorPairs::Value value(double t, double phi) const {
    const double mu = std::sin(is_grazing_ ? t * t : t);
    return pairs_(wi_, direction_from_mu_phi(up_ ? mu : -mu, azimuth(wi_) + phi),
                  kShareOfPoint * tolerance_);
  }

  // The largest error of a polynomial at places between its points.
  [[nodiscard]] double off_points(const Fit& fit) const {
    double worst = 0;
    for (const double a : kOffT)
      for (const double b : kOffPhi) {
        const double t = fit.part.t0 + (fit.part.t1 - fit.part.t0) * a;
        const double phi = fit.part.phi0 + (fit.part.phi1 - fit.part.phi0) * b;
        const Rgb off = fit.at(t, phi) - value(t, phi).f;
        for (int x = 0; x < 3; ++x) worst = std::max(worst, std::abs(off[x]));
      }
    return worst;
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
  void take(const Part& part, const Coefficients& c, double error) {
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
          for (int l = 0; l < kAlong; ++l) mean.value += t[k] * phi[l] / size * c[k][l];
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
      const auto values = legendre(2 * (t - from) / (to - from) - 1);
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

}  // namespace

std::vector<std::optional<CellMean>> pair_cells(const MirrorPairs& pairs, const CellGrid& grid,
                                                Direction wi, bool up,
                                                const std::vector<int>& cells,
                                                const std::vector<Rgb>& tolerance_of_row,
                                                double width, const std::atomic<bool>* stop) {
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

}  // namespace lamella
