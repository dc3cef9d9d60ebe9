#pragma once

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <span>

#include "phase/math/color.h"

namespace lamella {

/// The size of an integral's error: the largest channel.
[[nodiscard]] inline double size_of(double x) { return std::abs(x); }
[[nodiscard]] inline double size_of(Rgb c) {
  return std::max({std::abs(c.r), std::abs(c.g), std::abs(c.b)});
}

/// The integral of f, a double or an Rgb, over [edges.front(), edges.back()], panels beginning at
/// the edges (at most 16): Gauss and Kronrod's rules of 7 and 15 points, the panel whose rules
/// differ most halved until the differences add up to `tolerance` of the integral, or to `least`.
/// It ends at 64 panels. Where f is smooth the error is far below the tolerance, as the differences
/// are those of the rule of 7 points.
template <class Value, class F>
[[nodiscard]] Value integrate_adaptively(const F& f, std::span<const double> edges,
                                         double tolerance, double least = 1e-300) {
  using boost::math::quadrature::gauss;
  using boost::math::quadrature::gauss_kronrod;
  struct Panel {
    double a, b, error;
    Value value;
  };
  constexpr int kMost = 64;
  std::array<Panel, kMost> panels;
  int count = 0;
  const auto measured = [&](double a, double b) {
    const auto& x = gauss_kronrod<double, 15>::abscissa();
    const auto& w = gauss_kronrod<double, 15>::weights();
    const auto& g = gauss<double, 7>::weights();
    const double middle = (a + b) / 2, half = (b - a) / 2;
    const Value centre = f(middle);
    Value fine = w[0] * centre, coarse = g[0] * centre;
    for (std::size_t k = 1; k < x.size(); ++k) {
      const Value pair = f(middle - half * x[k]) + f(middle + half * x[k]);
      fine = fine + w[k] * pair;
      if (k % 2 == 0) coarse = coarse + g[k / 2] * pair;
    }
    return Panel{a, b, half * size_of(fine - coarse), half * fine};
  };
  for (std::size_t k = 0; k + 1 < edges.size(); ++k)
    if (edges[k + 1] > edges[k]) panels[count++] = measured(edges[k], edges[k + 1]);
  for (;;) {
    Value sum{};
    double error = 0;
    int worst = 0;
    for (int k = 0; k < count; ++k) {
      sum = sum + panels[k].value;
      error += panels[k].error;
      if (panels[k].error > panels[worst].error) worst = k;
    }
    if (count == 0 || count == kMost || error <= tolerance * size_of(sum) || error <= least)
      return sum;
    const Panel halved = panels[worst];
    const double middle = (halved.a + halved.b) / 2;
    panels[worst] = measured(halved.a, middle);
    panels[count++] = measured(middle, halved.b);
  }
}

}  // namespace lamella
