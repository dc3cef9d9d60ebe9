// Whatever the stack: the solver's answer is finite and physical, or it says that it has none.

#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <cmath>
#include <utility>
#include <vector>

#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/plan/plan.h"
#include "volume/quadrature/quadrature.h"
#include "volume/solver/answer_check.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

std::vector<RunResult> runs_of(const DeterministicSolution& solution, double tolerance) {
  const std::vector<Direction> incident{direction_from_degrees(0, 0), direction_from_degrees(45, 0),
                                        direction_from_degrees(89.9, 0)};
  return deterministic_runs(solution, make_plan(solution.stack()), incident, CellGrid{3, 4},
                            tolerance);
}

// vMF flakes, mean normal up or down.
std::string vmf_facing(double roughness, const std::string& flake, int up) {
  return vmf(roughness, flake) + "\naxis = [0, 0, " + std::to_string(up) + "]";
}

// Both ends and the middle of every parameter of every medium that the solver takes.
std::vector<std::string> all_media() {
  std::vector<std::string> media{kSphere};
  for (const double g : {-0.99999999, -0.999, -0.5, 0.0, 0.5, 0.999, 0.99999999})
    media.push_back(fmt::format("{}\ng = {:.10g}", kIsotropic, g));
  for (const char* flake : {"mirror", "lambert"}) {
    for (const double roughness : {1e-3, 0.01, 0.5, 1.0}) {
      media.push_back(sggx(roughness, flake));
      media.push_back(fiber(roughness, flake));
    }
    for (const double roughness : {1e-4, 0.01, 0.5, 1.0})
      for (const int up : {1, -1}) media.push_back(vmf_facing(roughness, flake, up));
  }
  return media;
}

// What any stack does to light, and what albedos of 0 and 1 do besides.
void expect_physical(const RunResult& run, double albedo, double uncollided) {
  const auto within = [](const Estimate& e) {
    EXPECT_TRUE(std::isfinite(e.value) && std::isfinite(e.standard_error));
    EXPECT_GE(e.value, -e.standard_error - 1e-12);
    EXPECT_LE(e.value, 1 + e.standard_error + 1e-12);
  };
  for (const SideResult* side : {&run.reflected, &run.transmitted}) {
    within(side->total[0]);
    for (const auto& order : side->orders) within(order[0]);
    for (const LobeEstimate& lobe : side->lobes)
      for (std::size_t k = 0; k < lobe.value.size(); ++k)
        EXPECT_TRUE(std::isfinite(lobe.value[k]) && std::isfinite(lobe.standard_error[k]));
  }
  within(run.uncollided[0]);
  within(run.absorbed[0]);
  const double reflected = run.reflected.total[0].value, sent = run.transmitted.total[0].value;
  const double bound = run.reflected.total[0].standard_error +
                       run.transmitted.total[0].standard_error + run.absorbed[0].standard_error +
                       1e-12;
  EXPECT_NEAR(reflected + sent + run.uncollided[0].value + run.absorbed[0].value, 1, bound);
  EXPECT_NEAR(run.uncollided[0].value, uncollided, 1e-12 + run.accuracy->error * uncollided);
  if (albedo == 0) {
    EXPECT_NEAR(reflected, 0, 1e-12);
    EXPECT_NEAR(sent, 0, 1e-12);
  } else {
    EXPECT_NEAR(run.absorbed[0].value, 0, bound);
  }
}

// Solves every medium at both ends of albedo and depth; returns how many had an answer, of how
// many.
std::pair<int, int> scan(const DeterministicOptions& options, const std::vector<double>& depths) {
  int answers = 0, all = 0;
  for (const std::string& medium : all_media())
    for (const double albedo : {0.0, 1.0})
      for (const double depth : depths) {
        const Stack stack = stack_of(layer(medium, albedo, depth));
        if (why_not_deterministic(stack)) continue;
        SCOPED_TRACE(layer(medium, albedo, depth));
        ++all;
        const DeterministicSolution solution = solve_deterministic(stack, options);
        const DeterministicAccuracy& accuracy = solution.accuracy();
        EXPECT_FALSE(std::isnan(accuracy.error));
        EXPECT_GE(accuracy.error, accuracy.energy_defect);
        if (why_no_answer(accuracy)) {
          EXPECT_FALSE(accuracy.reached);
          continue;
        }
        bool every = true;
        for (const RunResult& run : runs_of(solution, 2 * options.tolerance)) {
          every = every && !why_no_answer(run);
          if (!why_no_answer(run)) expect_physical(run, albedo, stack.uncollided(run.incident));
        }
        answers += every;
      }
  return {answers, all};
}

TEST(SolverAnswer, IsFiniteAndPhysicalOrThereIsNone) {
  const DeterministicOptions options{
      .tolerance = 1e-3, .max_nodes = 12, .max_modes = 12, .max_seconds = 5};
  const auto [answers, all] = scan(options, {1e-9, 1, kInfinity});
  // With so few nodes the narrowest media have none.
  EXPECT_GE(answers, all * 3 / 4);
  EXPECT_GE(all, 150);
}

TEST(SolverAnswerSoak, IsFiniteAndPhysicalOrThereIsNone) {
  if (!is_soak()) GTEST_SKIP() << "LAMELLA_SOAK is not set";
  const DeterministicOptions options{
      .tolerance = 5e-5, .max_nodes = 64, .max_modes = 64, .max_seconds = 20};
  const auto [answers, all] = scan(options, {1e-9, 1, 1e3, 1e9, kInfinity});
  EXPECT_GE(answers, all * 3 / 4);
}

TEST(SolverAnswer, IsRefusedWherePeaksAreBeyondTheNodes) {
  for (const double g : {0.999, 0.9999, 0.99999999}) {
    const Stack stack =
        stack_of(layer(fmt::format("{}\ng = {:.10g}", kIsotropic, g), 1, kInfinity));
    const DeterministicSolution s =
        solve_deterministic(stack, {.tolerance = 5e-5, .max_nodes = 16, .max_modes = 16});
    EXPECT_FALSE(s.accuracy().reached) << g;
    EXPECT_TRUE(why_no_answer(s.accuracy())) << g << ' ' << s.accuracy().error;
    EXPECT_EQ(s.accuracy().limit, DeterministicLimit::numbers) << g;
  }
}

TEST(SolverAnswer, OfRunsHoldsBoundsAgainstWhatLightDoes) {
  const Stack stack = stack_of(layer(kIsotropic, 0.5, 1));
  const DeterministicSolution s = solve_deterministic(stack, {.tolerance = 1e-4});
  const RunResult good = runs_of(s, 2e-4)[1];
  EXPECT_FALSE(why_no_answer(good));
  const double nan = std::nan("");
  RunResult bad = good;
  bad.reflected.total[0].value = nan;
  EXPECT_TRUE(why_no_answer(bad));
  bad = good;
  bad.absorbed[0].standard_error = nan;
  EXPECT_TRUE(why_no_answer(bad));
  bad = good;
  bad.transmitted.lobes[2].value[3] = nan;
  EXPECT_TRUE(why_no_answer(bad));
  bad = good;
  bad.reflected.total[0] = {-1e-3, 1e-4};
  EXPECT_TRUE(why_no_answer(bad));
  bad = good;
  bad.reflected.total[0] = {1e16, 1e16};
  EXPECT_TRUE(why_no_answer(bad));
  bad = good;
  bad.uncollided[0].value += 0.01;
  EXPECT_TRUE(why_no_answer(bad));
}

TEST(SolverAnswer, OfDepthsBeyondAllNumbersIsThatOfDeepLayers) {
  for (const double albedo : {0.9, 1.0}) {
    const auto solved = [&](double depth) {
      const Stack stack = stack_of(layer(kIsotropic, albedo, depth));
      const DeterministicSolution s = solve_deterministic(stack, {.tolerance = 5e-7});
      EXPECT_TRUE(s.accuracy().reached) << depth;
      return runs_of(s, 1e-6)[1];
    };
    const RunResult deep = solved(1e6), half_space = solved(kInfinity);
    for (const double depth : {1e60, 1e298, 1.7e308}) {
      SCOPED_TRACE(depth);
      const RunResult run = solved(depth);
      EXPECT_NEAR(run.reflected.total[0].value, half_space.reflected.total[0].value, 1e-12);
      EXPECT_NEAR(run.absorbed[0].value, half_space.absorbed[0].value, 1e-12);
      // Without absorption transmission falls like 1 / (depth + constant).
      const double expected =
          albedo < 1 ? 0 : deep.transmitted.total[0].value * ((1e6 + 1.42) / depth);
      // Numbers below 1e-300 lose digits.
      EXPECT_NEAR(run.transmitted.total[0].value, expected, 1e-5 * expected + 1e-305);
    }
  }
}

TEST(SolverAnswer, HasTheSameBytesOnAnyNumberOfThreads) {
  const std::string stacks[] = {layer(sggx(0.5, "mirror"), 0.9, 2),
                                layer(fmt::format("{}\ng = 0.8", kIsotropic), 0.99, kInfinity),
                                layer(vmf(0.5, "lambert"), 0.7, 1) + lambert_ground(0.5)};
  for (const std::string& toml : stacks) {
    const Stack stack = stack_of(toml);
    const auto solved_on = [&](int threads) {
      oneapi::tbb::task_arena arena(threads);
      return arena.execute([&] {
        const DeterministicSolution s =
            solve_deterministic(stack, {.tolerance = 5e-5, .max_nodes = 32, .max_seconds = 1e9});
        std::vector<double> bytes{s.accuracy().error, s.accuracy().node_error,
                                  static_cast<double>(s.accuracy().modes)};
        for (const RunResult& run : runs_of(s, 1e-4))
          for (const SideResult* side : {&run.reflected, &run.transmitted}) {
            bytes.push_back(side->total[0].value);
            for (const LobeEstimate& lobe : side->lobes) {
              bytes.insert(bytes.end(), lobe.value.begin(), lobe.value.end());
              bytes.insert(bytes.end(), lobe.standard_error.begin(), lobe.standard_error.end());
            }
          }
        return bytes;
      });
    };
    const std::vector<double> one = solved_on(1);
    for (const int threads : {2, 7, 16}) EXPECT_EQ(solved_on(threads), one) << threads;
  }
}

TEST(SolverAnswer, HasNoNodesBeyondTheNormal) {
  for (const double mu : {1.0, 1 - 0x1p-53, 1 - 0x1p-52, 1 - 0x1p-51})
    for (const GrazingMap& map : {GrazingMap(), GrazingMap(0.15)}) {
      EXPECT_LE(map.parameter(mu), 1) << mu;
      EXPECT_LE(map.mu(map.parameter(mu)), 1) << mu;
    }
  // Fibers whose cells need points next to the normal.
  const Stack stack = stack_of(layer(fiber(1e-3, "mirror"), 1, 1e-9));
  const DeterministicSolution s =
      solve_deterministic(stack, {.tolerance = 1e-3, .max_nodes = 12, .max_modes = 24});
  for (const RunResult& run : runs_of(s, 1e-3)) EXPECT_FALSE(why_no_answer(run));
}

}  // namespace
}  // namespace lamella
