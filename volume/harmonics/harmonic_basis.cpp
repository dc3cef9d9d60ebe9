#include "volume/harmonics/harmonic_basis.h"

#include <cmath>

namespace lamella {

HarmonicBasis::HarmonicBasis(int degree, bool is_even)
    : degree_(degree), is_even_(is_even), a_(size()), b_(size()) {
  a_.setZero();
  b_.setZero();
  for (int m = 0; m <= degree; ++m)
    for (int l = m + 1; l <= degree; ++l) {
      const double ll = l, mm = m;
      a_[place(l, m, false)] = std::sqrt((4 * ll * ll - 1) / (ll * ll - mm * mm));
      b_[place(l, m, false)] =
          std::sqrt(((ll - 1) * (ll - 1) - mm * mm) / (4 * (ll - 1) * (ll - 1) - 1));
    }
}

int HarmonicBasis::first(int m, bool sine) const {
  if (is_even_) return m * (2 * degree_ - m + 3) / 2;
  // m = 0 has degree + 1 places, each m before this one two times as many as it has degrees.
  const int before = m == 0 ? 0 : (degree_ + 1) + (m - 1) * (2 * degree_ - m + 2);
  return before + (sine ? count(m) : 0);
}

void HarmonicBasis::legendre(double mu, Eigen::Ref<Eigen::VectorXd> values) const {
  const double sine = std::sqrt(std::fmax(0, (1 - mu) * (1 + mu)));
  double diagonal = std::sqrt(1 / (4 * kPi));
  for (int m = 0; m <= degree_; ++m) {
    if (m > 0) diagonal *= sine * std::sqrt((2.0 * m + 1) / (2 * m));
    double before = 0, now = diagonal;
    int at = first(m, false);
    values[at] = now;
    for (int l = m + 1; l <= degree_; ++l) {
      ++at;
      const double next = a_[at] * (mu * now - b_[at] * before);
      before = now;
      now = next;
      values[at] = now;
    }
  }
}

void HarmonicBasis::values(Direction w, Eigen::Ref<Eigen::VectorXd> values) const {
  legendre(w.z, values);
  const double sine = std::sqrt(w.x * w.x + w.y * w.y);
  const double c = sine > 0 ? w.x / sine : 1, s = sine > 0 ? w.y / sine : 0;
  double cosine = std::sqrt(2.0), other = 0;
  for (int m = 1; m <= degree_; ++m) {
    const double next = cosine * c - other * s;
    other = other * c + cosine * s;
    cosine = next;
    if (!is_even_)
      values.segment(first(m, true), count(m)) = other * values.segment(first(m, false), count(m));
    values.segment(first(m, false), count(m)) *= cosine;
  }
}

}  // namespace lamella
