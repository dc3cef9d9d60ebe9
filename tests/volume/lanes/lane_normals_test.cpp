// Visible normals of vMF flakes from tables: the tables against the integrals that they invert, the
// normals against their density, the projected area against its own.
#include "volume/lanes/lane_normals.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <limits>

#include "phase/medium/vmf.h"
#include "phase/random/random.h"
#include "tests/statistics/statistics.h"
#include "tests/volume/run/stacks.h"
#include "volume/lanes/lane_media.h"
#include "volume/lanes/lane_setting.h"

namespace lamella {
namespace {

using testing::sampler_p_value;
using testing::test_level;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Stack flakes_of(double alpha, Direction axis) {
  return testing::stack_from(testing::layer(
      fmt::format("medium = 'vmf_flake'\nalpha = {}\naxis = [{}, {}, {}]\nthickness = 1", alpha,
                  axis.x, axis.y, axis.z)));
}

// The flakes as walks in double meet them.
struct Flakes {
  explicit Flakes(double roughness, Direction axis = {0, 0, 1})
      : alpha(roughness),
        stack(flakes_of(alpha, axis)),
        setting(stack, make_plan(stack), axis, 1),
        lanes(OneLayer<double>{setting.layers, 0}) {}
  double alpha;
  Stack stack;
  LaneSetting<double> setting;
  VmfLambertOnLanes<double> lanes;
};

// cos(g)^2 exp(c (cos(g) - 1)), or exp(c cos(g)) where c < 0.
double side_density(double c, double g) {
  const double cosine = std::cos(g), half = std::sin(g / 2);
  return cosine * cosine * std::exp(c < 0 ? c * cosine : -2 * c * half * half);
}

// Integrals from `from` to `to` over equal panels, cumulated.
template <class Density>
std::vector<double> cumulated(const Density& density, double from, double to, int panels) {
  std::vector<double> sums(panels + 1);
  for (int k = 0; k < panels; ++k)
    sums[k + 1] = sums[k] + boost::math::quadrature::gauss<double, 7>::integrate(
                                density, from + (to - from) * k / panels,
                                from + (to - from) * (k + 1) / panels);
  return sums;
}

// The cumulative probability at x.
template <class Density>
double probability_at(const Density& density, const std::vector<double>& sums, double from,
                      double to, double x) {
  const int panels = static_cast<int>(sums.size()) - 1;
  const int k = std::clamp(static_cast<int>((x - from) / (to - from) * panels), 0, panels - 1);
  const double start = from + (to - from) * k / panels;
  const double part =
      x > start ? boost::math::quadrature::gauss<double, 7>::integrate(density, start, x) : 0;
  return (sums[k] + part) / sums.back();
}

TEST(LaneNormals, TheAngleBesideThePlaneInvertsItsDistribution) {
  const Flakes flakes(1);
  for (const double c :
       {0.0, 0.3, 2.0, 7.0, 20.0, 300.0, 1e5, 2e6, -0.5, -1.4, -1.6, -4.0, -30.0}) {
    const double end = c > 45 ? std::acos(1 - 45 / c) : kPi / 2;
    const auto density = [c](double g) { return side_density(c, g); };
    const std::vector<double> sums = cumulated(density, 0, end, 400);
    for (int k = 0; k < 100; ++k) {
      const double u = (k + 0.37) / 100;
      const VmfOnLanes<double>::Half half(static_cast<std::uint32_t>(u * 0x1p31));
      const auto [sine, cosine] = flakes.lanes.side_angle(c, half);
      const double below =
          probability_at(density, sums, 0, end, std::min(std::atan2(sine, cosine), end));
      // The first half of the words are probabilities beyond, or below where c is small.
      EXPECT_NEAR(c < kLeastFront ? below : 1 - below, u, c < kLeastFront ? 1e-4 : kNormalError)
          << c << ' ' << u;
    }
  }
}

TEST(LaneNormals, TheAngleInThePlaneInvertsItsDistribution) {
  for (const double alpha : {kInfinity, 3.0, 1.0, 0.5, 0.1, 0.01, 0.001}) {
    const Flakes flakes(alpha);
    const double kappa = vmf_concentration(alpha), width = 1 / std::sqrt(kappa + 1);
    for (const double place : {-4.0, -2.0, -0.7, -0.1, 0.0, 0.4, 1.3, 3.0, 9.0, 1e9}) {
      const double u = std::clamp(place * width, -1.0, 1.0);
      const double psi = std::asin(u), s = std::sqrt((1 - u) * (1 + u));
      // From behind flakes of this size two lobes are far apart: there it is within 1e-3.
      const bool two_lobes = alpha == 0.5 && u < -0.9;
      if (vmf_sigma(u, alpha) < 1e-9) continue;
      const double least = u < 0 ? 2 * kappa * std::pow(std::sin(psi / 2), 2) : 0;
      const double reach = (least + 45) / (2 * std::max(kappa, 1e-9));
      const double end = reach < 0.5 ? 2 * std::asin(std::sqrt(reach)) : kPi - psi;
      const double from = std::max(-psi, -end), to = std::min(end, kPi - psi);
      const auto density = [&](double b) {
        const double c = kappa * std::cos(b), half = std::sin(b / 2);
        const double side = c > 45 ? std::acos(1 - 45 / c) : kPi / 2;
        const double sum = boost::math::quadrature::gauss<double, 30>::integrate(
            [c](double g) { return side_density(c, g); }, 0, side);
        return std::sin(std::max(b + psi, 0.0)) * sum *
               std::exp(least + (c < 0 ? -kappa : -2 * kappa * half * half));
      };
      const std::vector<double> sums = cumulated(density, from, to, 200);
      for (int k = 0; k < 100; ++k) {
        const double p = (k + 0.5) / 100;
        // The normal at the middle of the other distribution lies in the plane.
        const std::uint32_t words[] = {static_cast<std::uint32_t>(p * 0x1p32), 0x7FFFFFFFu};
        const Direction w{s, 0, u};
        const Direction m = flakes.lanes.normal(w, u, flakes.lanes.row_from_behind(u), words);
        EXPECT_NEAR(dot(m, m), 1, 1e-12);
        double b = std::atan2(
            s > 1e-5 ? m.x : m.x * flakes.lanes.across.x + m.y * flakes.lanes.across.y, m.z);
        if (b < from - 0.1) b += 2 * kPi;
        EXPECT_NEAR(probability_at(density, sums, from, to, std::clamp(b, from, to)), p,
                    two_lobes ? 1e-3 : 2 * kNormalError)
            << alpha << ' ' << u;
      }
    }
  }
}

TEST(LaneNormals, SigmaIsTheProjectedArea) {
  for (const double alpha : {kInfinity, 2.0, 0.5, 0.1, 0.01, 0.001}) {
    const Flakes flakes(alpha);
    const double width = std::min(1.0, 8 * alpha);
    for (int k = -50; k <= 50; ++k) {
      const double u = k / 50.0 * (k < 0 ? width : 1), exact = vmf_sigma(u, alpha);
      if (exact < 1e-20) continue;
      const Direction w{std::sqrt((1 - u) * (1 + u)), 0, u};
      EXPECT_NEAR(flakes.lanes.sigma(w) / exact, 1, 1e-5) << alpha << ' ' << u;
    }
  }
}

TEST(LaneNormals, FollowTheVisibleNormalsDensity) {
  const Direction tilted = normalized(Direction{0.5, -0.3, 0.8});
  for (const double alpha : {0.001, 0.02, 0.3, 1.5, kInfinity})
    for (const Direction axis : {Direction{0, 0, 1}, tilted}) {
      const Flakes flakes(alpha, axis);
      const double kappa = vmf_concentration(alpha);
      for (const double theta : {0.0, 40.0, 85.0, 95.0, 130.0, 180.0}) {
        const Direction w = frame_around(axis).to_world(direction_from_degrees(theta, 70));
        const double u = dot(w, axis), sigma = vmf_sigma(u, alpha);
        if (sigma < 1e-6 || (alpha < 0.3 && u < 0)) continue;  // the tables' tests have those
        const double p_value = sampler_p_value(
            fmt::format("alpha {} from {} degrees", alpha, theta),
            {.axis = axis, .width = std::min(alpha, 1.0)},
            [&](RandomStream& stream) {
              const std::uint32_t words[] = {stream.bits(), stream.bits()};
              return flakes.lanes.normal(w, u, flakes.lanes.row_from_behind(u), words);
            },
            [&](Direction m) {
              return std::max(dot(w, m), 0.0) * vmf_density(kappa, std::min(dot(m, axis), 1.0)) /
                     sigma;
            },
            50000);
        EXPECT_GE(p_value, test_level());
      }
    }
}

}  // namespace
}  // namespace lamella
