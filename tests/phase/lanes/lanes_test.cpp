// Lanes of float on every instruction set that the machine has, against double.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>

#include "phase/random/block_random.h"
#include "phase/random/random.h"
#include "phase/surface/microfacet_formulas.h"
#include "tests/phase/lanes/lane_probe.h"

namespace lamella {
namespace {

std::vector<Isa> lane_isas() {
  std::vector<Isa> list = supported_isas();
  list.erase(list.begin());  // scalar
  return list;
}

class Lanes : public ::testing::TestWithParam<Isa> {};

constexpr std::size_t kMany = 1 << 14;

std::vector<float> spread(double from, double to) {
  std::vector<float> x(kMany);
  for (std::size_t i = 0; i < kMany; ++i)
    x[i] = static_cast<float>(from + (to - from) * (static_cast<double>(i) + 0.5) / kMany);
  return x;
}

TEST_P(Lanes, LogarithmAndExponentialKeepTheirStatedErrors) {
  for (const auto& x :
       {spread(-87, 88), spread(-1, 0.9999), spread(0.999, 1.001), spread(1e-10, 1e-6)}) {
    std::vector<float> log(kMany), exp(kMany), sine(kMany), cosine(kMany);
    probe_math_for(GetParam())(x.data(), log.data(), exp.data(), sine.data(), cosine.data(), kMany);
    for (std::size_t i = 0; i < kMany; ++i) {
      const double v = x[i], l = std::log(std::abs(v));
      if (v > -87) {
        EXPECT_NEAR(exp[i], std::exp(v), 2e-7 * std::exp(v)) << v;
      }
      double allowed = 1.2e-7 * std::max(1.0, std::abs(l));
      if (std::abs(v) > 0.5 && std::abs(v) < 2) allowed = std::min(allowed, 3e-7 * std::abs(l));
      EXPECT_NEAR(log[i], l, allowed) << v;
    }
  }
}

TEST_P(Lanes, SineAndCosineKeepTheirStatedError) {
  const auto x = spread(-M_PI / 4, M_PI / 4);
  std::vector<float> log(kMany), exp(kMany), sine(kMany), cosine(kMany);
  probe_math_for(GetParam())(x.data(), log.data(), exp.data(), sine.data(), cosine.data(), kMany);
  for (std::size_t i = 0; i < kMany; ++i) {
    EXPECT_NEAR(sine[i], std::sin(static_cast<double>(x[i])), 1.2e-7);
    EXPECT_NEAR(cosine[i], std::cos(static_cast<double>(x[i])), 1.2e-7);
  }
}

TEST_P(Lanes, TurnsKeepTheirStatedErrorAllAround) {
  const auto turns = spread(0, 1);
  std::vector<float> x(kMany), y(kMany), found(kMany);
  for (const double radius : {1.0, 1e-6})
    for (int shift = 0; shift < 2; ++shift) {  // the second time with the axes themselves
      for (std::size_t i = 0; i < kMany; ++i) {
        const double t = 2 * M_PI * (shift ? (i % 4) / 4.0 : turns[i]);
        x[i] = static_cast<float>(radius * std::cos(t));
        y[i] = static_cast<float>(radius * std::sin(t));
      }
      probe_turns_for(GetParam())(y.data(), x.data(), found.data(), kMany);
      for (std::size_t i = 0; i < kMany; ++i) {
        double exact =
            std::atan2(static_cast<double>(y[i]), static_cast<double>(x[i])) / (2 * M_PI);
        exact -= std::floor(exact);
        EXPECT_LE(std::abs(std::remainder(found[i] - exact, 1.0)), 5e-8) << x[i] << ' ' << y[i];
        EXPECT_GE(found[i], 0);
        EXPECT_LT(found[i], 1);
      }
    }
}

TEST_P(Lanes, ReciprocalsKeepTheirStatedErrors) {
  for (const auto& x : {spread(0.5, 2), spread(1e-30, 1e-28), spread(1e25, 1e29)}) {
    std::vector<float> inverse(kMany), root(kMany), cube_root(kMany);
    probe_reciprocals_for(GetParam())(x.data(), inverse.data(), root.data(), cube_root.data(),
                                      kMany);
    for (std::size_t i = 0; i < kMany; ++i) {
      const double v = x[i];
      EXPECT_NEAR(inverse[i] * v, 1, 3e-7);
      EXPECT_NEAR(root[i] * std::sqrt(v), 1, 3e-7);
      EXPECT_NEAR(cube_root[i] / std::cbrt(v), 1, 4e-7);
    }
  }
}

TEST_P(Lanes, TheScaledErrorFunctionKeepsItsStatedError) {
  for (const auto& x : {spread(0, 1), spread(1, 10), spread(10, 1000)}) {
    std::vector<float> value(kMany);
    probe_scaled_erfc_for(GetParam())(x.data(), value.data(), kMany);
    for (std::size_t i = 0; i < kMany; ++i) {
      const double v = x[i];
      EXPECT_NEAR(value[i] / scaled_erfc(v), 1, 8e-7) << v;
      if (v < 5) {
        EXPECT_NEAR(scaled_erfc(v) * std::exp(-v * v) / std::erfc(v), 1, 1e-13) << v;
      }
    }
  }
  // Where the double's two forms meet.
  EXPECT_NEAR(scaled_erfc(20.0 - 1e-9) / scaled_erfc(20.0), 1, 1e-9);
}

TEST_P(Lanes, PhiloxGivesTheNumbersOfTheScalarStream) {
  constexpr std::size_t count = 256;
  constexpr std::uint64_t seed = 0x123456789abcdefULL;
  std::vector<std::uint32_t> c0(count), c2(count), words(4 * count);
  for (std::size_t i = 0; i < count; ++i) {
    c0[i] = static_cast<std::uint32_t>(i % 3);
    c2[i] = static_cast<std::uint32_t>(0x9e3779b9u * i);
  }
  probe_philox_for(GetParam())(seed, c0.data(), c2.data(),
                               static_cast<std::uint32_t>(StreamPurpose::test), words.data(),
                               count);
  for (std::size_t i = 0; i < count; ++i) {
    RandomStream stream(seed, c2[i], StreamPurpose::test);
    for (std::uint32_t skipped = 0; skipped < 4 * c0[i]; ++skipped) (void)stream.bits();
    for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(words[k * count + i], stream.bits());
  }
}

TEST_P(Lanes, NumbersOfAWalkAreThoseOfTheScalarGenerator) {
  constexpr std::size_t count = 64, draws = 40;
  std::vector<std::uint32_t> state(4 * count), words(draws * count);
  RandomStream stream(5, 0, StreamPurpose::test);
  for (auto& word : state) word = stream.bits();
  probe_walk_numbers_for(GetParam())(state.data(), words.data(), count, draws);
  for (std::size_t i = 0; i < count; ++i) {
    WordBlock<std::uint32_t> block;
    for (std::size_t k = 0; k < 4; ++k) block.w[k] = state[k * count + i];
    WalkNumbers<std::uint32_t> numbers(block);
    for (std::size_t k = 0; k < draws; ++k) ASSERT_EQ(words[k * count + i], numbers.next());
  }
}

TEST_P(Lanes, WhatIsDrawnFromWordsKeepsItsStatedErrors) {
  std::vector<std::uint32_t> words(kMany);
  RandomStream stream(6, 0, StreamPurpose::test);
  for (auto& word : words) word = stream.bits();
  // The ends: the shortest and the longest flights, both poles.
  for (std::uint32_t k = 0; k < 1024; ++k) {
    words[k] = k;
    words[1024 + k] = 0xFFFFFFFFu - k;
    words[2048 + k] = 0x7FFFFFFFu - k;
    words[3072 + k] = 0x80000000u + k;
    words[4096 + k] = 0xFFFFFFFFu - (k << 20);
  }
  std::vector<float> uniform(kMany), both(kMany), fine(kMany), flight(kMany), sine(kMany),
      cosine(kMany);
  probe_words_for(GetParam())(words.data(), uniform.data(), both.data(), fine.data(), flight.data(),
                              sine.data(), cosine.data(), kMany);
  for (std::size_t i = 0; i < kMany; ++i) {
    EXPECT_EQ(uniform[i], static_cast<float>(uniform_of(words[i])));
    EXPECT_EQ(both[i], static_cast<float>(signed_uniform_of(words[i])));
    EXPECT_NEAR(fine[i] / fine_uniform_of(words[i]), 1, 2e-7);
    // The logarithm's error, apart from that of the rounded number that it is taken of.
    const double exact = -std::log(static_cast<double>(fine[i]));
    EXPECT_NEAR(flight[i], exact, 1.2e-7 * std::max(1.0, exact)) << words[i];
    EXPECT_GE(flight[i], 0) << words[i];
    const auto [s, c] = azimuth_of(words[i]);
    EXPECT_NEAR(sine[i], s, 6e-7) << words[i];
    EXPECT_NEAR(cosine[i], c, 6e-7) << words[i];
  }
}

// Against the distribution's inverse in double, from thin ways to those that nothing crosses.
TEST_P(Lanes, TruncatedExponentialsEndWithinTheWay) {
  std::vector<float> tau(kMany), chance(kMany), length(kMany);
  std::vector<std::uint32_t> words(kMany);
  RandomStream stream(1, 2, StreamPurpose::walk);
  for (std::size_t i = 0; i < kMany; ++i) {
    tau[i] = i == 0 ? 0 : static_cast<float>(std::exp(std::log(80.0) * (3 * stream.uniform() - 2)));
    words[i] = i % 16 == 1   ? 0
               : i % 16 == 2 ? 0xFFFFFFFFu
                             : static_cast<std::uint32_t>(0x1p32 * stream.uniform());
  }
  probe_truncated_for(GetParam())(tau.data(), words.data(), chance.data(), length.data(), kMany);
  EXPECT_EQ(chance[0], 0);
  EXPECT_EQ(length[0], 0);
  for (std::size_t i = 1; i < kMany; ++i) {
    const double exact = -std::expm1(-static_cast<double>(tau[i]));
    EXPECT_NEAR(chance[i] / exact, 1, 6e-7) << tau[i];
    // A word stands for what it is rounded to, and the largest numbers for what rounding leaves.
    const double u = static_cast<double>(static_cast<float>(fine_uniform_of(words[i])));
    const double c = chance[i], x = c * (1 - u);
    const double to = x < 0.5 ? -std::log1p(-x) : -std::log(1 - c + c * u);
    EXPECT_NEAR(length[i], to, 3e-6 * to + 2e-7 * c) << tau[i] << ' ' << words[i];
    EXPECT_GE(length[i], 0);
  }
}

// At the ends of what they are for, and everywhere between.
TEST_P(Lanes, ComparisonsAreThoseOfTheScalarNumbers) {
  std::vector<std::uint32_t> a(kMany), b(kMany), conditions(kMany), xors(kMany);
  std::vector<float> x(kMany), limit(kMany);
  const std::uint32_t words[] = {0, 1, 2, 1000, 0x7FFFFFFE, 0x7FFFFFFF};
  const float numbers[] = {
      0.0f,  1e-45f, -1e-45f, 1e-30f,   -1e-30f,   1.0f,         std::nextafter(1.0f, 2.0f),
      -1.0f, 1e30f,  -1e30f,  INFINITY, -INFINITY, std::nanf("")};
  const float limits[] = {0.0f, 1e-45f, 1.0f, 1e30f, INFINITY};
  for (std::size_t i = 0; i < kMany; ++i) {
    a[i] = words[i % std::size(words)];
    b[i] = words[i / std::size(words) % std::size(words)];
    x[i] = numbers[i % std::size(numbers)];
    limit[i] = limits[i / std::size(numbers) % std::size(limits)];
    if (i % 3 == 0) {
      a[i] = static_cast<std::uint32_t>(i) * 2654435761u >> 1;
      b[i] = static_cast<std::uint32_t>(i) * 2246822519u >> 1;
    }
  }
  probe_conditions_for(GetParam())(a.data(), b.data(), x.data(), limit.data(), conditions.data(),
                                   xors.data(), kMany);
  for (std::size_t i = 0; i < kMany; ++i) {
    EXPECT_EQ(conditions[i] & 1, a[i] < b[i]) << a[i] << ' ' << b[i];
    EXPECT_EQ(conditions[i] >> 1, 0 <= x[i] && x[i] <= limit[i]) << x[i] << ' ' << limit[i];
    EXPECT_EQ(xors[i], a[i] ^ b[i] ^ 0x5A5A1234u);
  }
}

TEST_P(Lanes, HighestBitsAreFoundUpTo24) {
  std::vector<std::uint32_t> a(kMany), places(kMany), words(kMany);
  for (std::size_t i = 0; i < kMany; ++i) {
    const std::uint32_t power = 1u << (i % 25);
    a[i] = i < 25   ? power
           : i < 50 ? std::max(power - 1, 1u)
                    : power | (static_cast<std::uint32_t>(i) & (power - 1));
  }
  probe_highest_bits_for(GetParam())(a.data(), places.data(), words.data(), kMany);
  for (std::size_t i = 0; i < kMany; ++i) {
    EXPECT_EQ(places[i], static_cast<std::uint32_t>(std::bit_width(a[i])) - 1) << a[i];
    EXPECT_EQ(words[i], std::bit_floor(a[i])) << a[i];
    EXPECT_EQ(places[i], highest_bit(a[i]));
    EXPECT_EQ(words[i], word_with_bit(highest_bit(a[i])));
  }
}

TEST_P(Lanes, ChosenLanesAreCompressedAndRankedInOrder) {
  constexpr std::size_t groups = 1 << 12;
  std::vector<std::uint32_t> masks(groups), ranks(groups * 16), bits(groups);
  std::vector<float> x(groups * 16), compressed(groups * 16), permuted(groups * 16);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<float>(i);
  for (std::size_t g = 0; g < groups; ++g) masks[g] = static_cast<std::uint32_t>(g * 0x9e3779b1u);
  const auto lanes = static_cast<std::size_t>(
      probe_masks_for(GetParam())(x.data(), masks.data(), compressed.data(), ranks.data(),
                                  permuted.data(), bits.data(), groups));
  for (std::size_t g = 0; g < groups; ++g) {
    EXPECT_EQ(bits[g], masks[g] & ((1u << lanes) - 1));
    std::uint32_t rank = 0;
    for (std::size_t k = 0; k < lanes; ++k) {
      EXPECT_LT(ranks[g * lanes + k], lanes);
      if (!((masks[g] >> k) & 1)) continue;
      EXPECT_EQ(ranks[g * lanes + k], rank);
      EXPECT_EQ(compressed[g * lanes + rank], x[g * lanes + k]);
      EXPECT_EQ(permuted[g * lanes + k], x[g * lanes + rank]);
      ++rank;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, Lanes, ::testing::ValuesIn(lane_isas()),
                         [](const auto& isa) { return to_text(isa.param); });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Lanes);

TEST(IsaNames, AreReadAndAWrongOneSaysWhatIsAllowed) {
  EXPECT_EQ(isa_from_text("scalar"), Isa::scalar);
  for (const Isa isa : supported_isas()) EXPECT_EQ(isa_from_text(to_text(isa)), isa);
  EXPECT_THROW((void)isa_from_text("avx"), std::invalid_argument);
  ::setenv("LAMELLA_ISA", "scalar", 1);
  EXPECT_EQ(isa_from_text("auto"), Isa::scalar);
  EXPECT_EQ(isa_from_text(to_text(supported_isas().back())), supported_isas().back());
  ::setenv("LAMELLA_ISA", "mmx", 1);
  EXPECT_THROW((void)isa_from_text("auto"), std::invalid_argument);
  ::unsetenv("LAMELLA_ISA");
  EXPECT_EQ(isa_from_text("auto"), supported_isas().back());
}

}  // namespace
}  // namespace lamella
