#include "phase/random/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "phase/random/block_random.h"
#include "tests/statistics/statistics.h"

namespace lamella::testing {
namespace {

// Known answers of Random123's own test, kat_vectors, "philox4x32 7": counter, key, answer.
TEST(RandomStream, IsPhiloxOfSevenRounds) {
  using Words = std::array<std::uint32_t, 4>;
  struct Answer {
    Words counter;
    std::array<std::uint32_t, 2> key;
    Words words;
  };
  const auto ones = ~std::uint32_t{0};
  for (const Answer& known :
       {Answer{{0, 0, 0, 0}, {0, 0}, {0x5f6fb709, 0x0d893f64, 0x4f121f81, 0x4f730a48}},
        Answer{{ones, ones, ones, ones},
               {ones, ones},
               {0x5207ddc2, 0x45165e59, 0x4d8ee751, 0x8c52f662}}}) {
    r123::Philox4x32::ctr_type counter;
    std::copy(known.counter.begin(), known.counter.end(), counter.v);
    const auto answer = r123::Philox4x32_R<7>()(counter, {{known.key[0], known.key[1]}});
    EXPECT_TRUE(std::equal(known.words.begin(), known.words.end(), answer.v));
  }
  RandomStream stream(0, 0, StreamPurpose::walk);
  for (const std::uint32_t word : {0x5f6fb709U, 0x0d893f64U, 0x4f121f81U, 0x4f730a48U})
    EXPECT_EQ(stream.bits(), word);
}

TEST(RandomStream, DependsOnEveryBitOfSeedIndexAndPurpose) {
  std::set<std::uint32_t> first;
  const auto add = [&](std::uint64_t seed, std::uint64_t index, StreamPurpose purpose) {
    first.insert(RandomStream(seed, index, purpose).bits());
  };
  add(0, 0, StreamPurpose::walk);
  for (int bit = 0; bit < 64; ++bit) {
    add(std::uint64_t{1} << bit, 0, StreamPurpose::walk);
    add(0, std::uint64_t{1} << bit, StreamPurpose::walk);
  }
  for (const auto purpose : {StreamPurpose::targets, StreamPurpose::test, StreamPurpose::model})
    add(0, 0, purpose);
  EXPECT_EQ(first.size(), 1U + 128U + 3U);
}

TEST(RandomStream, NeighbouringStreamsAreUncorrelated) {
  constexpr int kStreams = 200000;
  std::vector<double> products;
  for (const auto purpose : {StreamPurpose::walk, StreamPurpose::targets}) {
    products.clear();
    double last = RandomStream(1, 0, StreamPurpose::walk).uniform();
    for (int k = 1; k < kStreams; ++k) {
      const double next = RandomStream(1, k, purpose).uniform();
      products.push_back((last - 0.5) * (next - 0.5));
      last = next;
    }
    EXPECT_GE(mean_p_value(products, 0), test_level());
  }
}

TEST(RandomStream, UniformIsEvenAndNeverAtItsEnds) {
  // The ends themselves: the least and the largest word.
  EXPECT_GT(0.5 * 0x1p-32, 0);
  EXPECT_LT((0xffffffffU + 0.5) * 0x1p-32, 1);
  RandomStream stream(2, 0, StreamPurpose::test);
  constexpr int kCells = 256, kSamples = 1 << 21;
  std::vector<double> observed(kCells), expected(kCells, kSamples / double{kCells});
  for (int n = 0; n < kSamples; ++n) {
    const double u = stream.uniform();
    ASSERT_TRUE(u > 0 && u < 1);
    ASSERT_EQ(std::ldexp(u, 33), std::floor(std::ldexp(u, 33)));
    observed[static_cast<int>(u * kCells)] += 1;
  }
  EXPECT_GE(chi_square_p_value(observed, expected), test_level());
}

TEST(RandomStream, ExponentialHasMeanVarianceAndTailOfOne) {
  RandomStream stream(4, 0, StreamPurpose::test);
  constexpr int kSamples = 1 << 21;
  std::vector<double> values(kSamples), squares, tail;
  for (double& v : values) {
    v = stream.exponential();
    ASSERT_GT(v, 0);
    ASSERT_TRUE(std::isfinite(v));
    squares.push_back((v - 1) * (v - 1));
    tail.push_back(v > 10 ? 1 : 0);
  }
  EXPECT_GE(mean_p_value(values, 1), test_level());
  EXPECT_GE(mean_p_value(squares, 1), test_level());
  EXPECT_GE(mean_p_value(tail, std::exp(-10.0)), test_level());
  // Memoryless cells of equal probability
  constexpr int kCells = 128;
  std::vector<double> observed(kCells), expected(kCells, kSamples / double{kCells});
  for (const double v : values)
    observed[std::min(static_cast<int>(std::exp(-v) * kCells), kCells - 1)] += 1;
  EXPECT_GE(chi_square_p_value(observed, expected), test_level());
}

// The first numbers of the authors' xoshiro128plus.c from the state 1, 2, 3, 4.
TEST(WalkNumbers, AreThoseOfXoshiro128Plus) {
  const WordBlock<std::uint32_t> state{{1, 2, 3, 4}};
  WalkNumbers<std::uint32_t> numbers(state);
  for (const std::uint32_t expected : {5u, 12295u, 25178119u, 27286542u, 39879690u, 1140358681u,
                                       3276312097u, 4110231701u, 399823256u, 2144435200u})
    EXPECT_EQ(numbers.next(), expected);
}

}  // namespace
}  // namespace lamella::testing
