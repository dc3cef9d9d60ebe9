#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "compare/drawing/color_map.h"
#include "compare/drawing/color_scale.h"

namespace lamella {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// CIE L* of an sRGB colour, in [0, 100].
double lightness(Color c) {
  const auto linear = [](int byte) {
    const double v = byte / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  const double y = 0.2126 * linear(c.r) + 0.7152 * linear(c.g) + 0.0722 * linear(c.b);
  return y <= 216.0 / 24389 ? y * 24389 / 27 : 116 * std::cbrt(y) - 16;
}

std::vector<std::string> labels(const ColorScale& scale) {
  std::vector<std::string> result;
  for (const auto& tick : scale.ticks()) result.push_back(tick.label);
  return result;
}

TEST(Viridis, EndsAreThoseOfThePublishedMapAndWhatIsBeyondIsClamped) {
  EXPECT_EQ(viridis(0), (Color{0x44, 0x01, 0x54}));
  EXPECT_EQ(viridis(1), (Color{0xfd, 0xe7, 0x25}));
  EXPECT_EQ(viridis(5.0 / 9), (Color{0x1f, 0x9e, 0x89}));
  EXPECT_EQ(viridis(-kInfinity), viridis(0));
  EXPECT_EQ(viridis(2), viridis(1));
}

TEST(Viridis, LightnessRisesAllTheWay) {
  double previous = lightness(viridis(0));
  // Finer steps are lost in the rounding to eight bits.
  for (int i = 1; i <= 64; ++i) {
    const double l = lightness(viridis(i / 64.0));
    EXPECT_GT(l, previous) << i;
    previous = l;
  }
}

TEST(DivergingColor, IsBlueBelowZeroNeutralAtZeroAndRedAbove) {
  EXPECT_EQ(diverging_color(-1), (Color{0x05, 0x30, 0x61}));
  EXPECT_EQ(diverging_color(0), (Color{0xf7, 0xf7, 0xf7}));
  EXPECT_EQ(diverging_color(1), (Color{0x67, 0x00, 0x1f}));
  EXPECT_EQ(diverging_color(-kInfinity), diverging_color(-1));
  EXPECT_EQ(diverging_color(std::nan("")), diverging_color(0));
  for (int i = 1; i <= 100; ++i) {
    const double t = i / 100.0;
    EXPECT_GT(diverging_color(t).r, diverging_color(t).b) << t;
    EXPECT_LT(diverging_color(-t).r, diverging_color(-t).b) << t;
    EXPECT_LE(lightness(diverging_color(t)), lightness(diverging_color(t - 0.01))) << t;
    EXPECT_LE(lightness(diverging_color(-t)), lightness(diverging_color(0.01 - t))) << t;
  }
}

TEST(DivergingColor, HasThe256EntriesOfRdBu) {
  // Of matplotlib's RdBu_r: entries 1, 51, 127, 128, 204 and 254.
  const auto at = [](int entry) { return diverging_color((entry + 0.5) / 128 - 1); };
  EXPECT_EQ(at(1), (Color{0x06, 0x32, 0x64}));
  EXPECT_EQ(at(51), (Color{0x43, 0x93, 0xc3}));
  EXPECT_EQ(at(204), (Color{0xd6, 0x60, 0x4d}));
  EXPECT_EQ(at(254), (Color{0x6a, 0x01, 0x1f}));
  int changes = 0;
  for (int k = 1; k < 256; ++k) changes += !(at(k) == at(k - 1));
  EXPECT_EQ(changes, 255);
}

TEST(ColorScale, OfMagnitudesStartsAtZeroEndsAtARoundNumberAndServesBothMaps) {
  const std::vector<double> a = {0.02, 0.31}, b = {0.33, std::nan(""), kInfinity};
  const ColorScale scale = magnitude_scale(a, b, false);
  EXPECT_EQ(scale.low, 0);
  EXPECT_DOUBLE_EQ(scale.high, 0.35);
  EXPECT_EQ(labels(scale),
            (std::vector<std::string>{"0", "0.05", "0.1", "0.15", "0.2", "0.25", "0.3", "0.35"}));
  EXPECT_EQ(scale.color(0), viridis(0));
  EXPECT_EQ(scale.color(kInfinity), viridis(1));
  EXPECT_EQ(magnitude_scale(b, a, false).high, scale.high);
}

TEST(ColorScale, OfMagnitudesReachesBelowZeroOnlyForNegativeValues) {
  const ColorScale scale = magnitude_scale(std::vector<double>{-0.3, 1}, {}, false);
  EXPECT_NEAR(scale.low, -0.4, 1e-15);
  EXPECT_NEAR(scale.high, 1, 1e-15);
}

TEST(ColorScale, LogarithmicSpansThePositiveValuesAndAtMostSixDecades) {
  const ColorScale scale = magnitude_scale(std::vector<double>{0, 0.003, 0.7}, {}, true);
  EXPECT_NEAR(scale.low, 0.002, 1e-15);
  EXPECT_NEAR(scale.high, 1, 1e-15);
  EXPECT_EQ(scale.color(0), viridis(0));
  EXPECT_EQ(scale.color(-1), viridis(0));
  EXPECT_NEAR(scale.position(std::sqrt(0.002)), 0.5, 1e-12);
  EXPECT_EQ(labels(magnitude_scale(std::vector<double>{1e-30, 1}, {}, true)),
            (std::vector<std::string>{"1e-06", "1e-05", "0.0001", "0.001", "0.01", "0.1", "1"}));
  EXPECT_EQ(labels(magnitude_scale(std::vector<double>{3}, {}, true)),
            (std::vector<std::string>{"2", "5"}));
  EXPECT_EQ(magnitude_scale(std::vector<double>{0, -1}, {}, true).kind, ColorScale::Kind::linear);
}

TEST(ColorScale, OfSignedValuesIsSymmetricAboutZero) {
  const ColorScale scale = signed_scale(std::vector<double>{-0.024, 0.001, std::nan("")});
  EXPECT_NEAR(scale.high, 0.03, 1e-15);
  EXPECT_EQ(scale.low, -scale.high);
  EXPECT_EQ(scale.color(0), diverging_color(0));
  EXPECT_EQ(labels(scale),
            (std::vector<std::string>{"-0.03", "-0.02", "-0.01", "0", "0.01", "0.02", "0.03"}));
  EXPECT_EQ(labels(fixed_signed_scale(4, 2)),
            (std::vector<std::string>{"-4", "-2", "0", "2", "4"}));
}

TEST(ColorScale, IsFiniteAndOrderedForAnyValues) {
  const std::vector<double> extremes = {0,    -0.0,      5e-324,     1e-310,       1e-290, 1e308,
                                        1e38, kInfinity, -kInfinity, std::nan(""), -1e308, 1};
  for (const double a : extremes)
    for (const double b : extremes)
      for (const ColorScale& scale :
           {magnitude_scale(std::vector<double>{a}, std::vector<double>{b}, false),
            magnitude_scale(std::vector<double>{a}, std::vector<double>{b}, true),
            signed_scale(std::vector<double>{a, b})}) {
        EXPECT_TRUE(std::isfinite(scale.high - scale.low)) << a << ' ' << b;
        EXPECT_LT(scale.low, scale.high) << a << ' ' << b;
        const auto ticks = scale.ticks();
        EXPECT_GE(ticks.size(), 2u) << a << ' ' << b;
        EXPECT_LE(ticks.size(), 12u) << a << ' ' << b;
        for (const double v : {a, b})
          if (!std::isnan(v)) {
            EXPECT_GE(scale.position(v), 0) << a << ' ' << b;
            EXPECT_LE(scale.position(v), 1) << a << ' ' << b;
          }
      }
}

TEST(ColorScale, ContainsEveryFiniteValue) {
  for (double v = 1e-20; v < 1e20; v *= 1.037) {
    EXPECT_GE(magnitude_scale(std::vector<double>{v}, {}, false).high, v * (1 - 1e-8));
    EXPECT_LE(magnitude_scale(std::vector<double>{v}, {}, false).high, v * 1.6);
    const ColorScale log = magnitude_scale(std::vector<double>{v, v * 1e3}, {}, true);
    EXPECT_LE(log.low, v * (1 + 1e-8));
    EXPECT_GE(log.high, v * 1e3 * (1 - 1e-8));
    EXPECT_GE(signed_scale(std::vector<double>{-v}).high, v * (1 - 1e-8));
  }
}

}  // namespace
}  // namespace lamella
