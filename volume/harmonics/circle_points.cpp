#include "volume/harmonics/circle_points.h"

#include <algorithm>
#include <cmath>

#include "phase/math/direction.h"
#include "phase/math/real.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

// Sum of half axes of the ellipse with foci -1 and 1 through a point, from half its long axis.
constexpr double kFarEnough = 5.0 / 3;  // (3 + 1 / 3) / 2

bool is_far(double x, double y) {
  const double y2 = y * y;
  return std::sqrt((x - 1) * (x - 1) + y2) + std::sqrt((x + 1) * (x + 1) + y2) >= 2 * kFarEnough;
}

// Without what the standard's complex numbers do about infinity.
struct Complex {
  double re = 0, im = 0;

  friend Complex operator+(Complex a, Complex b) { return {a.re + b.re, a.im + b.im}; }
  friend Complex operator-(Complex a, Complex b) { return {a.re - b.re, a.im - b.im}; }
  friend Complex operator*(Complex a, Complex b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
  }
  [[nodiscard]] double norm() const { return re * re + im * im; }
  [[nodiscard]] Complex conjugate() const { return {re, -im}; }
  [[nodiscard]] Complex inverse() const { return {re / norm(), -im / norm()}; }
};

}  // namespace

void add_zeros(double a, double b, double c, std::vector<CircleZero>& zeros) {
  const double r = std::sqrt(b * b + c * c);
  if (r <= 1e-14 * std::abs(a)) return;
  zeros.push_back({std::atan2(-c, -b), std::acosh(std::max(1.0, a / r))});
}

// With z = exp(i phi) they are zeros of a polynomial of degree 4 whose zeros come in pairs z and
// 1 / conj(z): Ehrlich and Aberth's iteration for the two within the unit circle.
void add_zeros(double a, double b, double c, double d, double e, std::vector<CircleZero>& zeros) {
  constexpr int kIterations = 60;
  constexpr double kEnough = 1e-2;
  const Complex c1{b / 2, -c / 2}, c2{d / 2, -e / 2};
  if (c2.norm() <= 1e-26 * a * a) return add_zeros(a, b, c, zeros);
  const Complex c3 = c1.conjugate(), c4 = c2.conjugate(), c0{a, 0};
  Complex z[2] = {{0.4, 0.45}, {-0.5, 0.3}};
  for (int k = 0; k < kIterations; ++k) {
    double change = 0;
    for (int j = 0; j < 2; ++j) {
      const Complex other = z[1 - j], w = z[j];
      const Complex p1 = c2 * w + c1, p2 = p1 * w + c0, p3 = p2 * w + c3;
      const Complex value = p3 * w + c4;
      const Complex slope = ((c2 * w + p1) * w + p2) * w + p3;
      Complex away = slope * value.inverse() - (w - other).inverse() -
                     (w - other.conjugate().inverse()).inverse();
      // A pair that has met on the circle repels itself without end.
      const Complex own = w - w.conjugate().inverse();
      if (own.norm() > 1e-14) away = away - own.inverse();
      Complex next = w - away.inverse();
      if (!std::isfinite(next.re) || !std::isfinite(next.im)) next = w;
      if (next.norm() > 1) next = next.conjugate().inverse();
      if (next.norm() < 1e-24) next = {1e-12, 0};
      change =
          std::max(change, (next - w).norm() / ((1 - next.norm()) * (1 - next.norm()) / 4 + 1e-24));
      z[j] = next;
    }
    if (change < kEnough * kEnough) break;
  }
  for (const Complex& zero : z)
    zeros.push_back({std::atan2(zero.im, zero.re), -std::log(zero.norm()) / 2});
}

CirclePoints::CirclePoints(int points_per_part, int together)
    : points_(points_per_part), together_(together) {
  const Quadrature& rule = cached_gauss_legendre(points_);
  for (int h = 0; h <= kHalvings; ++h) {
    const double half = std::ldexp(kPi / kFirstParts, -h);
    for (int j = 0; j < points_; ++j) {
      const double x = half * (2 * rule.points[j] - 1);
      cosines_.push_back(std::cos(x));
      sines_.push_back(std::sin(x));
      weights_.push_back(2 * half * rule.weights[j]);
    }
  }
}

void CirclePoints::place(const std::vector<CircleZero>& zeros, double longest) {
  cosine_.clear();
  sine_.clear();
  weight_.clear();
  // Parts begin at the singularity that is nearest to the real line.
  double begin = 0, nearest = 1e300;
  for (const CircleZero& zero : zeros)
    if (zero.distance < nearest) {
      nearest = zero.distance;
      begin = zero.phi;
    }
  for (int k = 0; k < kFirstParts; ++k)
    add(begin + (2 * k + 1) * kPi / kFirstParts, 0, zeros, longest);
  while (weight_.size() % together_ != 0) {
    cosine_.push_back(cosine_.back());
    sine_.push_back(sine_.back());
    weight_.push_back(0);
  }
}

void CirclePoints::add(double middle, int halvings, const std::vector<CircleZero>& zeros,
                       double longest) {
  const double half = std::ldexp(kPi / kFirstParts, -halvings);
  bool is_fine = 2 * half <= longest;
  for (std::size_t k = 0; is_fine && k < zeros.size(); ++k) {
    double x = std::abs(zeros[k].phi - middle);
    while (x > kPi) x = std::abs(x - 2 * kPi);
    is_fine = is_far(x / half, zeros[k].distance / half);
  }
  if (!is_fine && halvings < kHalvings) {
    add(middle - half / 2, halvings + 1, zeros, longest);
    add(middle + half / 2, halvings + 1, zeros, longest);
    return;
  }
  const double c = std::cos(middle), s = std::sin(middle);
  for (int j = halvings * points_; j < (halvings + 1) * points_; ++j) {
    cosine_.push_back(c * cosines_[j] - s * sines_[j]);
    sine_.push_back(s * cosines_[j] + c * sines_[j]);
    weight_.push_back(weights_[j]);
  }
}

}  // namespace lamella
