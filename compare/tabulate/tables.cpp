#include "compare/tabulate/tables.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

constexpr int kPoints = 32;         // of a panel
constexpr double kMostPeriods = 1;  // of P_l on a panel
constexpr int kHalvings = 40;
constexpr int kFewest = 64, kMost = 1 << 14;
constexpr double kStill = 1e-12;

bool differ(Rgb a, Rgb b) {
  for (int c = 0; c < 3; ++c)
    if (std::abs(a[c] - b[c]) > 1e-9 * (std::abs(a[c]) + std::abs(b[c]))) return true;
  return false;
}

Direction turned(Direction w, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * w.x - s * w.y, s * w.x + c * w.y, w.z};
}

// Panels of the angle in [0, pi] that halve towards both ends, short enough for P_l.
std::vector<double> panel_edges(int terms) {
  std::vector<double> edges{0};
  const double longest = std::min(kPi / 4, 2 * kPi * kMostPeriods / terms);
  for (int k = kHalvings; k >= 0; --k) {
    const double next = std::ldexp(kPi / 2, -k), from = edges.back();
    const int parts = static_cast<int>(std::ceil((next - from) / longest));
    for (int n = 1; n <= parts; ++n) edges.push_back(from + (next - from) * n / parts);
  }
  for (std::size_t k = edges.size() - 1; k-- > 0;) edges.push_back(kPi - edges[k]);
  return edges;
}

std::vector<double> legendre_sums(const PairFunction& p, int terms, int points) {
  const Quadrature& rule = cached_gauss_legendre(points);
  const std::vector<double> edges = panel_edges(terms);
  const Direction wi{0, 0, 1};
  std::vector<double> sums(static_cast<std::size_t>(terms));
  for (std::size_t k = 0; k + 1 < edges.size(); ++k)
    for (Eigen::Index n = 0; n < rule.points.size(); ++n) {
      const double length = edges[k + 1] - edges[k], angle = edges[k] + length * rule.points[n];
      const double c = std::cos(angle), s = std::sin(angle);
      // A deflection of 0: w_o = -w_i.
      const double value = 2 * kPi * p(wi, {s, 0, -c}).r * s * length * rule.weights[n];
      double before = 0, now = 1;
      for (int l = 0; l < terms; ++l) {
        sums[static_cast<std::size_t>(l)] += value * now;
        const double next = ((2 * l + 1) * c * now - l * before) / (l + 1);
        before = now;
        now = next;
      }
    }
  return sums;
}

std::vector<Rgb> modes_of(const std::vector<Rgb>& around, int modes) {
  const auto count = around.size();
  std::vector<Rgb> found(static_cast<std::size_t>(modes));
  for (int m = 0; m < modes; ++m) {
    Rgb sum;
    for (std::size_t k = 0; k < count; ++k)
      sum += std::cos(2 * kPi * static_cast<double>(static_cast<std::size_t>(m) * k % count) /
                      static_cast<double>(count)) *
             around[k];
    found[static_cast<std::size_t>(m)] = (1 / static_cast<double>(count)) * sum;
  }
  return found;
}

void require_symmetry(const PairFunction& f, double mu_i, double mu_o) {
  for (const double phi : {0.4, 1.3, 2.9}) {
    const Direction wi = direction_from_mu_phi(mu_i, 0), wo = direction_from_mu_phi(mu_o, phi);
    const Rgb value = f(wi, wo);
    if (differ(value, f(turned(wi, 1.1), turned(wo, 1.1))))
      throw std::invalid_argument(
          "it depends on the azimuth of w_i; allowed: what is symmetric about the normal");
    if (differ(value, f(wi, direction_from_mu_phi(mu_o, -phi))))
      throw std::invalid_argument(
          "it is not the same on both sides of the plane of incidence; allowed: what is");
  }
}

}  // namespace

NumberTable legendre_table(const PairFunction& p, int terms) {
  for (const double c : {-0.7, 0.1, 0.8}) {
    const double s = std::sqrt(1 - c * c);
    const Rgb value = p({0, 0, 1}, {s, 0, -c});
    // The same deflection in another place.
    if (differ(value, p({1, 0, 0}, {-c, 0, s})) || differ(value, p({0, 0, 1}, {0, s, -c})) ||
        differ(value, p({0, 0, -1}, {0, s, c})))
      throw std::invalid_argument(
          "its phase function depends on more than the deflection; allowed: media of particles");
  }
  const std::vector<double> coarse = legendre_sums(p, terms, kPoints / 2),
                            fine = legendre_sums(p, terms, kPoints);
  NumberTable table{{"l", "chi", "error"}, {}};
  for (std::size_t l = 0; l < fine.size(); ++l)
    table.rows.push_back({static_cast<double>(l), fine[l], std::abs(fine[l] - coarse[l])});
  return table;
}

NumberTable fourier_table(const PairFunction& f, const std::vector<double>& mu_i,
                          const std::vector<double>& mu_o, int modes, bool color) {
  NumberTable table{{"mu_i", "mu_o", "m"}, {}};
  if (color)
    table.columns.insert(table.columns.end(), {"value_r", "value_g", "value_b"});
  else
    table.columns.emplace_back("value");
  table.columns.emplace_back("error");
  const int channels = color ? 3 : 1;
  for (const double mi : mu_i)
    for (const double mo : mu_o) {
      require_symmetry(f, mi, mo);
      const Direction wi = direction_from_mu_phi(mi, 0);
      std::vector<Rgb> around;
      std::vector<Rgb> now, before;
      double error = 0;
      for (int count = std::max(kFewest, 2 * modes); count <= kMost; count *= 2) {
        // Every second place is known.
        std::vector<Rgb> finer(static_cast<std::size_t>(count));
        for (int k = 0; k < count; ++k)
          finer[static_cast<std::size_t>(k)] =
              !around.empty() && k % 2 == 0 ? around[static_cast<std::size_t>(k / 2)]
                                            : f(wi, direction_from_mu_phi(mo, 2 * kPi * k / count));
        around = std::move(finer);
        before = std::move(now);
        now = modes_of(around, modes);
        if (before.empty()) continue;
        error = 0;
        double size = 0;
        for (std::size_t m = 0; m < now.size(); ++m)
          for (int c = 0; c < channels; ++c) {
            error = std::max(error, std::abs(now[m][c] - before[m][c]));
            size = std::max(size, std::abs(now[m][c]));
          }
        if (error <= kStill * size) break;
      }
      for (std::size_t m = 0; m < now.size(); ++m) {
        std::vector<double> row{mi, mo, static_cast<double>(m)};
        for (int c = 0; c < channels; ++c) row.push_back(now[m][c]);
        row.push_back(error);
        table.rows.push_back(std::move(row));
      }
    }
  return table;
}

}  // namespace lamella
