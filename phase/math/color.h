#pragma once

#include <algorithm>
#include <array>

#include "phase/math/real.h"

namespace lamella {

/// A quantity per colour channel: red, green, blue. Grey means three equal values.
struct Rgb {
  double r = 0, g = 0, b = 0;

  constexpr Rgb() = default;
  constexpr Rgb(double red, double green, double blue) : r(red), g(green), b(blue) {}
  constexpr explicit Rgb(double grey) : r(grey), g(grey), b(grey) {}

  [[nodiscard]] constexpr double operator[](int c) const { return c == 0 ? r : c == 1 ? g : b; }
  constexpr double& operator[](int c) { return c == 0 ? r : c == 1 ? g : b; }
  [[nodiscard]] constexpr bool is_grey() const { return r == g && g == b; }
  [[nodiscard]] constexpr double max() const { return std::max(r, std::max(g, b)); }

  friend constexpr Rgb operator+(Rgb x, Rgb y) { return {x.r + y.r, x.g + y.g, x.b + y.b}; }
  friend constexpr Rgb operator-(Rgb x, Rgb y) { return {x.r - y.r, x.g - y.g, x.b - y.b}; }
  friend constexpr Rgb operator*(Rgb x, Rgb y) { return {x.r * y.r, x.g * y.g, x.b * y.b}; }
  friend constexpr Rgb operator*(double s, Rgb x) { return {s * x.r, s * x.g, s * x.b}; }
  constexpr Rgb& operator+=(Rgb o) { return *this = *this + o; }
  friend constexpr bool operator==(Rgb, Rgb) = default;
};

/// Schlick's reflectance f0 + (1 - f0) s with s = (1 - cos)^5; f0 = 1 means no Fresnel factor.
[[nodiscard]] constexpr Rgb schlick(Rgb f0, double s) { return f0 + s * (Rgb(1) - f0); }

/// (1 - cosine)^5 for a cosine in [0, 1].
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real schlick_weight(Real cosine) {
  const Real m = min(nonnegative(Real(1) - cosine), Real(1));
  return m * m * m * m * m;
}

}  // namespace lamella
