#include "volume/harmonics/harmonic_solution.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "volume/quadrature/quadrature.h"

namespace lamella {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double HarmonicEnergies::sum() const {
  double all = uncollided + absorbed + zero_up + zero_down + mirrored + lost;
  for (int k = 0; k < 4; ++k) all += up[k] + down[k];
  return all;
}

HarmonicSolution::HarmonicSolution(const HarmonicTransport& transport, Direction wi)
    : transport_(transport), wi_(wi) {
  HarmonicTransport::First first = transport.first(wi);
  energies_.uncollided = first.uncollided;
  energies_.absorbed = first.absorbed;
  const auto take = [&](int order, const HarmonicLight& light) {
    energies_.up[order] = light.reflected;
    energies_.down[order] = light.transmitted;
    energies_.absorbed += light.absorbed;
  };
  take(0, first.light);
  sources_[0] = std::move(first.light.next);
  sources_[kWithoutPairs] = std::move(first.without_pairs);
  HarmonicLight second = transport.follow(sources_[0]);
  take(1, second);
  sources_[1] = std::move(second.next);
  const HarmonicLight third = transport.follow(sources_[1]);
  take(2, third);
  sources_[2] = transport.sum(third.next);
  take(3, transport.follow(sources_[2]));
  for (int k = 0; k < kOpenParts; ++k) ground_[k] = sources_[k].ground;
}

std::array<double, kHarmonicParts> HarmonicSolution::f(Direction wo) const {
  VectorXd harmonics(transport_.basis().size());
  transport_.basis().values(wo, harmonics);
  std::array<VectorXd, kOpenParts> values;
  std::array<const double*, kOpenParts> places{};
  for (int k = 0; k < kOpenParts; ++k) {
    values[k] = sources_[k].coefficients.transpose() * harmonics;
    places[k] = values[k].data();
  }
  std::array<double, kHarmonicParts> f{};
  transport_.leaving(wo, places, ground_, f.data());
  return f;
}

VectorXd HarmonicSolution::multiple(std::span<const Direction> wo,
                                    const MatrixXd& harmonics) const {
  MatrixXd sum = sources_[0].coefficients;
  double ground = ground_[0];
  for (int k = 1; k < kHarmonicOrders; ++k) {
    sum += sources_[k].coefficients;
    ground += ground_[k];
  }
  const MatrixXd values = transport_.product()(sum.transpose(), harmonics);
  VectorXd f(static_cast<Index>(wo.size()));
  tbb::parallel_for(std::size_t{0}, wo.size(), [&](std::size_t k) {
    const double* places[] = {values.col(static_cast<Index>(k)).data()};
    const double grounds[] = {ground};
    transport_.leaving(wo[k], places, grounds, &f[static_cast<Index>(k)]);
  });
  return f;
}

// Gauss-Legendre in the azimuth of every cell and, with two points more, in its elevation; the row
// at grazing, where radiance behaves like mu log mu, in strips.
std::array<std::vector<double>, kOpenParts> HarmonicSolution::means(const CellGrid& grid, bool up,
                                                                    int points) const {
  constexpr int kStrips = 5;
  const Quadrature& rule = cached_gauss_legendre(points);
  const Quadrature& along = cached_gauss_legendre(points + 2);
  struct Strip {
    int row;
    double low, high;  // elevations
  };
  std::vector<Strip> strips;
  for (int row = 0; row < grid.rows(); ++row) {
    double high = std::asin(grid.edge_mu(row));
    const double low = std::asin(grid.edge_mu(row + 1));
    for (int k = 1; low == 0 && k < kStrips; ++k, high /= 4)
      strips.push_back({row, high / 4, high});
    strips.push_back({row, low, high});
  }
  std::vector<double> mu, weight, phi;
  std::vector<int> row_of;
  for (const Strip& strip : strips)
    for (Index j = 0; j < along.points.size(); ++j) {
      const double e = strip.low + (strip.high - strip.low) * along.points[j];
      const double above = grid.edge_mu(strip.row), below = grid.edge_mu(strip.row + 1);
      mu.push_back(up ? std::sin(e) : -std::sin(e));
      weight.push_back((strip.high - strip.low) * along.weights[j] * std::sin(e) * std::cos(e) * 2 /
                       ((above - below) * (above + below)));
      row_of.push_back(strip.row);
    }
  const double turn = azimuth(wi_), width = grid.edge_phi(1);
  for (int column = 0; column < grid.columns(); ++column)
    for (Index j = 0; j < rule.points.size(); ++j)
      phi.push_back(turn + width * (column + rule.points[j]));
  const SphereGrid directions(transport_.basis(), mu, phi, transport_.product());
  std::array<MatrixXd, kOpenParts> values;
  for (int k = 0; k < kOpenParts; ++k) values[k] = directions.values(sources_[k].coefficients);
  MatrixXd f(kOpenParts, directions.size());
  tbb::parallel_for(0, directions.size(), [&](int d) {
    std::array<const double*, kOpenParts> places{};
    for (int k = 0; k < kOpenParts; ++k) places[k] = values[k].col(d).data();
    transport_.leaving(directions.direction(d), places, ground_, f.col(d).data());
  });
  std::array<std::vector<double>, kOpenParts> result;
  for (int k = 0; k < kOpenParts; ++k) {
    result[k].assign(grid.cells(), 0);
    for (int d = 0; d < directions.size(); ++d) {
      const int m = d / directions.azimuths(), p = d % directions.azimuths();
      result[k][row_of[m] * grid.columns() + p / points] +=
          weight[m] * rule.weights[p % points] * f(k, d);
    }
  }
  return result;
}

HarmonicCells HarmonicSolution::cells(const CellGrid& grid, bool up, double tolerance) const {
  constexpr double kShare = 0.1;
  constexpr int kMostPoints = 8;
  auto coarse = means(grid, up, 3);
  for (int points = 4;; points += 2) {
    auto fine = means(grid, up, points);
    HarmonicCells cells;
    std::vector<double> of_row(grid.rows(), 0);
    for (int k = 0; k < kOpenParts; ++k)
      for (int cell = 0; cell < grid.cells(); ++cell) {
        cells.error[k].push_back(std::abs(fine[k][cell] - coarse[k][cell]));
        of_row[cell / grid.columns()] += std::abs(fine[k][cell]) / grid.columns();
      }
    bool is_enough = true;
    for (int k = 0; k < kOpenParts; ++k)
      for (int cell = 0; cell < grid.cells(); ++cell)
        is_enough &= cells.error[k][cell] <= kShare * tolerance * of_row[cell / grid.columns()];
    for (int k = 0; k < kOpenParts; ++k) cells.value[k] = fine[k];
    if (is_enough || points >= kMostPoints) return cells;
    coarse = std::move(fine);
  }
}

}  // namespace lamella
