// Next-event estimation through interfaces on lanes, on every instruction set of the machine,
// against the scalar double walk.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <map>
#include <memory>

#include "tests/volume/lanes/boundary_cases.h"
#include "tests/volume/lanes/lane_agreement.h"
#include "volume/lanes/lane_run.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::boundary_cases;
using testing::BoundaryCase;
using testing::expect_same_lobes;
using testing::interface;
using testing::lane_isas;
using testing::layer;
using testing::stack_from;
using testing::z_between;

constexpr std::uint64_t kCellWalks = 20000, kPointWalks = 30000;

// Twenty points, more than a block of targets holds.
std::vector<Direction> points_of(const Stack& stack) {
  std::vector<Direction> points;
  for (int k = 0; k < 12; ++k) points.push_back(direction_from_degrees(7.0 * k + 3, 37.0 * k));
  if (stack.is_open_below())
    for (int k = 0; k < 8; ++k) points.push_back(direction_from_degrees(177 - 10.0 * k, 61.0 * k));
  return points;
}

std::unique_ptr<Simulation> aimed(const BoundaryCase& c, Isa isa, bool cells, std::uint64_t walks,
                                  std::uint64_t seed, Thinning thinning = {}) {
  const Stack stack = stack_from(c.toml);
  Plan plan = make_plan(stack, {.max_order = 1000, .thinning = thinning});
  plan.isa = isa;
  const Direction wi = direction_from_degrees(c.theta, c.phi);
  auto simulation = cells ? std::make_unique<Simulation>(stack, plan, wi, Estimator::next_event,
                                                         CellGrid{3, 4, false}, seed)
                          : std::make_unique<Simulation>(stack, plan, wi, points_of(stack), seed);
  simulation->advance(testing::soaked(walks));
  return simulation;
}

// [slot][channel][point]
std::vector<Estimate> values_of(const Simulation& run) {
  std::vector<Estimate> values;
  for (std::size_t j = 0; j < run.batches()[0].f.size(); ++j)
    values.push_back(batch_estimate(run.batches(), [&](const BatchTally& b) { return b.f[j]; }));
  return values;
}

class LaneWays : public ::testing::TestWithParam<Isa> {};

TEST_P(LaneWays, CellsAgreeWithTheScalarWalk) {
  static std::map<std::size_t, RunResult> scalar;
  for (std::size_t k = 0; k < boundary_cases().size(); ++k) {
    const BoundaryCase& c = boundary_cases()[k];
    const auto lanes = aimed(c, GetParam(), true, kCellWalks, 1);
    ASSERT_EQ(lanes->isa(), GetParam()) << c.what;
    if (!scalar.contains(k)) scalar[k] = reduce(*aimed(c, Isa::scalar, true, kCellWalks, 2));
    // Terms are rounded to 2^-32.
    expect_same_lobes(reduce(*lanes), scalar[k], c.what, 0x1p-32);
  }
}

TEST_P(LaneWays, PointsAgreeWithTheScalarWalk) {
  static std::map<std::size_t, std::vector<Estimate>> scalar;
  for (std::size_t k = 0; k < boundary_cases().size(); ++k) {
    const BoundaryCase& c = boundary_cases()[k];
    const auto lanes = aimed(c, GetParam(), false, kPointWalks, 3);
    ASSERT_EQ(lanes->isa(), GetParam()) << c.what;
    if (!scalar.contains(k)) scalar[k] = values_of(*aimed(c, Isa::scalar, false, kPointWalks, 4));
    const std::vector<Estimate> a = values_of(*lanes), &b = scalar[k];
    ASSERT_EQ(a.size(), b.size());
    int compared = 0;
    for (std::size_t j = 0; j < a.size(); ++j) {
      if (a[j].value < 6 * a[j].standard_error || b[j].value < 6 * b[j].standard_error) continue;
      // Where no chance is left order 0 has no noise, but that of sums in whole numbers.
      const double rounding = 1e-6 * b[j].value + 0x1p-40;
      if (std::abs(a[j].value - b[j].value) < rounding) continue;
      EXPECT_LT(std::abs(z_between(a[j], b[j])), allowed_z())
          << c.what << ' ' << j << ' ' << a[j].value << ' ' << b[j].value;
      ++compared;
    }
    EXPECT_GT(compared, 0) << c.what;
  }
}

TEST_P(LaneWays, ThinnedWalksHaveTheSameMeans) {
  for (const std::size_t k : {0, 1, 8, 11, 19}) {
    const BoundaryCase& c = boundary_cases()[k];
    const auto thinned = values_of(*aimed(c, GetParam(), false, kPointWalks, 5, Thinning{2}));
    const auto all = values_of(*aimed(c, GetParam(), false, kPointWalks, 6));
    for (std::size_t j = 0; j < all.size(); ++j) {
      const double error = all[j].standard_error;
      if (all[j].value < 6 * error || error < 1e-6 * all[j].value) continue;
      EXPECT_LT(std::abs(z_between(thinned[j], all[j])), allowed_z()) << c.what << ' ' << j;
    }
  }
}

// Order 0 of a rough coat is its f, and of light that crosses a smooth interface first what is left
// of that.
TEST_P(LaneWays, OrderZeroAtPointsIsExact) {
  const BoundaryCase& c = boundary_cases()[2];
  const auto run = aimed(c, GetParam(), false, 1000, 3);
  const Stack stack = stack_from(c.toml);
  const std::vector<Direction> points = points_of(stack);
  const Dielectric coat{.facets = {FacetShape::ggx, 0.2, 0.2}, .below = 1.5};
  for (std::size_t j = 0; j < points.size(); ++j) {
    const double f = coat.single(run->incident(), points[j]);
    const Estimate e = batch_estimate(
        run->batches(), [&](const BatchTally& b) { return b.f[kZeroSlot * points.size() + j]; });
    // 2^-41 is half a unit of its sum in whole numbers.
    EXPECT_NEAR(e.value, f, 1e-12 * f + 0x1p-41);
    EXPECT_LE(e.standard_error, 1e-12 * f);
  }
}

TEST_P(LaneWays, IsBitIdenticalForAnyThreadsAndCheckpoints) {
  for (const bool cells : {true, false})
    for (const std::size_t k : {0, 4, 7, 8, 101, 107}) {  // beyond 100: thinned
      const auto sums = [&](int threads, const std::vector<std::uint64_t>& checkpoints) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        tbb::task_arena arena(threads);
        return arena.execute([&] {
          const auto simulation = aimed(boundary_cases()[k % 100], GetParam(), cells, 0, 7,
                                        k > 100 ? Thinning{2} : Thinning{});
          for (const std::uint64_t walks : checkpoints) simulation->advance(walks);
          std::vector<double> all;
          for (const BatchTally& b : simulation->batches()) {
            all.insert(all.end(), b.f.begin(), b.f.end());
            for (const auto& order : b.energy.up) all.insert(all.end(), order.begin(), order.end());
          }
          all.push_back(static_cast<double>(simulation->collisions()));
          return all;
        });
      };
      const auto one = sums(1, {20000});
      EXPECT_EQ(one, sums(2, {20000}));
      EXPECT_EQ(one, sums(7, {1, 130, 8191, 8192, 19999, 20000}));
    }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, LaneWays, ::testing::ValuesIn(lane_isas()),
                         [](const auto& isa) { return to_text(isa.param); });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LaneWays);

TEST(LaneWayLimits, PointsThatGrazeInALayerStayScalar) {
  if (lane_isas().empty()) return;
  // Light that leaves at 60 degrees crosses a layer of the index sin 60 degrees parallel to it.
  const Stack stack =
      stack_from(interface("'smooth'\nior = 0.8660254037844386") +
                 layer("medium = 'lambert_sphere'\nthickness = 1") + "[substrate]\nalbedo = 0.5\n");
  Plan plan = make_plan(stack);
  plan.isa = lane_isas().back();
  EXPECT_TRUE(why_not_lanes_at(stack, plan, {direction_from_degrees(60, 0)}));
  EXPECT_FALSE(why_not_lanes_at(stack, plan, {direction_from_degrees(59, 0)}));
}

}  // namespace
}  // namespace lamella
