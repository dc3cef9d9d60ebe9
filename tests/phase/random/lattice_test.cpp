#include "phase/random/lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <set>
#include <vector>

#include "phase/random/lattice_generator.h"

namespace lamella {
namespace {

constexpr double kPiSquared = 9.869604401089358;

// A coordinate of the lattice, in the order in which it is chosen: row and column of the vector.
struct Component {
  int row, word;
  double weight;
};

// Early numbers of a walk matter more: 0.7 times as much with each step. Flight and the first two
// words of an event, which all media take, matter more than words that few media take and the place
// that next-event estimation aims at.
std::vector<Component> components() {
  constexpr int kOrder[kLatticeWords] = {1, 2, 0, 8, 9, 3, 4, 5, 6, 7};
  constexpr double kMain = 0.2, kAim = 0.01, kOther = 0.02;
  constexpr double kWeights[kLatticeWords] = {kMain,  kMain,  kMain,  kOther, kOther,
                                              kOther, kOther, kOther, kAim,   kAim};
  std::vector<Component> list{{0, 0, kMain}};
  for (int step = 0; step < kLatticeSteps; ++step) {
    for (const int word : kOrder)
      list.push_back({1 + step, word, kWeights[word] * std::pow(0.7, step)});
    if (step != 2) continue;
    list.push_back({0, 1, kOther});  // roulette
    list.push_back({0, 2, kOther});  // thinning
  }
  return list;
}

constexpr int kFewestBits = 9, kMostBits = 14;
// Of the first three steps and of the others.
constexpr int kEarlyCandidates = 1024, kCandidates = 256;

// The squared worst-case error of the first 2^m points, m from kFewestBits to kMostBits, for
// functions whose Fourier coefficients fall like 1 / k in each coordinate, weighted: the mean of
// the products of 1 + weight 2 pi^2 B_2(x), less 1. Its logarithms' sum over m.
double error_of(const std::vector<double>& products, std::uint32_t generator, double weight) {
  double sum = 0, logarithms = 0;
  std::uint32_t j = 0;
  for (int m = 0; m <= kMostBits; ++m) {
    for (; j < 1u << m; ++j) {
      const double x = reversed_bits(j) * generator * 0x1p-32;
      sum += products[j] * (1 + weight * 2 * kPiSquared * ((x - 1) * x + 1.0 / 6));
    }
    if (m >= kFewestBits) logarithms += std::log(std::ldexp(sum, -m) - 1);
  }
  return logarithms;
}

// Component by component the best of some random odd numbers.
TEST(LatticeGenerator, IsWhatTheSearchByComponentsFinds) {
  std::vector<double> products(1 << kMostBits, 1.0);
  std::uint64_t state = 1;
  const auto candidate = [&] {  // splitmix64
    std::uint64_t z = (state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return static_cast<std::uint32_t>(z ^ (z >> 31)) | 1u;
  };
  const std::vector<Component> list = components();
  for (const Component& c : list) {
    std::uint32_t best = 1;
    double least = std::numeric_limits<double>::infinity();
    const int candidates = &c == &list[0] ? 0 : c.row <= 3 ? kEarlyCandidates : kCandidates;
    for (int k = 0; k < candidates; ++k) {
      const std::uint32_t generator = candidate();
      const double error = error_of(products, generator, c.weight);
      if (!(error < least)) continue;
      least = error;
      best = generator;
    }
    EXPECT_EQ(kLatticeGenerator[c.row][c.word], best) << c.row << " " << c.word;
    for (std::uint32_t j = 0; j < products.size(); ++j) {
      const double x = reversed_bits(j) * best * 0x1p-32;
      products[j] *= 1 + c.weight * 2 * kPiSquared * ((x - 1) * x + 1.0 / 6);
    }
  }
}

// Against as many random points: their squared error is the product of 1 + weight 2 pi^2 B_2(0),
// less 1, over their number. Numbers before the first step, of the first two and half of the third.
TEST(LatticeGenerator, IsBetterThanRandomPointsOfAnyNumber) {
  constexpr int kMost = 14;
  std::vector<Component> list = components();
  list.resize(26);
  double random = 1;
  for (const Component& c : list) random *= 1 + c.weight * 2 * kPiSquared / 6;
  double sum = 0;
  std::uint32_t j = 0;
  for (int m = 0; m <= kMost; ++m) {
    for (; j < 1u << m; ++j) {
      double product = 1;
      for (const Component& c : list) {
        const double x = reversed_bits(j) * kLatticeGenerator[c.row][c.word] * 0x1p-32;
        product *= 1 + c.weight * 2 * kPiSquared * ((x - 1) * x + 1.0 / 6);
      }
      sum += product;
    }
    if (m < 6) continue;
    const double ratio = (std::ldexp(sum, -m) - 1) / std::ldexp(random - 1, -m);
    std::printf("2^%d points: %.3f of the squared error of random points\n", m, ratio);
    EXPECT_LT(ratio, 1) << m;
  }
}

TEST(Lattice, ReversesBits) {
  EXPECT_EQ(reversed_bits(1u), 0x80000000u);
  EXPECT_EQ(reversed_bits(0x12345678u), 0x1E6A2C48u);
  EXPECT_EQ(reversed_bits(~0u), ~0u);
}

// The first 2^m walks have one number in each of 2^m equal intervals, for every word and any shift.
TEST(Lattice, EveryWordIsStratified) {
  const LatticeNumbers numbers = lattice_of_batch(lattice_shift(7, 3, 0));
  for (const int bits : {1, 5, 10})
    for (int word = 0; word < kLatticeWords; ++word)
      for (std::uint32_t step = 0; step < kLatticeSteps; ++step) {
        std::set<std::uint32_t> intervals;
        std::uint32_t place = 0;
        for (std::uint32_t j = 0; j < 1u << bits; ++j) {
          const std::uint32_t x = lattice_word(numbers, word, step, reversed_bits(j), 0u);
          if (j == 0) place = x & ((1u << (32 - bits)) - 1);
          EXPECT_EQ(x & ((1u << (32 - bits)) - 1), place);
          intervals.insert(x >> (32 - bits));
        }
        ASSERT_EQ(intervals.size(), 1u << bits) << word << " " << step;
      }
}

TEST(Lattice, ABatchHasTheSameNumbersAloneAndAmongOthers) {
  const std::uint32_t shift = lattice_shift(1, 77, 0);
  const LatticeNumbers alone = lattice_of_batch(shift), among = lattice_of_batches();
  for (const std::uint32_t j : {0u, 1u, 12345u, 0xFFFFFFFFu}) {
    for (int word = 0; word < kLatticeWords; ++word)
      for (std::uint32_t step = 0; step < 16; ++step)
        ASSERT_EQ(lattice_word(alone, word, step, reversed_bits(j), shift),
                  lattice_word(among, word, step, reversed_bits(j), shift));
    for (int word = 0; word < kLatticeBeginnings; ++word)
      ASSERT_EQ(lattice_beginning(alone, word, reversed_bits(j), shift),
                lattice_beginning(among, word, reversed_bits(j), shift));
  }
}

// Over batches each word is uniform and no two of a walk are correlated: the shifts make the
// estimates unbiased. 2^14 batches: correlations of independent words have the deviation 2^-7.
TEST(Lattice, ShiftsMakeWordsUniformAndIndependent) {
  constexpr int kBatches = 1 << 14, kWords = kLatticeWords * kLatticeSteps;
  std::vector<double> mean(kWords);
  std::vector<std::vector<double>> words(kWords, std::vector<double>(kBatches));
  for (int b = 0; b < kBatches; ++b) {
    const LatticeNumbers numbers =
        lattice_of_batch(lattice_shift(5, static_cast<std::uint32_t>(b), 0));
    for (int k = 0; k < kWords; ++k)
      words[k][b] =
          lattice_word(numbers, k % kLatticeWords, static_cast<std::uint32_t>(k / kLatticeWords),
                       reversed_bits(1234u), 0u) *
              0x1p-32 -
          0.5;
  }
  // kWords means and kWords^2 / 2 products: 6 deviations happen by chance once in a million.
  for (int a = 0; a < kWords; ++a) {
    double sum = 0;
    for (const double x : words[a]) sum += x;
    EXPECT_LT(std::abs(sum / kBatches), 6 * std::sqrt(1.0 / 12 / kBatches)) << a;
    for (int c = 0; c < a; ++c) {
      double product = 0;
      for (int b = 0; b < kBatches; ++b) product += words[a][b] * words[c][b];
      EXPECT_LT(std::abs(product / kBatches), 6.0 / 12 / std::sqrt(kBatches)) << a << " " << c;
    }
  }
}

TEST(Lattice, AnotherLatticeHasAnotherShift) {
  EXPECT_EQ(lattice_shift(1, 5, 0), lattice_shift(1, 5, kLatticePoints - 1));
  EXPECT_NE(lattice_shift(1, 5, 0), lattice_shift(1, 5, kLatticePoints));
  EXPECT_EQ(lattice_point(kLatticePoints + 3), 3u);
  EXPECT_NE(lattice_shift(1, 5, 0), lattice_shift(1, 6, 0));
  EXPECT_NE(lattice_shift(1, 5, 0), lattice_shift(2, 5, 0));
}

}  // namespace
}  // namespace lamella
