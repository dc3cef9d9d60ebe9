#include "compare/judge/cell_pieces.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

// Whether a piece is larger than its distance from a peak, and than the least piece.
bool is_large(const CellPiece& p, Direction wi) {
  const double mu = std::abs(wi.z), theta_i = std::acos(std::min(mu, 1.0));
  const double theta0 = std::acos(p.mu1), theta1 = std::acos(p.mu0);
  const double sine = std::sqrt(std::max(1 - mu * mu, 0.0));
  const double theta = theta1 - theta0;
  const double around = (p.phi1 - p.phi0) * std::sqrt(1 - p.mu0 * p.mu0);
  const double extent = std::max(theta, around);
  if (extent <= kPeakExtent) return false;
  const double off_theta = std::max({theta0 - theta_i, theta_i - theta1, 0.0});
  for (const double peak : {0.0, kPi, 2 * kPi}) {
    const double off_phi = std::max({p.phi0 - peak, peak - p.phi1, 0.0}) * sine;
    if (std::hypot(off_theta, off_phi) < extent / 2) return true;
  }
  return false;
}

}  // namespace

std::vector<CellPiece> cell_pieces(const CellGrid& grid, int cell, Direction wi) {
  const int row = cell / grid.columns(), column = cell % grid.columns();
  const CellPiece whole{grid.edge_mu(row + 1), grid.edge_mu(row), grid.edge_phi(column),
                        grid.edge_phi(column) + 2 * kPi / grid.phi_cells};
  std::vector<CellPiece> open{whole}, done;
  while (!open.empty()) {
    const CellPiece p = open.back();
    open.pop_back();
    if (!is_large(p, wi)) {
      done.push_back(p);
      continue;
    }
    const double mu = (p.mu0 + p.mu1) / 2, phi = (p.phi0 + p.phi1) / 2;
    const double theta = std::acos(p.mu0) - std::acos(p.mu1);
    const double around = (p.phi1 - p.phi0) * std::sqrt(1 - p.mu0 * p.mu0);
    if (theta > 2 * around) {
      open.push_back({p.mu0, mu, p.phi0, p.phi1});
      open.push_back({mu, p.mu1, p.phi0, p.phi1});
    } else if (around > 2 * theta) {
      open.push_back({p.mu0, p.mu1, p.phi0, phi});
      open.push_back({p.mu0, p.mu1, phi, p.phi1});
    } else {
      for (const auto& [a, b] : {std::pair{p.mu0, mu}, {mu, p.mu1}}) {
        open.push_back({a, b, p.phi0, phi});
        open.push_back({a, b, phi, p.phi1});
      }
    }
  }
  return done;
}

double cell_norm(const CellGrid& grid, int cell) {
  const int row = cell / grid.columns();
  const double mu0 = grid.edge_mu(row + 1), mu1 = grid.edge_mu(row);
  return 1 / ((mu1 - mu0) * (mu1 + mu0) / 2 * (2 * kPi / grid.phi_cells));
}

}  // namespace lamella
