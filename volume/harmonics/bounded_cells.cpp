#include "volume/harmonics/bounded_cells.h"

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "volume/quadrature/quadrature.h"
#include "volume/solver/critical_cosines.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kPoints = 7, kStrips = 5;
// Points of the rule that has fewer of them.
constexpr std::array<int, 5> kKept{0, 1, 3, 5, 6};
// Points in the azimuth of a cell.
constexpr int kAround = 4;

// Weights for the integral over (0, 1) at some points of a rule, exact for their polynomial.
VectorXd weights_of_kept(const Quadrature& rule) {
  const Index size = kKept.size();
  MatrixXd powers(size, size);
  VectorXd integrals(size);
  for (Index power = 0; power < size; ++power) {
    integrals[power] = 1.0 / static_cast<double>(power + 1);
    for (Index k = 0; k < size; ++k)
      powers(power, k) = std::pow(rule.points[kKept[k]], static_cast<double>(power));
  }
  VectorXd weights = VectorXd::Zero(rule.points.size());
  const VectorXd kept = powers.partialPivLu().solve(integrals);
  for (Index k = 0; k < size; ++k) weights[kKept[k]] = kept[k];
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

CellCosines::Side CellCosines::side_of(const std::vector<double>& critical) const {
  const Quadrature& rule = cached_gauss_legendre(kPoints);
  const VectorXd kept = weights_of_kept(rule);
  Side side;
  // sign: of the end at which points crowd like t^2, 0: none.
  const auto add = [&](int row, double low, double high, int sign) {
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
      side.coarse.push_back(kept[j] * measure);
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
  return side;
}

CellCosines::CellCosines(const CellGrid& grid, const Stack& stack) : grid_(grid) {
  up_ = side_of(critical_cosines(stack, true));
  for (const double mu : up_.mu) asked_.push_back({mu, 1});
  if (!stack.is_open_below()) return;
  down_ = side_of(critical_cosines(stack, false));
  down_.first = asked_.size();
  for (const double mu : down_.mu) asked_.push_back({mu, stack.index_of(stack.layers.size())});
}

HarmonicCells CellCosines::means(const BoundedSolution& solution, bool up, double turn) const {
  HarmonicCells cells;
  const Side& side = up ? up_ : down_;
  for (const int points : {kAround, kAround - 1}) {
    const std::vector<double> phi = azimuths_of(grid_, turn, points);
    const auto parts = solution.f(up, side.first, side.mu.size(), phi);
    const Quadrature& rule = cached_gauss_legendre(points);
    for (int part = 0; part < kHarmonicParts; ++part) {
      if (parts[part].size() == 0) continue;
      std::vector<double> mean(grid_.cells(), 0), coarse(grid_.cells(), 0);
      for (std::size_t j = 0; j < side.mu.size(); ++j)
        for (std::size_t p = 0; p < phi.size(); ++p) {
          const std::size_t cell = side.row[j] * grid_.columns() + p / points;
          const double f = rule.weights[static_cast<Index>(p % points)] *
                           parts[part](static_cast<Index>(j), static_cast<Index>(p));
          mean[cell] += side.weight[j] * f;
          coarse[cell] += side.coarse[j] * f;
        }
      if (points == kAround) {
        cells.value[part] = mean;
        for (std::size_t cell = 0; cell < mean.size(); ++cell)
          cells.error[part].push_back(std::abs(mean[cell] - coarse[cell]));
      } else {
        for (std::size_t cell = 0; cell < mean.size(); ++cell)
          cells.error[part][cell] += std::abs(cells.value[part][cell] - mean[cell]);
      }
    }
  }
  return cells;
}

}  // namespace lamella
