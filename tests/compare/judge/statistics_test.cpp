#include "compare/judge/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <functional>

#include "phase/math/vec3.h"
#include "phase/random/random.h"
#include "tests/statistics/statistics.h"

namespace lamella {
namespace {

constexpr int kReplications = 4000;

double normal(RandomStream& stream) {
  const double radius = std::sqrt(2 * stream.exponential());
  return radius * std::cos(2 * kPi * stream.uniform());
}

// Batches of unequal size. Every quantity is the mean 1 per walk plus noise, of which the share
// `common` is the same for all quantities.
BatchSums correlated_sums(int batches, int quantities, double common, std::uint64_t replication) {
  RandomStream stream(11, replication, StreamPurpose::test);
  BatchSums out;
  for (int b = 0; b < batches; ++b) {
    const double walks = 100 + b % 2;
    const double shared = std::sqrt(common * walks) * normal(stream);
    out.walks.push_back(walks);
    std::vector<double> row(quantities);
    for (double& x : row) x = walks + shared + std::sqrt((1 - common) * walks) * normal(stream);
    out.sums.push_back(std::move(row));
  }
  return out;
}

// The uncertainty of values that are known exactly.
std::vector<double> exact(int quantities) { return std::vector<double>(quantities); }

// p-values of all replications.
std::vector<double> p_values(const std::function<double(std::uint64_t)>& p_value) {
  std::vector<double> all;
  for (std::uint64_t r = 0; r < kReplications; ++r) all.push_back(p_value(r));
  return all;
}

double uniformity(const std::vector<double>& p) {
  constexpr int kBins = 20;
  std::vector<double> observed(kBins), expected(kBins, p.size() / double{kBins});
  for (const double x : p) observed[std::min(kBins - 1, static_cast<int>(x * kBins))] += 1;
  return testing::chi_square_p_value(observed, expected);
}

int below(const std::vector<double>& p, double level) {
  return static_cast<int>(std::count_if(p.begin(), p.end(), [&](double x) { return x < level; }));
}

// How often a true hypothesis may be refused at that level without the test being suspect.
double most_refusals(std::size_t trials, double level) {
  const boost::math::binomial binomial(static_cast<double>(trials), level);
  return boost::math::quantile(complement(binomial, testing::test_level()));
}

TEST(Means, AreSumsOverWalksWithTheScatterOfBatches) {
  const BatchSums sums{{1, 1, 2}, {{1, 5}, {3, 5}, {4, 10}}};
  const Means means = means_of(sums);
  EXPECT_DOUBLE_EQ(means.value[0], 2);
  EXPECT_DOUBLE_EQ(means.value[1], 5);
  // Excesses over the mean: -1, 1, 0; their squares times 3 / 2, over 4 walks.
  EXPECT_DOUBLE_EQ(means.standard_error[0], std::sqrt(2 * 1.5) / 4);
  EXPECT_EQ(means.standard_error[1], 0);
}

TEST(Means, AreStudentsTInUnitsOfTheirStandardError) {
  double sum = 0;
  constexpr int kBatchCount = 16;
  for (std::uint64_t r = 0; r < kReplications; ++r) {
    const Means means = means_of(correlated_sums(kBatchCount, 1, 0, r));
    const double t = (means.value[0] - 1) / means.standard_error[0];
    sum += t * t / kReplications;
  }
  // t^2 with n degrees of freedom has mean n / (n - 2) and variance below 3 for n = 15.
  EXPECT_NEAR(sum, 15.0 / 13, 5 * std::sqrt(3.0 / kReplications));
}

TEST(Grouping, AddsQuantitiesAndLeavesSomeOut) {
  const BatchSums sums{{1, 1}, {{1, 2, 4, 8}, {16, 32, 64, 128}}};
  const BatchSums two = grouped(sums, {1, -1, 0, 1}, 2);
  EXPECT_EQ(two.sums[0], (std::vector<double>{4, 9}));
  EXPECT_EQ(two.sums[1], (std::vector<double>{64, 144}));
}

TEST(Pooling, MakesNeighboursInOrderThatEachHaveEnoughEvents) {
  // Counts with a mean of 0.02 to 2 per walk and quantity.
  BatchSums sums;
  RandomStream stream(5, 0, StreamPurpose::test);
  constexpr int kQuantities = 60;
  for (int b = 0; b < 64; ++b) {
    sums.walks.push_back(10);
    std::vector<double> row(kQuantities);
    for (int k = 0; k < kQuantities; ++k)
      for (int walk = 0; walk < 10; ++walk) row[k] += stream.uniform() < 0.001 * (k + 1);
    sums.sums.push_back(std::move(row));
  }
  const std::vector<int> group = pooled_groups(sums, 50);
  const int groups = 1 + *std::max_element(group.begin(), group.end());
  EXPECT_GT(groups, 5);
  EXPECT_LT(groups, kQuantities);
  EXPECT_EQ(group.front(), 0);
  for (int k = 1; k < kQuantities; ++k) {
    EXPECT_GE(group[k], group[k - 1]);
    EXPECT_LE(group[k], group[k - 1] + 1);
  }
  const Means means = means_of(grouped(sums, group, groups));
  // The last group also holds what was left, which may have added scatter only.
  for (int g = 0; g + 1 < groups; ++g) {
    const double ratio = means.value[g] / means.standard_error[g];
    EXPECT_GE(ratio * ratio, 49) << g;
  }
}

TEST(Pooling, LeavesOutEverythingWhereTooLittleWasSeen) {
  const BatchSums nothing{{10, 10}, {{0, 0}, {0, 0}}};
  EXPECT_EQ(pooled_groups(nothing, 100), (std::vector<int>{-1, -1}));
  const BatchSums one{{10, 10}, {{0, 1}, {0, 0}}};
  EXPECT_EQ(pooled_groups(one, 100), (std::vector<int>{-1, -1}));
}

TEST(Hotelling, IsUniformForATrueModelWhateverTheCorrelation) {
  for (const double common : {0.0, 0.5, 0.99}) {
    const auto p = p_values([&](std::uint64_t r) {
      return hotelling_p_value(correlated_sums(128, 16, common, r), std::vector<double>(16, 1.0),
                               exact(16));
    });
    EXPECT_GT(uniformity(p), testing::test_level()) << common;
  }
}

TEST(Hotelling, IsUniformWhereQuantitiesAreCopiesOfEachOther) {
  const auto p = p_values([](std::uint64_t r) {
    BatchSums sums = correlated_sums(64, 6, 0.3, r);
    for (auto& row : sums.sums) {
      row.push_back(row[0]);
      row.push_back(row[1] + row[2]);
    }
    return hotelling_p_value(sums, {1, 1, 1, 1, 1, 1, 1, 2}, exact(8));
  });
  EXPECT_GT(uniformity(p), testing::test_level());
}

TEST(Hotelling, FindsADifferenceOfTwoStandardErrorsInEveryQuantity) {
  // Independent quantities: noncentrality 16 * 4; at level 0.01 that is missed in 1 of 1e4.
  const double error = 1 / std::sqrt(128 * 100.5);
  const auto p = p_values([&](std::uint64_t r) {
    return hotelling_p_value(correlated_sums(128, 16, 0, r), std::vector<double>(16, 1 + 2 * error),
                             exact(16));
  });
  EXPECT_GT(below(p, 0.01), 0.99 * kReplications);
}

TEST(Hotelling, SeesThroughCommonNoise) {
  // With 99 % of the noise common, a contrast of a fifth of a standard error between halves shows:
  // its own noise is a tenth.
  const double error = 1 / std::sqrt(128 * 100.5);
  std::vector<double> expected(16, 1.0);
  for (int k = 0; k < 16; ++k) expected[k] += (k < 8 ? 0.2 : -0.2) * error;
  const auto p = p_values([&](std::uint64_t r) {
    return hotelling_p_value(correlated_sums(128, 16, 0.99, r), expected, exact(16));
  });
  EXPECT_GT(below(p, 0.01), 0.99 * kReplications);
}

TEST(Hotelling, SaysNothingWhereNothingVaries) {
  const BatchSums sums{{1, 1, 1}, {{1, 2}, {1, 2}, {1, 2}}};
  EXPECT_EQ(hotelling_p_value(sums, {1, 2}, exact(2)), 1);
  EXPECT_EQ(hotelling_p_value({{1, 1}, {{}, {}}}, {}, {}), 1);
}

TEST(Hotelling, HoldsNothingAgainstAModelWithinItsUncertainty) {
  // Contrasts between copies of each other have a thousandth of the noise.
  const double error = 1 / std::sqrt(128 * 100.5);
  std::vector<double> expected(16, 1.0);
  for (int k = 0; k < 16; ++k) expected[k] += (k % 2 ? 0.1 : -0.1) * error;
  const std::vector<double> uncertainty(16, 0.1 * error);
  const auto test = [&](const std::vector<double>& known_to) {
    return p_values([&](std::uint64_t r) {
      return hotelling_p_value(correlated_sums(128, 16, 1 - 1e-6, r), expected, known_to);
    });
  };
  EXPECT_EQ(below(test(exact(16)), 0.01), kReplications);
  EXPECT_LE(below(test(uncertainty), 0.05), most_refusals(kReplications, 0.05));
}

TEST(LargestDeviation, RefusesATrueModelNoMoreOftenThanItSays) {
  for (const double common : {0.0, 0.5, 0.99}) {
    const auto p = p_values([&](std::uint64_t r) {
      return largest_deviation_p_value(means_of(correlated_sums(128, 32, common, r)),
                                       std::vector<double>(32, 1.0), exact(32), 128);
    });
    for (const double level : {0.2, 0.05, 0.01, 0.001})
      EXPECT_LE(below(p, level), most_refusals(p.size(), level)) << common << ' ' << level;
    // Bonferroni's bound is nearly reached where the quantities are independent.
    if (common == 0) {
      EXPECT_GT(below(p, 0.05), 0.8 * 0.05 * kReplications);
    }
  }
}

TEST(LargestDeviation, FindsOneQuantityAmongMany) {
  const double error = 1 / std::sqrt(128 * 100.5);
  std::vector<double> expected(32, 1.0);
  expected[13] += 7 * error;
  const auto p = p_values([&](std::uint64_t r) {
    return largest_deviation_p_value(means_of(correlated_sums(128, 32, 0.5, r)), expected,
                                     exact(32), 128);
  });
  EXPECT_GT(below(p, 0.01), 0.99 * kReplications);
}

TEST(LargestDeviation, TakesAQuantityWithoutScatterAsExact) {
  const Means means{{0.25, 0}, {0, 0}};
  EXPECT_EQ(largest_deviation_p_value(means, {0.25, 0}, exact(2), 128), 1);
  EXPECT_EQ(largest_deviation_p_value(means, {0.25 * (1 + 1e-15), 0}, exact(2), 128), 1);
  EXPECT_EQ(largest_deviation_p_value(means, {0.26, 0}, exact(2), 128), 0);
  EXPECT_EQ(largest_deviation_p_value(means, {0.25, 1e-9}, exact(2), 128), 0);
}

}  // namespace
}  // namespace lamella
