#pragma once

#include <array>
#include <functional>

#include "phase/math/color.h"

namespace lamella {

/// A function of (u, v) in [0, 1]^2 as a polynomial through kAlong^2 points of Gauss and Legendre,
/// in products of Legendre polynomials.
class LegendrePatch {
 public:
  static constexpr int kAlong = 10;

  struct LeftOver {
    double u = 0, v = 0;
    [[nodiscard]] double sum() const { return u + v; }
  };
  /// What series along u and along v leave on the two lines through the middle, which tells at 2
  /// kAlong points whether a polynomial is worth its kAlong^2.
  [[nodiscard]] static LeftOver on_axes(const std::function<Rgb(double u, double v)>& f);

  LegendrePatch() = default;
  explicit LegendrePatch(const std::function<Rgb(double u, double v)>& f);

  [[nodiscard]] Rgb at(double u, double v) const;
  /// Of P_k(2 u - 1) P_l(2 v - 1).
  [[nodiscard]] const Rgb& coefficient(int k, int l) const { return c_[k][l]; }
  /// What the series leave along u and along v, from how fast their coefficients fall: a mean over
  /// the other variable, of the worst channel.
  [[nodiscard]] LeftOver left_over() const { return left_over_; }
  /// The largest difference from f at places between the points and on edges, and a third of that
  /// at corners.
  [[nodiscard]] double off(const std::function<Rgb(double u, double v)>& f) const;

  /// P_k(x), k < kAlong.
  [[nodiscard]] static std::array<double, kAlong> legendre(double x);

 private:
  std::array<std::array<Rgb, kAlong>, kAlong> c_{};
  LeftOver left_over_;
};

}  // namespace lamella
