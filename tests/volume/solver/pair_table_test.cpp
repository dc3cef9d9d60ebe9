#include "volume/solver/pair_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "phase/random/random.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

constexpr double kTolerance = 1e-6;

DeterministicSolution solution_of(const std::string& layer) {
  return solve_deterministic(parse_stack("[[layer]]\n" + layer, "test", "test"),
                             {.tolerance = kTolerance});
}

// Scattered pairs, as many from below as from above where the stack is open there.
std::vector<CosinePair> scattered(std::size_t count, bool open_below) {
  RandomStream random(7, 0, StreamPurpose::walk);
  std::vector<CosinePair> pairs;
  const auto cosine = [&] {
    const double mu = random.uniform();
    return open_below && random.uniform() < 0.5 ? -mu : mu;
  };
  for (std::size_t k = 0; k < count; ++k) pairs.push_back({cosine(), cosine()});
  return pairs;
}

// Every 500th pair against the field of its own cosines: within both bounds.
void expect_agreement(const std::string& layer, bool open_below) {
  const DeterministicSolution solution = solution_of(layer);
  const std::vector<CosinePair> pairs = scattered(20000, open_below);
  const auto table = PairTable::make(solution, pairs);
  ASSERT_TRUE(table) << layer;
  // What a bound may be: the solution's tolerance, or three times its error.
  const double error = solution.accuracy().error, tolerance = solution.tolerance();
  EXPECT_LE(table->deviation(), std::max(error, tolerance - error));
  int found = 0, asked = 0;
  for (std::size_t k = 0; k < pairs.size(); k += 500) {
    const double x = 0.1 * static_cast<double>(k % 31);
    const auto value = table->at(pairs[k], x);
    ++asked;
    if (!value) continue;
    ++found;
    const double mu_i[] = {pairs[k].mu_i}, mu_o[] = {pairs[k].mu_o};
    const DeterministicField field = solution.field(mu_i, mu_o);
    const DeterministicValue exact = field.multiple(0, 0, x);
    for (int channel = 0; channel < 3; ++channel) {
      const double scale = field.scale(channel, 0, 0);
      EXPECT_LE(std::abs(value->order[Order::all][channel] - exact.order[Order::all][channel]),
                table->deviation() * scale)
          << layer << pairs[k].mu_i << " " << pairs[k].mu_o;
      // The bound is the solution's, of the cosines around, and the table's.
      EXPECT_GE(value->error[channel], table->deviation() * scale);
      EXPECT_LE(value->error[channel], std::max(4 * error, tolerance) * scale);
    }
  }
  EXPECT_EQ(found, asked) << layer;
}

TEST(PairTable, HasTheFieldsOwnValuesAtScatteredPairs) {
  expect_agreement("medium = \"lambert_sphere\"\nalbedo = 0.9\nthickness = inf\n", false);
  expect_agreement("medium = \"lambert_sphere\"\nalbedo = [0.9, 0.5, 0.5]\nthickness = 2\n", true);
  expect_agreement("medium = \"henyey_greenstein\"\ng = 0.5\nalbedo = 0.9\nthickness = 1\n", true);
}

TEST(PairTable, TakesFewIncidentCosinesAsTheyAre) {
  const DeterministicSolution solution =
      solution_of("medium = \"lambert_sphere\"\nalbedo = 0.9\nthickness = inf\n");
  std::vector<CosinePair> pairs = scattered(20000, false);
  for (std::size_t k = 0; k < pairs.size(); ++k) pairs[k].mu_i = k % 2 == 0 ? 0.3 : 1;
  const auto table = PairTable::make(solution, pairs);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->incident(), 2);
  const double mu_i[] = {0.3}, mu_o[] = {pairs[0].mu_o};
  const double exact = solution.field(mu_i, mu_o).multiple(0, 0, 1).order[Order::all][0];
  EXPECT_NEAR(table->at(pairs[0], 1)->order[Order::all][0], exact, table->deviation() * exact);
}

TEST(PairTable, LeavesFewPairsAndSteepMediaToThemselves) {
  EXPECT_FALSE(
      PairTable::make(solution_of("medium = \"lambert_sphere\"\nalbedo = 0.9\nthickness = inf\n"),
                      scattered(100, false)));
  const DeterministicSolution mirrors =
      solve_deterministic(parse_stack("[[layer]]\nmedium = \"sggx\"\nroughness = 0.5\nalbedo = "
                                      "0.9\nthickness = 2\n",
                                      "test", "test"),
                          {.tolerance = 1e-2});
  EXPECT_FALSE(PairTable::make(mirrors, scattered(20000, false)));
}

TEST(PairTable, LeavesPairsOfWhichBothGraze) {
  const DeterministicSolution solution =
      solution_of("medium = \"lambert_sphere\"\nalbedo = 0.9\nthickness = inf\n");
  const auto table = PairTable::make(solution, scattered(20000, false));
  ASSERT_TRUE(table);
  EXPECT_FALSE(table->at({1e-6, 1e-6}, 1));
  EXPECT_TRUE(table->at({1e-6, 0.5}, 1));
}

}  // namespace
}  // namespace lamella
