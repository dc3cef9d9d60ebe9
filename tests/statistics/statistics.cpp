#include "tests/statistics/statistics.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <iostream>

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

double sampler_p_value(const std::string& name, Direction axis,
                       const std::function<Direction(RandomStream&)>& sample,
                       const std::function<double(Direction)>& density, int samples,
                       std::uint64_t seed) {
  constexpr int kMu = 12, kPhi = 12;
  const Frame<double> frame = frame_around(axis);
  std::vector<double> observed(kMu * kPhi), expected(kMu * kPhi);
  RandomStream stream(seed, 0, StreamPurpose::test);
  for (int n = 0; n < samples; ++n) {
    const Direction w = frame.to_local(sample(stream));
    const double mu = std::clamp((w.z + 1) / 2 * kMu, 0.0, kMu - 1e-9);
    const double phi = std::clamp(azimuth(w) / (2 * kPi) * kPhi, 0.0, kPhi - 1e-9);
    observed[static_cast<int>(mu) * kPhi + static_cast<int>(phi)] += 1;
  }
  for (int j = 0; j < kMu; ++j)
    for (int i = 0; i < kPhi; ++i) {
      const auto row = [&](double mu) {
        const auto at = [&](double phi) {
          return density(frame.to_world(direction_from_mu_phi(mu, phi)));
        };
        return gauss_kronrod<double, 15>::integrate(at, 2 * kPi * i / kPhi,
                                                    2 * kPi * (i + 1) / kPhi, 6, 1e-6);
      };
      expected[j * kPhi + i] =
          samples * gauss_kronrod<double, 15>::integrate(row, -1 + 2.0 * j / kMu,
                                                         -1 + 2.0 * (j + 1) / kMu, 8, 1e-6);
    }
  const double p = chi_square_p_value(observed, expected);
  if (p < test_level()) {
    std::cerr << name << ": p = " << p << "\nmu_cell phi_cell observed expected\n";
    for (int k = 0; k < kMu * kPhi; ++k)
      std::cerr << k / kPhi << ' ' << k % kPhi << ' ' << observed[k] << ' ' << expected[k] << '\n';
  }
  return p;
}

double integrate_sphere(const std::function<double(Direction)>& density, Direction axis,
                        double tolerance) {
  const Frame<double> frame = frame_around(axis);
  const auto ring = [&](double mu) {
    const auto at = [&](double phi) {
      return density(frame.to_world(direction_from_mu_phi(mu, phi)));
    };
    double sum = 0;
    for (int quarter = 0; quarter < 4; ++quarter)
      sum += gauss_kronrod<double, 15>::integrate(at, quarter * kPi / 2, (quarter + 1) * kPi / 2, 8,
                                                  tolerance);
    return sum;
  };
  double sum = 0;
  constexpr int kPanels = 8;
  for (int k = 0; k < kPanels; ++k)
    sum += gauss_kronrod<double, 15>::integrate(ring, -1 + 2.0 * k / kPanels,
                                                -1 + 2.0 * (k + 1) / kPanels, 10, tolerance);
  return sum;
}

}  // namespace lamella::testing
