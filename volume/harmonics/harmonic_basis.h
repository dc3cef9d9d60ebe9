#pragma once

#include <Eigen/Core>

#include "phase/math/direction.h"

namespace lamella {

/// Real spherical harmonics up to a degree, orthonormal over the sphere:
/// N_lm P_l^m(cos theta) times 1 (m = 0), sqrt(2) cos(m phi) or sqrt(2) sin(m phi), without the
/// phase (-1)^m. They are listed by m: the cosines of one m with l = m, m + 1, ..., then its sines.
/// An even basis has the cosines alone, for functions that are the same at phi and -phi.
class HarmonicBasis {
 public:
  explicit HarmonicBasis(int degree, bool is_even = false);

  [[nodiscard]] int degree() const { return degree_; }
  [[nodiscard]] bool is_even() const { return is_even_; }
  [[nodiscard]] int size() const {
    return is_even_ ? (degree_ + 1) * (degree_ + 2) / 2 : (degree_ + 1) * (degree_ + 1);
  }
  /// Whether there are cosines or sines of one m.
  [[nodiscard]] bool has(int m, bool sine) const { return !sine || (m > 0 && !is_even_); }
  /// How many degrees there are of one m.
  [[nodiscard]] int count(int m) const { return degree_ - m + 1; }
  /// Place of the first, l = m, of those that there are.
  [[nodiscard]] int first(int m, bool sine) const;
  [[nodiscard]] int place(int l, int m, bool sine) const { return first(m, sine) + l - m; }

  /// N_lm P_l^m(mu) for every m and l, in the places of the cosines; those of the sines are left
  /// alone. mu in [-1, 1]; absolute error below 1e-12 up to degree 192.
  void legendre(double mu, Eigen::Ref<Eigen::VectorXd> values) const;
  /// All harmonics along a direction (unit).
  void values(Direction w, Eigen::Ref<Eigen::VectorXd> values) const;

 private:
  int degree_;
  bool is_even_;
  // Of the recurrence P_l = a (mu P_(l-1) - b P_(l-2)), in the places of the cosines.
  Eigen::VectorXd a_, b_;
};

}  // namespace lamella
