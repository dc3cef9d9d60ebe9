#include "compare/preview/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "phase/random/random.h"

namespace lamella::testing {
namespace {

constexpr int kSide = 32;

std::vector<Rgb> constant(Rgb color) { return std::vector<Rgb>(kSide * kSide, color); }

std::vector<Rgb> random_picture(std::uint64_t seed) {
  RandomStream stream(seed, 0, StreamPurpose::test);
  std::vector<Rgb> picture;
  for (int k = 0; k < kSide * kSide; ++k) {
    const double r = stream.uniform(), g = stream.uniform(), b = stream.uniform();
    picture.emplace_back(r, g, b);
  }
  return picture;
}

double largest_difference(const std::vector<double>& values, double from) {
  double most = 0;
  for (const double v : values) most = std::max(most, std::abs(v - from));
  return most;
}

}  // namespace

TEST(Flip, IsZeroForEqualPictures) {
  const std::vector<Rgb> picture = random_picture(1);
  EXPECT_EQ(largest_difference(flip_errors(kSide, kSide, picture, picture), 0), 0);
}

TEST(Flip, IsSymmetricAndAtMostOne) {
  const std::vector<Rgb> a = random_picture(2), b = random_picture(3);
  const auto forth = flip_errors(kSide, kSide, a, b), back = flip_errors(kSide, kSide, b, a);
  for (std::size_t k = 0; k < forth.size(); ++k) {
    EXPECT_DOUBLE_EQ(forth[k], back[k]);
    EXPECT_GE(forth[k], 0);
    EXPECT_LE(forth[k], 1);
  }
}

// Constant pictures have neither edges nor points, and blurring leaves them as they are: the error
// is that of the colours alone. With q = 0.7, of the largest distance, 203.300 between green and
// blue, M = 203.300^q = 41.2757: below 0.4 M the error is 0.95 d^q / (0.4 M).
TEST(Flip, OfConstantColorsIsWorkedOutByHand) {
  const auto error = [](Rgb a, Rgb b) {
    const auto errors = flip_errors(kSide, kSide, constant(a), constant(b));
    EXPECT_LT(largest_difference(errors, errors.front()), 1e-9);
    return errors.front();
  };
  // Greys of linear 0.5 and 0.25: L is 76.0693 and 57.0754, d = 18.9938, d^q = 7.8529.
  EXPECT_NEAR(error(Rgb(0.5), Rgb(0.25)), 0.45185, 1e-5);
  // Black and white: d = 100, above the knee: 0.95 + 0.05 (25.1189 - 16.5103) / 24.7654.
  EXPECT_NEAR(error(Rgb(0), Rgb(1)), 0.96738, 1e-5);
  EXPECT_NEAR(error(Rgb(0, 1, 0), Rgb(0, 0, 1)), 1, 1e-9);
  // Two bluish colours, d = 6.47212.
  EXPECT_NEAR(error(Rgb(0.2, 0.4, 0.6), Rgb(0.25, 0.4, 0.5)), 0.21267, 1e-5);
}

TEST(Flip, CutsWhatADisplayCannotShow) {
  const auto errors = flip_errors(kSide, kSide, constant(Rgb(1)), constant(Rgb(7, 9, 2)));
  EXPECT_EQ(largest_difference(errors, 0), 0);
}

TEST(Flip, DoesNotSeeAPatternBelowTheEyesResolution) {
  std::vector<Rgb> board;
  for (int k = 0; k < kSide * kSide; ++k)
    board.push_back(Rgb((k % kSide + k / kSide) % 2 ? 1.0 : 0.0));
  const auto at = [&](double pixels_per_degree) {
    // Away from the edges, whose pixels go on beyond them.
    return flip_errors(kSide, kSide, board, constant(Rgb(0.5)),
                       pixels_per_degree)[kSide / 2 * kSide + kSide / 2];
  };
  EXPECT_LT(at(67), 0.01);
  EXPECT_GT(at(4), 0.5);
}

TEST(Flip, RaisesAnErrorWherePointsAndEdgesAppear) {
  // The same step in lightness, as an edge of the test picture alone.
  std::vector<Rgb> step = constant(Rgb(0.5));
  for (int k = 0; k < kSide * kSide; ++k)
    if (k % kSide >= kSide / 2) step[static_cast<std::size_t>(k)] = Rgb(0.3);
  const auto flat = flip_errors(kSide, kSide, constant(Rgb(0.5)), constant(Rgb(0.3)));
  const auto edged = flip_errors(kSide, kSide, constant(Rgb(0.5)), step);
  const std::size_t beside = kSide / 2 * kSide + kSide / 2 + 2;
  EXPECT_GT(edged[beside], flat[beside]);
  // Far from the edge, at the picture's right end, the error is that of the colours.
  EXPECT_NEAR(edged[kSide / 2 * kSide + kSide - 1], flat.front(), 2e-3);
}

}  // namespace lamella::testing
