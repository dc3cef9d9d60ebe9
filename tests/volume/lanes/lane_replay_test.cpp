// What float costs: the same walks, with the same random numbers and from the same source, on lanes
// of float and in double.
#include "volume/lanes/lane_replay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/volume/run/stacks.h"
#include "volume/lanes/lane_run.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::lane_isas;
using testing::layer;
using testing::stack_from;

// The bound that volume/README.md states.
constexpr double kLargestBias = 1e-5;

// Media at the ends of what lanes take, and stacks of them.
std::vector<std::string> replayed_stacks() {
  std::vector<std::string> list;
  for (const char* medium :
       {"medium = 'sggx'\nroughness = 0.02", "medium = 'sggx'\nroughness = 1",
        "medium = 'sggx'\nroughness = 0.03\nflake = 'lambert'",
        "medium = 'sggx'\nshape = 'fiber'\nroughness = 0.1\naxis = [1, 1, 1]",
        "medium = 'sggx'\nmatrix = [0.5, 0.3, 0.8, 0.1, -0.2, 0.15]\nf0 = 0.04",
        "medium = 'vmf_flake'\nroughness = 1", "medium = 'vmf_flake'\nalpha = 0.2",
        "medium = 'vmf_flake'\nalpha = 0.01", "medium = 'vmf_flake'\nalpha = 0.001",
        "medium = 'vmf_flake'\nroughness = 0.5\naxis = [1, 0.3, 0.5]",
        "medium = 'vmf_flake'\nalpha = 0.01\nflake = 'mirror'\naxis = [0.3, 0, 1]",
        "medium = 'vmf_flake'\nalpha = 0.03\nflake = 'mirror'",
        "medium = 'vmf_flake'\nroughness = 0.5\nflake = 'mirror'", "medium = 'lambert_sphere'",
        "medium = 'henyey_greenstein'\ng = 0.97", "medium = 'henyey_greenstein'\ng = -0.97"})
    for (const char* thickness : {"1e-9", "1", "1e4", "inf"})
      list.push_back(layer(std::string(medium) + "\nalbedo = 0.95\nthickness = " + thickness));
  std::string sixteen;
  for (int k = 0; k < 16; ++k)
    sixteen += layer(k % 2 ? "medium = 'henyey_greenstein'\ng = 0.8\nthickness = 0.3\nalbedo = 0.9"
                           : "medium = 'sggx'\nroughness = 0.2\nthickness = 0.05\nf0 = 0.1");
  list.push_back(sixteen);
  list.push_back(layer("medium = 'vmf_flake'\nroughness = 0.3\nthickness = 1e-3\nalbedo = 0.9") +
                 layer("medium = 'sggx'\nroughness = 0.1\nthickness = 20\nalbedo = 0.99") +
                 "[substrate]\nalbedo = [0.9, 0.5, 0.1]\n");
  return list;
}

struct Bias {
  double total = 0, difference = 0, error = 0;  // of what leaves in channel 0
};

Bias bias_of(const Stack& stack, Isa isa, Direction wi, std::uint64_t walks,
             Thinning thinning = {}) {
  Plan plan = make_plan(stack, {.max_order = 300, .thinning = thinning});
  plan.isa = isa;
  Simulation lanes(stack, plan, wi, Estimator::analog, CellGrid{2, 4, false}, 3);
  lanes.advance(walks);
  const auto exact =
      replay_in_double(stack, plan, lanes.incident(), 3, kBatches, walks, lanes.targets());
  // Leaving light, weighed by where it leaves to: directions count, too.
  const auto sum = [&](const BatchTally& b) {
    double all = 0;
    const std::size_t targets = lanes.targets().count();
    for (std::size_t j = 0; j < b.f.size(); ++j)
      if (j / targets % plan.channels == 0)
        all += b.f[j] * (1 + 0.5 * static_cast<double>(j % targets) / static_cast<double>(targets));
    return all;
  };
  Bias bias;
  double squares = 0;
  for (int k = 0; k < kBatches; ++k) {
    const double d = sum(lanes.batches()[k]) - sum(exact[k]);
    bias.total += sum(exact[k]);
    bias.difference += d;
    squares += d * d;
  }
  bias.error = std::sqrt(squares);
  return bias;
}

class LaneReplay : public ::testing::TestWithParam<Isa> {};

TEST_P(LaneReplay, FloatLanesHaveNoBiasAgainstTheSameWalksInDouble) {
  const bool soak = std::getenv("LAMELLA_SOAK") != nullptr;
  const std::uint64_t walks = soak ? 400000 : 2048;
  // All stacks and directions together: the bound of each alone is what `make soak` resolves.
  double together = 0, variance = 0;
  int count = 0;
  for (const std::string& toml : replayed_stacks()) {
    const Stack stack = stack_from(toml);
    for (const double mu : {1.0, 1e-3, 0.0, -1e-7, -0.5}) {
      if (mu < 0 && !stack.is_open_below()) continue;
      const Direction wi = direction_from_mu_phi(mu, 0.3);
      const Bias bias = bias_of(stack, GetParam(), wi, walks);
      if (bias.total == 0) continue;
      const double relative = bias.difference / bias.total, error = bias.error / bias.total;
      if (soak) std::printf("%s mu %g: %.1e +- %.1e\n", toml.c_str(), mu, relative, error);
      // One walk that took another turn is an error that no scatter shows.
      const double one_walk = 1.5 / static_cast<double>(walks);
      EXPECT_LT(std::abs(relative), kLargestBias + allowed_z() * std::max(error, one_walk))
          << toml << " mu " << mu;
      together += relative;
      variance += error * error;
      ++count;
    }
  }
  EXPECT_GT(count, 150);
  EXPECT_LT(std::abs(together) / count, kLargestBias + allowed_z() * std::sqrt(variance) / count);
  std::printf("%s: mean relative difference of %d cases %.1e +- %.1e\n",
              to_text(GetParam()).c_str(), count, together / count, std::sqrt(variance) / count);
}

// Thinned from the second event on: the same walks end, and the others count for as many.
TEST_P(LaneReplay, ThinnedWalksHaveNoBiasEither) {
  constexpr std::uint64_t kWalks = 2048;
  for (const char* medium :
       {"medium = 'sggx'\nroughness = 0.5\nalbedo = 0.95\nthickness = 4",
        "medium = 'lambert_sphere'\nalbedo = [0.9, 0.5, 0.2]\nthickness = inf",
        "medium = 'sggx'\nroughness = 0.3\nf0 = 0.5\nalbedo = 0.95\nthickness = 4"}) {
    const Bias bias = bias_of(stack_from(layer(medium)), GetParam(), direction_from_degrees(40, 0),
                              kWalks, Thinning{2});
    ASSERT_GT(bias.total, 0) << medium;
    // One walk that took another turn stands for 16 at most as good as always.
    EXPECT_LT(std::abs(bias.difference) / bias.total,
              kLargestBias + allowed_z() * std::max(bias.error / bias.total, 16.0 / kWalks))
        << medium;
    EXPECT_LT(std::abs(bias.difference) / bias.total, 0.02) << medium;
  }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, LaneReplay, ::testing::ValuesIn(lane_isas()),
                         [](const auto& isa) { return to_text(isa.param); });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LaneReplay);

}  // namespace
}  // namespace lamella
