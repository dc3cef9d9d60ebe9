#include "analytic/model/directional_integral.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "phase/random/random.h"

namespace lamella {
namespace {

constexpr std::array kUpper{1.0};
constexpr std::array kBoth{1.0, -1.0};

DirectionalFunction of_each(const std::function<Rgb(Direction)>& f) {
  return [f](std::span<const Direction> directions, std::span<Rgb> values) {
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = f(directions[k]);
  };
}

/// The value within the told error and `also`, and the error below `most`.
void expect_integral(const DirectionalIntegral& found, double right, double most) {
  for (int c = 0; c < 3; ++c) {
    EXPECT_LE(std::abs(found.value[c] - right), found.error[c] + 1e-15 * std::abs(right));
    EXPECT_LE(found.error[c], most);
  }
}

const Direction kLight = direction_from_degrees(50, 30);

TEST(DirectionalIntegral, SmoothFunctionsReachTheTolerance) {
  const auto one = integrate_projected(of_each([](Direction) { return Rgb(1); }), kLight, kBoth);
  expect_integral(one, 2 * kPi, 1e-8);
  EXPECT_EQ(one.end, IntegralEnd::tolerance);
  // Integral of cos^(k + 1) over the hemisphere: 2 pi / (k + 2).
  for (const int k : {1, 5, 200}) {
    const auto power = integrate_projected(
        of_each([k](Direction w) { return Rgb(std::pow(w.z, k)); }), kLight, kUpper);
    expect_integral(power, 2 * kPi / (k + 2), 1e-8);
    EXPECT_EQ(power.end, IntegralEnd::tolerance) << k;
  }
}

TEST(DirectionalIntegral, ChannelsHaveTheirOwnErrors) {
  const auto found = integrate_projected(
      of_each([](Direction w) { return Rgb(0, w.z, std::sqrt(std::abs(w.x))); }), kLight, kUpper);
  EXPECT_EQ(found.value.r, 0);
  EXPECT_EQ(found.error.r, 0);
  EXPECT_NEAR(found.value.g, 2 * kPi / 3, found.error.g + 1e-15);
  // Over the unit disc: 4 / (5/2) B(3/4, 1/2) / 2, B Euler's beta.
  EXPECT_NEAR(found.value.b, 0.8 * std::beta(0.75, 0.5), found.error.b + 1e-15);
  EXPECT_LT(found.error.b, 1e-7);
}

TEST(DirectionalIntegral, PeaksWhereModelsHaveThemAreFound) {
  // A Gaussian of the projected direction about a place: its integral is 1 where the disc holds it.
  for (const double width : {1e-2, 1e-3, 1e-4})
    for (const double theta : {0.0, 2.0, 50.0, 80.0}) {
      const Direction light = direction_from_degrees(theta, 30);
      for (const Direction& about : {light, Direction{-light.x, -light.y, light.z}}) {
        if (theta == 80 && width > 1e-3) continue;  // reaches over the rim
        const auto found = integrate_projected(
            of_each([&](Direction w) {
              const double dx = w.x - about.x, dy = w.y - about.y;
              return Rgb(std::exp(-(dx * dx + dy * dy) / (width * width)) / (kPi * width * width));
            }),
            light, kUpper);
        SCOPED_TRACE(::testing::Message() << width << ' ' << theta);
        expect_integral(found, 1, 1e-6);
      }
    }
}

TEST(DirectionalIntegral, RandomNoiseEndsTheSearchAndIsTold) {
  for (const double size : {1e-1, 1e-4, 1e-7, 1e-10}) {
    std::uint64_t at = 0;
    const auto found =
        integrate_projected(of_each([&](Direction w) {
                              RandomStream stream(1, at++, StreamPurpose::test);
                              return Rgb((1 + w.x) * (1 + size * (2 * stream.uniform() - 1)));
                            }),
                            kLight, kUpper);
    SCOPED_TRACE(size);
    EXPECT_TRUE(size < 1e-9 || found.end == IntegralEnd::noise) << to_text(found.end);
    EXPECT_LT(found.evaluations, 100000u);
    // Four standard deviations of uniform noise are 2.3 times its size; the estimate is the least
    // of three.
    expect_integral(found, kPi, kPi * (4 * size + 1e-8));
    EXPECT_GT(found.error.r, 0.5 * kPi * size);
  }
}

TEST(DirectionalIntegral, RoundingToSinglePrecisionIsNoise) {
  const auto smooth = [](Direction w) { return 1 / (0.05 + (1 - w.z) + w.x * w.x); };
  const auto right =
      integrate_projected(of_each([&](Direction w) { return Rgb(smooth(w)); }), kLight, kUpper);
  EXPECT_EQ(right.end, IntegralEnd::tolerance);
  const auto found = integrate_projected(of_each([&](Direction w) {
                                           const float x = static_cast<float>(w.x),
                                                       z = static_cast<float>(w.z);
                                           return Rgb(1.0F / (0.05F + (1.0F - z) + x * x));
                                         }),
                                         kLight, kUpper);
  EXPECT_NE(found.end, IntegralEnd::limit);
  EXPECT_LT(found.evaluations, 200000u);
  expect_integral(found, right.value.r, 1e-5 * right.value.r);
}

TEST(DirectionalIntegral, JumpsEndAtTheLimitWithTheirError) {
  // x < 0.3 z: half the disc and half an ellipse.
  const double right = kPi / 2 * (1 + 0.3 / std::sqrt(1.09));
  const auto found = integrate_projected(
      of_each([](Direction w) { return Rgb(w.x < 0.3 * w.z ? 1 : 0); }), kLight, kUpper);
  EXPECT_EQ(found.end, IntegralEnd::limit);
  expect_integral(found, right, 1e-3);
  EXPECT_LT(found.evaluations, 2001000u);
}

TEST(DirectionalIntegral, SingularitiesAtGrazingAreIntegratedOrTold) {
  const auto finite = integrate_projected(
      of_each([](Direction w) { return Rgb(0.625 / kPi * std::pow(w.z, -0.75)); }), kLight, kUpper);
  expect_integral(finite, 1, 1e-4);
  const auto infinite = integrate_projected(
      of_each([](Direction w) { return Rgb(1 / (w.z * w.z)); }), kLight, kUpper);
  EXPECT_NE(infinite.end, IntegralEnd::tolerance);
  EXPECT_GT(infinite.error.r, 1e-3 * infinite.value.r);
}

TEST(DirectionalIntegral, WhatIsNarrowerThanAnyPanelIsError) {
  const auto found = integrate_projected(of_each([](Direction w) {
                                           const double r2 = w.x * w.x + w.y * w.y;
                                           return Rgb(std::exp(-r2 * 1e14) * 1e14 / kPi);
                                         }),
                                         {0, 0, 1}, kUpper);
  EXPECT_EQ(found.end, IntegralEnd::limit);
  expect_integral(found, 1, 1e9);
  EXPECT_GT(found.error.r, 1);
}

TEST(DirectionalIntegral, TimeIsBounded) {
  IntegralLimits limits;
  limits.seconds = 0.05;
  limits.evaluations = 1000000000;
  const auto found = integrate_projected(
      of_each([](Direction w) { return Rgb(w.x < 0.3 * w.z ? 1 : 0); }), kLight, kUpper, limits);
  EXPECT_EQ(found.end, IntegralEnd::time);
}

TEST(DirectionalIntegral, ValuesThatAreNotFiniteStopItWithTheirPlace) {
  for (const double bad : {std::nan(""), HUGE_VAL, 1e308}) {
    try {
      (void)integrate_projected(of_each([&](Direction w) { return Rgb(w.z < 0.2 ? bad : 1); }),
                                kLight, kUpper);
      FAIL() << bad;
    } catch (const std::domain_error& error) {
      EXPECT_NE(std::string(error.what()).find("finite"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace lamella
