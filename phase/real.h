#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>

namespace lamella {

// What a formula that is a template over its number type may call besides + - * / and the square
// root: here for float and double, in phase/lanes.h and phase/double_lanes.h for lanes, which
// argument- dependent lookup finds. Elementary functions are called after `using std::exp` and the
// like.

/// a where the condition holds, else b; both are evaluated.
template <std::floating_point Real>
[[nodiscard]] Real select(bool condition, Real a, Real b) {
  return condition ? a : b;
}
template <std::floating_point Real>
[[nodiscard]] Real max(Real a, Real b) {
  return std::max(a, b);
}
template <std::floating_point Real>
[[nodiscard]] Real min(Real a, Real b) {
  return std::min(a, b);
}
template <std::floating_point Real>
[[nodiscard]] Real nonnegative(Real a) {
  return a > 0 ? a : 0;
}
/// a b + c, in one rounding or two.
template <std::floating_point Real>
[[nodiscard]] Real multiply_add(Real a, Real b, Real c) {
  return a * b + c;
}

/// The angle in [0, pi] with that sine, not negative, and that cosine, whose squares add up to 1.
template <std::floating_point Real>
[[nodiscard]] Real angle_of(Real sine, Real cosine) {
  return std::atan2(std::abs(sine), cosine);  // -0 is 0
}

/// The angle in [0, pi/2] with that sine and that cosine.
template <std::floating_point Real>
[[nodiscard]] Real arc_sine(Real sine, Real /*cosine*/) {
  return std::asin(sine);
}

/// c0 + x (c1 + x (c2 + ...)).
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real polynomial(Real /*x*/, double c0) {
  return Real(c0);
}
template <class Real, class... Rest>
[[nodiscard, gnu::always_inline]] inline Real polynomial(Real x, double c0, Rest... rest) {
  return multiply_add(x, polynomial(x, rest...), Real(c0));
}

}  // namespace lamella
