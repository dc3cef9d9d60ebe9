#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "phase/stack/stack_file.h"
#include "tests/statistics/statistics.h"
#include "volume/run/simulation.h"

namespace lamella::testing {

/// Walks of a test: twenty times as many in `make soak`.
[[nodiscard]] inline std::uint64_t soaked(std::uint64_t walks) {
  return std::getenv("LAMELLA_SOAK") ? 20 * walks : walks;
}

[[nodiscard]] inline Stack stack_from(const std::string& toml) {
  return parse_stack(toml, "test", "test");
}

[[nodiscard]] inline std::string layer(const std::string& keys) {
  return "[[layer]]\n" + keys + "\n";
}

/// The instruction sets with lanes that this machine has.
[[nodiscard]] inline std::vector<Isa> lane_isas() {
  std::vector<Isa> list = supported_isas();
  list.erase(list.begin());  // scalar
  return list;
}

/// Tests of walks that run on the scalar kernel and on each instruction set's lanes, by plans from
/// plan_of.
class OnEveryIsa : public ::testing::TestWithParam<Isa> {
 protected:
  static inline Isa isa_ = Isa::scalar;
  void SetUp() override { isa_ = GetParam(); }
  friend Plan plan_of(const Stack& stack, std::uint64_t max_order);
};
[[nodiscard]] inline Plan plan_of(const Stack& stack, std::uint64_t max_order = 1000) {
  Plan plan = make_plan(stack, {.max_order = max_order});
  plan.isa = OnEveryIsa::isa_;
  return plan;
}

/// One layer's keys for every medium, without albedo and thickness.
[[nodiscard]] inline std::vector<std::string> every_medium() {
  return {
      "medium = 'sggx'\nroughness = 0.3",
      "medium = 'sggx'\nshape = 'fiber'\nroughness = 0.3\naxis = [1, 0.4, 0.3]",
      "medium = 'sggx'\nmatrix = [0.5, 0.3, 0.8, 0.1, -0.2, 0.15]",
      "medium = 'sggx'\nroughness = 0.4\nf0 = 0.04",
      "medium = 'sggx'\nroughness = 0.4\nflake = 'lambert'",
      "medium = 'vmf_flake'\nroughness = 0.5",
      "medium = 'vmf_flake'\nroughness = 0.5\nflake = 'mirror'",
      "medium = 'vmf_flake'\nroughness = 0.3\naxis = [0.5, 0.2, 1]",
      "medium = 'lambert_sphere'",
      "medium = 'rayleigh'",
      "medium = 'henyey_greenstein'\ng = 0.6",
      "medium = 'henyey_greenstein'",
  };
}

/// Mean of f of one order (or of all, order = kTallyOrders) at one point of a simulation of points.
[[nodiscard]] inline Estimate point_estimate(const Simulation& simulation, int order, int point,
                                             int points, int channel = 0) {
  const int channels = simulation.plan().channels;
  return batch_estimate(simulation.batches(), [&](const BatchTally& b) {
    double sum = 0;
    for (int o = 0; o < kTallyOrders; ++o)
      if (order == kTallyOrders || o == order)
        sum += b.f[(static_cast<std::size_t>(o) * channels + channel) * points + point];
    return sum;
  });
}

/// The number of standard errors that one test may be off, two-sided.
[[nodiscard]] inline double allowed_z() { return normal_quantile(test_level()); }

/// z of the difference of two independent estimates; 0 where both are exact and equal.
[[nodiscard]] inline double z_between(Estimate a, Estimate b) {
  const double error = std::hypot(a.standard_error, b.standard_error);
  if (error == 0) return std::abs(a.value - b.value) < 1e-14 ? 0 : 1e9;
  return (a.value - b.value) / error;
}

}  // namespace lamella::testing
