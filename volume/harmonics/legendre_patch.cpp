#include "volume/harmonics/legendre_patch.h"

#include <algorithm>
#include <cmath>

#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

constexpr int kAlong = LegendrePatch::kAlong;
// Where a polynomial is held against f: places between the points and on edges, and corners, about
// which it is worst by far on a small part of the square.
constexpr double kOff[][2] = {{0.5, 0.055}, {0.5, 1}, {0.055, 0.5}, {0.945, 0.5}, {0.17, 0.83}};
constexpr double kCorners[][2] = {{0, 0}, {0, 1}, {1, 0}, {1, 1}};
constexpr double kShareOfCorner = 1.0 / 3;

// Column k: (2 k + 1) times the weight of each point times P_k there, which sum to coefficients.
const std::array<std::array<double, kAlong>, kAlong>& projection() {
  static const auto table = [] {
    std::array<std::array<double, kAlong>, kAlong> t{};
    const Quadrature& rule = cached_gauss_legendre(kAlong);
    for (int j = 0; j < kAlong; ++j) {
      const auto values = LegendrePatch::legendre(2 * rule.points[j] - 1);
      for (int k = 0; k < kAlong; ++k) t[j][k] = (2 * k + 1) * rule.weights[j] * values[k];
    }
    return t;
  }();
  return table;
}

// What a series leaves whose last coefficients are these: a geometric one by the ratio of pairs.
double left_after(const std::array<double, kAlong>& sizes) {
  const double last = std::max(sizes[kAlong - 1], sizes[kAlong - 2]);
  const double before = std::max(sizes[kAlong - 3], sizes[kAlong - 4]);
  if (last == 0) return 0;
  const double ratio = std::min(0.7, last / before);
  return last * ratio / (1 - ratio);
}

}  // namespace

std::array<double, kAlong> LegendrePatch::legendre(double x) {
  std::array<double, kAlong> values{1, x};
  for (int k = 1; k + 1 < kAlong; ++k)
    values[k + 1] = ((2 * k + 1) * x * values[k] - k * values[k - 1]) / (k + 1);
  return values;
}

LegendrePatch::LeftOver LegendrePatch::on_axes(const std::function<Rgb(double u, double v)>& f) {
  const Quadrature& rule = cached_gauss_legendre(kAlong);
  std::array<Rgb, kAlong> along_u{}, along_v{};
  for (int a = 0; a < kAlong; ++a) {
    const Rgb of_u = f(rule.points[a], 0.5), of_v = f(0.5, rule.points[a]);
    for (int k = 0; k < kAlong; ++k) {
      along_u[k] += projection()[a][k] * of_u;
      along_v[k] += projection()[a][k] * of_v;
    }
  }
  LeftOver worst;
  for (int channel = 0; channel < 3; ++channel) {
    std::array<double, kAlong> u{}, v{};
    for (int k = 0; k < kAlong; ++k) {
      u[k] = std::abs(along_u[k][channel]) / std::sqrt(2 * k + 1);
      v[k] = std::abs(along_v[k][channel]) / std::sqrt(2 * k + 1);
    }
    worst.u = std::max(worst.u, left_after(u));
    worst.v = std::max(worst.v, left_after(v));
  }
  return worst;
}

LegendrePatch::LegendrePatch(const std::function<Rgb(double u, double v)>& f) {
  const Quadrature& rule = cached_gauss_legendre(kAlong);
  std::array<std::array<Rgb, kAlong>, kAlong> by_u{};
  for (int a = 0; a < kAlong; ++a)
    for (int b = 0; b < kAlong; ++b) {
      const Rgb value = f(rule.points[a], rule.points[b]);
      for (int k = 0; k < kAlong; ++k) by_u[k][b] += projection()[a][k] * value;
    }
  for (int k = 0; k < kAlong; ++k)
    for (int b = 0; b < kAlong; ++b)
      for (int l = 0; l < kAlong; ++l) c_[k][l] += projection()[b][l] * by_u[k][b];
  for (int channel = 0; channel < 3; ++channel) {
    std::array<double, kAlong> of_u{}, of_v{};
    for (int k = 0; k < kAlong; ++k)
      for (int l = 0; l < kAlong; ++l) {
        const double square = c_[k][l][channel] * c_[k][l][channel];
        of_u[k] += square / (2 * l + 1);
        of_v[l] += square / (2 * k + 1);
      }
    for (std::array<double, kAlong>* sizes : {&of_u, &of_v})
      for (int k = 0; k < kAlong; ++k) (*sizes)[k] = std::sqrt((*sizes)[k] / (2 * k + 1));
    left_over_.u = std::max(left_over_.u, left_after(of_u));
    left_over_.v = std::max(left_over_.v, left_after(of_v));
  }
}

Rgb LegendrePatch::at(double u, double v) const {
  const auto along_u = legendre(2 * u - 1);
  const auto along_v = legendre(2 * v - 1);
  Rgb sum;
  for (int k = 0; k < kAlong; ++k) {
    Rgb row;
    for (int l = 0; l < kAlong; ++l) row += along_v[l] * c_[k][l];
    sum += along_u[k] * row;
  }
  return sum;
}

double LegendrePatch::off(const std::function<Rgb(double u, double v)>& f) const {
  const auto off_at = [&](const double(&place)[2]) {
    const Rgb difference = at(place[0], place[1]) - f(place[0], place[1]);
    double worst = 0;
    for (int x = 0; x < 3; ++x) worst = std::max(worst, std::abs(difference[x]));
    return worst;
  };
  double worst = 0;
  for (const auto& place : kOff) worst = std::max(worst, off_at(place));
  for (const auto& place : kCorners) worst = std::max(worst, kShareOfCorner * off_at(place));
  return worst;
}

}  // namespace lamella
