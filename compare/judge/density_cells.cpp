#include "compare/judge/density_cells.h"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <limits>

namespace lamella {
namespace {

constexpr std::size_t kRows = 6, kColumns = 8, kFiner = 3;
constexpr int kOutside = 14, kMostHalvings = 12;
constexpr std::size_t kFewest = 32;  // directions of a row with columns

// Edges of `parts` parts of [from, to] that hold equal shares of the sorted values, each part with
// edges of its own: `finer` equal shares; beyond the outermost values panels halve towards them, as
// the density does not end there.
std::vector<std::vector<double>> shares_of(const std::vector<double>& sorted, double from,
                                           double to, std::size_t parts, std::size_t finer) {
  const std::size_t n = sorted.size();
  const auto quantile = [&](std::size_t k, std::size_t of) {
    const std::size_t at = k * n / of;
    return at == 0 ? sorted.front() : (sorted[at - 1] + sorted[std::min(at, n - 1)]) / 2;
  };
  std::vector<std::vector<double>> list(parts);
  for (std::size_t part = 0; part < parts; ++part) {
    std::vector<double>& edges = list[part];
    if (part == 0) {
      edges.push_back(from);
      for (int k = 1; k <= kOutside; ++k)
        edges.push_back(sorted.front() - (sorted.front() - from) * std::ldexp(1.0, -k));
    }
    for (std::size_t k = 0; k <= finer; ++k) {
      const std::size_t step = part * finer + k;
      edges.push_back(step == parts * finer ? sorted.back() : quantile(step, parts * finer));
    }
    if (part + 1 == parts) {
      for (int k = kOutside; k >= 1; --k)
        edges.push_back(sorted.back() + (to - sorted.back()) * std::ldexp(1.0, -k));
      edges.push_back(to);
    }
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  }
  return list;
}

double turns_from(double cut, double phi) {
  const double x = std::fmod(phi - cut, 2 * kPi);
  return x < 0 ? x + 2 * kPi : x;
}

struct Panel {
  double mu0, mu1, phi0, phi1;
};

using Density = std::function<double(Direction)>;

double gauss(const Density& density, const Panel& p) {
  using Rule = boost::math::quadrature::gauss<double, 5>;
  return Rule::integrate(
      [&](double mu) {
        return Rule::integrate([&](double phi) { return density(direction_from_mu_phi(mu, phi)); },
                               p.phi0, p.phi1);
      },
      p.mu0, p.mu1);
}

struct Share {
  double value = 0, error = 0;
};

Share refined(const Density& density, const Panel& p, double whole, double tolerance,
              int halvings) {
  const double mu = (p.mu0 + p.mu1) / 2, phi = (p.phi0 + p.phi1) / 2;
  const Panel parts[] = {{p.mu0, mu, p.phi0, phi},
                         {mu, p.mu1, p.phi0, phi},
                         {p.mu0, mu, phi, p.phi1},
                         {mu, p.mu1, phi, p.phi1}};
  double sum = 0, value[4];
  for (int k = 0; k < 4; ++k) sum += value[k] = gauss(density, parts[k]);
  const double off = std::abs(sum - whole);
  if (off <= tolerance || halvings == 0 || !std::isfinite(off)) return {sum, off};
  Share share;
  for (int k = 0; k < 4; ++k) {
    const Share part = refined(density, parts[k], value[k], tolerance / 2, halvings - 1);
    share.value += part.value;
    share.error += part.error;
  }
  return share;
}

}  // namespace

DensityCells::DensityCells(std::span<const Direction> pilot) {
  for (const double side : {-1.0, 1.0}) {
    std::vector<double> mu;
    for (const Direction& w : pilot)
      if ((w.z < 0) == (side < 0)) mu.push_back(w.z);
    std::sort(mu.begin(), mu.end());
    const double from = std::min(side, 0.0), to = std::max(side, 0.0);
    if (mu.size() < kFewest * 2) {
      // Nearly nothing is drawn here: one cell.
      rows_.push_back({{from, (from + to) / 2, to}, 0, {{0, kPi, 2 * kPi}}});
      continue;
    }
    const std::size_t rows = std::min(kRows, mu.size() / kFewest);
    for (std::vector<double>& edges : shares_of(mu, from, to, rows, kFiner)) {
      if (edges.size() < 2) continue;  // all directions of the part have one cosine
      Row row{std::move(edges), 0, {}};
      std::vector<double> phi;
      for (const Direction& w : pilot)
        if (w.z >= row.mu.front() && w.z < row.mu.back() && (w.z < 0) == (side < 0))
          phi.push_back(azimuth(w));
      std::sort(phi.begin(), phi.end());
      if (phi.size() < kFewest) {
        row.phi = {{0, kPi, 2 * kPi}};
      } else {
        double widest = phi.front() + 2 * kPi - phi.back();
        row.cut = phi.back() + widest / 2;
        for (std::size_t k = 1; k < phi.size(); ++k)
          if (phi[k] - phi[k - 1] > widest) {
            widest = phi[k] - phi[k - 1];
            row.cut = phi[k - 1] + widest / 2;
          }
        for (double& x : phi) x = turns_from(row.cut, x);
        std::sort(phi.begin(), phi.end());
        row.phi = shares_of(phi, 0, 2 * kPi, kColumns, kFiner);
      }
      rows_.push_back(std::move(row));
    }
  }
  std::size_t cells = 0;
  for (const Row& row : rows_) {
    first_.push_back(cells);
    cells += row.phi.size();
  }
  first_.push_back(cells);
}

std::size_t DensityCells::count() const { return first_.back(); }

std::size_t DensityCells::cell_of(Direction w) const {
  std::size_t r = 0;
  while (r + 1 < rows_.size() &&
         !(w.z < rows_[r].mu.back() || (w.z == 0 && rows_[r].mu.front() == 0)))
    ++r;
  const Row& row = rows_[r];
  const double phi = turns_from(row.cut, azimuth(w));
  std::size_t column = 0;
  while (column + 1 < row.phi.size() && phi >= row.phi[column].back()) ++column;
  return first_[r] + column;
}

DensityCells::Shares DensityCells::integrate(const Density& density, double tolerance,
                                             const std::function<bool()>& stop) const {
  Shares shares{std::vector<double>(count()), std::vector<double>(count())};
  for (std::size_t r = 0; r < rows_.size(); ++r)
    for (std::size_t column = 0; column < rows_[r].phi.size(); ++column) {
      const std::size_t cell = first_[r] + column;
      if (stop()) {
        shares.error[cell] = std::numeric_limits<double>::infinity();
        continue;
      }
      const Row& row = rows_[r];
      const std::vector<double>& phi = row.phi[column];
      for (std::size_t i = 0; i + 1 < row.mu.size(); ++i)
        for (std::size_t j = 0; j + 1 < phi.size(); ++j) {
          const Panel panel{row.mu[i], row.mu[i + 1], row.cut + phi[j], row.cut + phi[j + 1]};
          const Share share =
              refined(density, panel, gauss(density, panel), tolerance, kMostHalvings);
          shares.value[cell] += share.value;
          shares.error[cell] += share.error;
        }
    }
  return shares;
}

}  // namespace lamella
