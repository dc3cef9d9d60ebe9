#include "tests/statistics/statistics.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <iostream>
#include <numeric>

namespace lamella::testing {

using boost::math::quadrature::gauss_kronrod;

double test_level() { return -std::expm1(std::log1p(-kFalseAlarmBudget) / kStatisticalTests); }

double normal_quantile(double level) {
  return boost::math::quantile(complement(boost::math::normal(), level / 2));
}

double chi_square_p_value(const std::vector<double>& observed,
                          const std::vector<double>& expected) {
  double statistic = 0, o = 0, e = 0;
  int cells = 0;
  const auto close = [&] {
    statistic += (o - e) * (o - e) / e;
    ++cells;
    o = e = 0;
  };
  for (std::size_t k = 0; k < observed.size(); ++k) {
    o += observed[k];
    e += expected[k];
    if (e >= 10) close();
  }
  // What is left expects too little to stand alone: it may only show counts where none belong.
  if (e > 0 && o > e + 8 * std::sqrt(e) + 8) return 0;
  if (e == 0 && o > 0) return 0;
  if (cells < 2) return 1;
  return boost::math::cdf(complement(boost::math::chi_squared(cells - 1), statistic));
}

namespace {

// The sphere about an axis in (t, a): x = (1 - cos) / 2 = w^2 t / (1 + w^2 - t), and
// phi = 2 atan(v tan(pi (a - 1/2))).
class SphereMap {
 public:
  explicit SphereMap(const SphereCells& cells)
      : w2_(cells.width * cells.width), v_(cells.azimuth_width) {
    const Direction n = cells.axis;
    const Direction s = normalized(cells.towards - dot(cells.towards, n) * n);
    frame_ = {s, cross(n, s), n};
  }

  // density times solid angle per dt da
  [[nodiscard]] double mapped(const std::function<double(Direction)>& density, double t,
                              double a) const {
    const bool narrow = std::isfinite(w2_);
    const double x = narrow ? w2_ * t / (1 + w2_ - t) : t;
    const double slope = narrow ? w2_ * (1 + w2_) / ((1 + w2_ - t) * (1 + w2_ - t)) : 1;
    const double sine = std::sin(kPi * (a - 0.5)), cosine = std::cos(kPi * (a - 0.5));
    const double phi = 2 * std::atan2(v_ * sine, cosine);
    const double azimuth_slope = 2 * kPi * v_ / (cosine * cosine + v_ * v_ * sine * sine);
    const double s = 2 * std::sqrt(x * (1 - x));
    const Direction w{s * std::cos(phi), s * std::sin(phi), 1 - 2 * x};
    return 2 * slope * azimuth_slope * density(frame_.to_world(w));
  }
  [[nodiscard]] double t_of(Direction w) const {
    // |w - axis|^2 / 4, exact near the axis
    const Direction d = w - frame_.n;
    const double x = std::min(dot(d, d) / 4, 1.0);
    return std::isfinite(w2_) ? x * (1 + w2_) / (x + w2_) : x;
  }
  [[nodiscard]] double a_of(Direction w) const {
    const Direction local = frame_.to_local(w);
    const double half = std::atan2(local.y, local.x) / 2;
    return std::atan2(std::sin(half), v_ * std::cos(half)) / kPi + 0.5;
  }

 private:
  Frame<double> frame_{};
  double w2_, v_;
};

int cell_of(double fraction, int cells) {
  return std::clamp(static_cast<int>(fraction * cells), 0, cells - 1);
}

}  // namespace

double sampler_p_value(const std::string& name, const SphereCells& cells,
                       const std::function<Direction(RandomStream&)>& sample,
                       const std::function<double(Direction)>& density, int samples,
                       std::uint64_t seed) {
  using boost::math::quadrature::gauss;
  const SphereMap map(cells);
  const int rows = cells.rows, columns = cells.columns;
  std::vector<double> observed(rows * columns), expected(rows * columns);
  RandomStream stream(seed, 0, StreamPurpose::test);
  for (int n = 0; n < samples; ++n) {
    const Direction w = sample(stream);
    observed[cell_of(map.t_of(w), rows) * columns + cell_of(map.a_of(w), columns)] += 1;
  }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const double a0 = static_cast<double>(i) / columns, a1 = (i + 1.0) / columns;
      const auto row = [&](double t) {
        const auto at = [&](double a) { return map.mapped(density, t, a); };
        // Counts are known to a few per cent; the rules' own tolerance is far below that.
        return cells.smooth ? gauss<double, 3>::integrate(at, a0, a1)
                            : gauss_kronrod<double, 15>::integrate(at, a0, a1, 5, 1e-4);
      };
      const double t0 = static_cast<double>(j) / rows, t1 = (j + 1.0) / rows;
      expected[j * columns + i] =
          samples * (cells.smooth ? gauss<double, 3>::integrate(row, t0, t1)
                                  : gauss_kronrod<double, 15>::integrate(row, t0, t1, 7, 1e-4));
    }
  const double p = chi_square_p_value(observed, expected);
  if (!(p >= test_level())) {
    std::cerr << name << ": p = " << p
              << "\nexpected in all: " << std::accumulate(expected.begin(), expected.end(), 0.0)
              << " of " << samples << "\nrow column observed expected\n";
    for (int k = 0; k < rows * columns; ++k)
      if (observed[k] > 0 || expected[k] > 1e-3)
        std::cerr << k / columns << ' ' << k % columns << ' ' << observed[k] << ' ' << expected[k]
                  << '\n';
  }
  return p;
}

double sampler_p_value(const std::string& name, Direction axis,
                       const std::function<Direction(RandomStream&)>& sample,
                       const std::function<double(Direction)>& density, int samples,
                       std::uint64_t seed) {
  return sampler_p_value(name, SphereCells{.axis = axis}, sample, density, samples, seed);
}

double mean_p_value(const std::vector<double>& values, double expectation) {
  const double n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double variance = 0;
  for (const double v : values) variance += (v - mean) * (v - mean);
  variance /= n * (n - 1);
  // Constant values have no spread but rounding.
  if (!(variance > 1e-24 * mean * mean)) return std::abs(mean - expectation) < 1e-9 ? 1 : 0;
  const double z = std::abs(mean - expectation) / std::sqrt(variance);
  return 2 * boost::math::cdf(complement(boost::math::normal(), z));
}

double integrate_sphere(const std::function<double(Direction)>& density, const SphereCells& cells,
                        double tolerance) {
  using boost::math::quadrature::gauss;
  const SphereMap map(cells);
  const int rows = cells.smooth ? cells.rows : 8, columns = cells.smooth ? cells.columns : 4;
  const auto over = [](const auto& f, int panels, const auto& rule) {
    double sum = 0;
    for (int k = 0; k < panels; ++k)
      sum += rule(f, static_cast<double>(k) / panels, (k + 1.0) / panels);
    return sum;
  };
  const auto rule = [&](const auto& f, double from, double to) {
    return cells.smooth ? gauss<double, 3>::integrate(f, from, to)
                        : gauss_kronrod<double, 15>::integrate(f, from, to, 9, tolerance);
  };
  const auto ring = [&](double t) {
    return over([&](double a) { return map.mapped(density, t, a); }, columns, rule);
  };
  return over(ring, rows, rule);
}

double integrate_sphere(const std::function<double(Direction)>& density, Direction axis,
                        double tolerance) {
  return integrate_sphere(density, SphereCells{.axis = axis}, tolerance);
}

}  // namespace lamella::testing
