#include "volume/harmonics/circle_points.h"

#include <algorithm>
#include <cmath>

#include "phase/math/direction.h"

namespace lamella {
namespace {

// The ellipse with foci -1 and 1 whose half axes sum to 3.4.
constexpr double kSumOfAxes = 3.4;
constexpr double kLongAxis = (kSumOfAxes + 1 / kSumOfAxes) / 2;
constexpr double kShortAxis = (kSumOfAxes - 1 / kSumOfAxes) / 2;
constexpr int kFirstPanels = 4;

bool is_far(double x, double y) {
  const double along = x * (1 / kLongAxis), across = y * (1 / kShortAxis);
  return along * along + across * across >= 1;
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

void CirclePanels::clear() {
  cosine_.clear();
  sine_.clear();
  half_.clear();
}

void CirclePanels::place(const std::vector<CircleZero>& zeros, double longest) {
  clear();
  // Panels begin at the singularity that is nearest to the real line.
  double begin = 0, nearest = 1e300;
  for (const CircleZero& zero : zeros)
    if (zero.distance < nearest) {
      nearest = zero.distance;
      begin = zero.phi;
    }
  add_range(begin, begin + 2 * kPi, nullptr, zeros, longest);
}

void CirclePanels::place_arc(double begin, double end, double near,
                             const std::vector<CircleZero>& zeros, double longest) {
  clear();
  // Panels meet at the singularity that is nearest to the real line, where one lies in the arc.
  double cut = (begin + end) / 2, nearest = 1;
  for (const CircleZero& zero : zeros) {
    const double phi = begin + std::remainder(zero.phi - begin - kPi, 2 * kPi) + kPi;
    if (zero.distance < nearest && phi > begin && phi < end) {
      nearest = zero.distance;
      cut = phi;
    }
  }
  const Arc arc{begin, end, near};
  add_range(begin, cut, &arc, zeros, longest);
  add_range(cut, end, &arc, zeros, longest);
}

void CirclePanels::add_range(double from, double to, const Arc* arc,
                             const std::vector<CircleZero>& zeros, double longest) {
  const int first =
      std::max(1, static_cast<int>(std::ceil((to - from) / (2 * kPi / kFirstPanels) - 1e-9)));
  const double half = (to - from) / (2 * first);
  halvings_[0] = {half, std::cos(half), std::sin(half)};
  known_ = 1;
  for (int k = 0; k < first; ++k) {
    const double middle = from + (2 * k + 1) * half;
    add({middle, std::cos(middle), std::sin(middle)}, 0, arc, zeros, longest);
  }
}

void CirclePanels::add(const Panel& panel, std::size_t halvings, const Arc* arc,
                       const std::vector<CircleZero>& zeros, double longest) {
  const double half = halvings_[halvings].length;
  bool is_fine = 2 * half <= longest;
  // Points on a panel as long as its distance from the end, and twice that, leave 1e-8 of
  // exp(-depth / mu).
  if (arc && is_fine)
    is_fine =
        half <= arc->near + std::min(panel.middle - arc->begin, arc->end - panel.middle) - half;
  for (std::size_t k = 0; is_fine && k < zeros.size(); ++k) {
    double x = std::abs(zeros[k].phi - panel.middle);
    while (x > kPi) x = std::abs(x - 2 * kPi);
    is_fine = is_far(x / half, zeros[k].distance / half);
  }
  if (is_fine || halvings >= kHalvings) {
    cosine_.push_back(panel.cosine);
    sine_.push_back(panel.sine);
    half_.push_back(half);
    return;
  }
  // Half of an angle has its cosine and sine from the angle's.
  if (known_ == halvings + 1) {
    const Half whole = halvings_[halvings];
    const double cosine = std::sqrt((1 + whole.cosine) / 2);
    halvings_[known_++] = {half / 2, cosine, whole.sine / (2 * cosine)};
  }
  const Half next = halvings_[halvings + 1];
  const double cc = panel.cosine * next.cosine, ss = panel.sine * next.sine;
  const double sc = panel.sine * next.cosine, cs = panel.cosine * next.sine;
  add({panel.middle - next.length, cc + ss, sc - cs}, halvings + 1, arc, zeros, longest);
  add({panel.middle + next.length, cc - ss, sc + cs}, halvings + 1, arc, zeros, longest);
}

}  // namespace lamella
