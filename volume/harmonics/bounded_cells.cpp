#include "volume/harmonics/bounded_cells.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "volume/quadrature/quadrature.h"
#include "volume/solver/critical_cosines.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Points in the elevation of a part of a row, odd numbers; in the azimuth of a cell.
constexpr int kFewest = 7, kMost = 31;
constexpr int kFewestAround = 4, kMostAround = 16;
constexpr int kStrips = 5;
// Of the tolerance, for each of the two.
constexpr double kShare = 0.1;

int more_points(int points) { return std::min(kMost, (3 * points / 2) | 1); }

// Weights for the integral over (0, 1) at the points of a rule but the two beside the middle one,
// exact for their polynomial.
VectorXd weights_without_two(const Quadrature& rule) {
  const Index points = rule.points.size(), size = points - 2;
  std::vector<Index> kept;
  for (Index k = 0; k < points; ++k)
    if (std::abs(k - points / 2) != 1) kept.push_back(k);
  MatrixXd polynomials(size, size);  // Legendre's
  VectorXd integrals = VectorXd::Zero(size);
  integrals[0] = 1;
  for (Index k = 0; k < size; ++k) {
    const double x = 2 * rule.points[kept[k]] - 1;
    polynomials(0, k) = 1;
    polynomials(1, k) = x;
    for (Index l = 2; l < size; ++l)
      polynomials(l, k) = (static_cast<double>(2 * l - 1) * x * polynomials(l - 1, k) -
                           static_cast<double>(l - 1) * polynomials(l - 2, k)) /
                          static_cast<double>(l);
  }
  const VectorXd solved = polynomials.partialPivLu().solve(integrals);
  VectorXd weights = VectorXd::Zero(points);
  for (Index k = 0; k < size; ++k) weights[kept[k]] = solved[k];
  return weights;
}

// Means over each cell's azimuth, by Gauss-Legendre.
std::vector<double> azimuths_of(const CellGrid& grid, double turn, int points) {
  const Quadrature& rule = cached_gauss_legendre(points);
  std::vector<double> phi;
  for (int column = 0; column < grid.columns(); ++column)
    for (Index j = 0; j < rule.points.size(); ++j)
      phi.push_back(turn + grid.edge_phi(1) * (column + rule.points[j]));
  return phi;
}

}  // namespace

void CellCosines::place_points(Side& side, const std::vector<double>& critical) const {
  side.mu.clear();
  side.weight.clear();
  side.coarse.clear();
  side.row.clear();
  // sign: of the end at which points crowd like t^2, 0: none.
  const auto add = [&](int row, double low, double high, int sign) {
    const Quadrature& rule = cached_gauss_legendre(side.points[row]);
    const VectorXd fewer = weights_without_two(rule);
    const double above = grid_.edge_mu(row), below = grid_.edge_mu(row + 1);
    for (Index j = 0; j < rule.points.size(); ++j) {
      const double t = rule.points[j];
      const double share = sign < 0 ? t * t : sign > 0 ? t * (2 - t) : t;
      const double slope = sign < 0 ? 2 * t : sign > 0 ? 2 * (1 - t) : 1;
      const double e = low + (high - low) * share;
      const double measure = slope * (high - low) * std::sin(e) * std::cos(e) * 2 /
                             ((above - below) * (above + below));
      side.mu.push_back(std::sin(e));
      side.weight.push_back(rule.weights[j] * measure);
      side.coarse.push_back(fewer[j] * measure);
      side.row.push_back(row);
    }
  };
  for (int row = 0; row < grid_.rows(); ++row) {
    double high = std::asin(grid_.edge_mu(row));
    const double low = std::asin(grid_.edge_mu(row + 1));
    std::vector<double> ends{low};
    for (const double mu : critical)
      if (std::asin(mu) > low && std::asin(mu) < high) ends.push_back(std::asin(mu));
    const std::size_t last = ends.size();
    ends.push_back(high);
    for (std::size_t part = last; part-- > 0;) {
      high = ends[part + 1];
      for (int k = 1; ends[part] == 0 && k < kStrips; ++k, high /= 4) add(row, high / 4, high, 0);
      const bool cut_below = part > 0, cut_above = part + 1 < last;
      const double middle = (ends[part] + high) / 2;
      if (cut_below) add(row, ends[part], middle, -1);
      if (cut_above) add(row, middle, high, 1);
      if (cut_below && cut_above) continue;
      add(row, cut_below ? middle : ends[part], cut_above ? middle : high, 0);
    }
  }
}

CellCosines::CellCosines(const CellGrid& grid, const Stack& stack)
    : grid_(grid),
      critical_up_(critical_cosines(stack, true)),
      critical_down_(critical_cosines(stack, false)),
      is_open_below_(stack.is_open_below()),
      index_below_(stack.index_of(stack.layers.size())) {
  for (Side* side : {&up_, &down_}) {
    side->points.assign(grid.rows(), kFewest);
    side->wants.assign(grid.rows(), false);
  }
  place_points();
}

void CellCosines::place_points() {
  asked_.clear();
  place_points(up_, critical_up_);
  for (const double mu : up_.mu) asked_.push_back({mu, 1});
  if (!is_open_below_) return;
  place_points(down_, critical_down_);
  down_.first = asked_.size();
  for (const double mu : down_.mu) asked_.push_back({mu, index_below_});
}

bool CellCosines::refine() {
  bool is_any = false;
  for (Side* side : {&up_, &down_})
    for (int row = 0; row < grid_.rows(); ++row) {
      if (side->wants[row]) {
        side->points[row] = more_points(side->points[row]);
        is_any = true;
      }
      side->wants[row] = false;
    }
  if (is_any) place_points();
  return is_any;
}

HarmonicCells CellCosines::means(const BoundedSolution& solution, bool up, double turn,
                                 double tolerance) {
  Side& side = up ? up_ : down_;
  // Means by part; with the weights of fewer elevations.
  struct Sums {
    std::array<std::vector<double>, kHarmonicParts> mean, coarse;
  };
  const auto sums_of = [&](int points) {
    Sums sums;
    const std::vector<double> phi = azimuths_of(grid_, turn, points);
    const auto parts = solution.f(up, side.first, side.mu.size(), phi);
    const Quadrature& rule = cached_gauss_legendre(points);
    for (int part = 0; part < kHarmonicParts; ++part) {
      if (parts[part].size() == 0) continue;
      sums.mean[part].assign(grid_.cells(), 0);
      sums.coarse[part].assign(grid_.cells(), 0);
      for (std::size_t j = 0; j < side.mu.size(); ++j)
        for (std::size_t p = 0; p < phi.size(); ++p) {
          const std::size_t cell = side.row[j] * grid_.columns() + p / points;
          const double f = rule.weights[static_cast<Index>(p % points)] *
                           parts[part](static_cast<Index>(j), static_cast<Index>(p));
          sums.mean[part][cell] += side.weight[j] * f;
          sums.coarse[part][cell] += side.coarse[j] * f;
        }
    }
    return sums;
  };
  Sums before = sums_of(kFewestAround - 1);
  for (int points = kFewestAround;; points = std::min(kMostAround, 3 * points / 2)) {
    Sums now = sums_of(points);
    std::vector<double> allowed(grid_.rows(), 0);
    for (const int part : kSummedParts)
      for (std::size_t cell = 0; cell < now.mean[part].size(); ++cell)
        allowed[cell / grid_.columns()] +=
            kShare * tolerance * std::abs(now.mean[part][cell]) / grid_.columns();
    // By row, of all parts.
    std::vector<bool> is_enough_around(grid_.rows(), true), is_enough(grid_.rows(), true);
    HarmonicCells cells;
    for (int part = 0; part < kHarmonicParts; ++part)
      for (std::size_t cell = 0; cell < now.mean[part].size(); ++cell) {
        const std::size_t row = cell / grid_.columns();
        const double mean = now.mean[part][cell];
        const double around = std::abs(mean - before.mean[part][cell]);
        const double along = std::abs(mean - now.coarse[part][cell]);
        cells.error[part].push_back(around + along);
        if (!(around <= allowed[row])) is_enough_around[row] = false;
        if (!(along <= allowed[row])) is_enough[row] = false;
      }
    const bool is_done = std::find(is_enough_around.begin(), is_enough_around.end(), false) ==
                         is_enough_around.end();
    if (is_done || points == kMostAround) {
      for (int row = 0; row < grid_.rows(); ++row)
        if (!is_enough[row] && side.points[row] < kMost) side.wants[row] = true;
      cells.value = std::move(now.mean);
      return cells;
    }
    before = std::move(now);
  }
}

}  // namespace lamella
