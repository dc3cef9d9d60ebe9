// The hard cases of the walk: finite, energy kept, and where a limit is known, the limit.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/volume/run/stacks.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::layer;
using testing::plan_of;
using testing::stack_from;

RunResult run_of(const Stack& stack, Direction wi, Estimator estimator, std::uint64_t walks,
                 std::uint64_t max_order = 1000) {
  Simulation simulation(stack, plan_of(stack, max_order), wi, estimator, CellGrid{2, 4, false}, 1);
  simulation.advance(walks);
  return reduce(simulation);
}

void expect_sound(const RunResult& run, const std::string& what) {
  for (int c = 0; c < run.channels; ++c) {
    EXPECT_NEAR(ledger_sum(run, c), 1, 1e-11) << what;
    for (const SideResult* side : {&run.reflected, &run.transmitted}) {
      EXPECT_GE(side->total[c].value, 0) << what;
      for (const LobeEstimate& lobe : side->lobes)
        for (std::size_t k = 0; k < lobe.value.size(); ++k) {
          EXPECT_TRUE(std::isfinite(lobe.value[k]) && std::isfinite(lobe.standard_error[k]))
              << what;
          EXPECT_GE(lobe.value[k], 0) << what;
        }
    }
  }
}

const std::vector<std::string>& extreme_media() {
  static const std::vector<std::string> list{
      "medium = 'sggx'\nroughness = 0.001",
      "medium = 'sggx'\nroughness = 1",
      "medium = 'sggx'\nshape = 'fiber'\nroughness = 0.001\naxis = [1, 1, 1]",
      "medium = 'sggx'\nroughness = 0.001\nflake = 'lambert'",
      "medium = 'sggx'\nmatrix = [1, 1, 1e-6, 0.999999, 0, 0]",
      "medium = 'sggx'\nroughness = 0.05\nf0 = 0",
      "medium = 'vmf_flake'\nroughness = 0",
      "medium = 'vmf_flake'\nroughness = 0\nflake = 'mirror'",
      "medium = 'vmf_flake'\nroughness = 1",
      "medium = 'vmf_flake'\nalpha = 0.01\nflake = 'mirror'",
      "medium = 'vmf_flake'\nalpha = inf\nflake = 'mirror'",
      "medium = 'vmf_flake'\nroughness = 0.1\naxis = [1, 0, 0]",
      "medium = 'vmf_flake'\nroughness = 0.1\naxis = [0, 0, -1]",
      "medium = 'lambert_sphere'",
      "medium = 'henyey_greenstein'\ng = 0.999",
      "medium = 'henyey_greenstein'\ng = -0.999",
  };
  return list;
}

class WalkHardCases : public testing::OnEveryIsa {};

TEST_P(WalkHardCases, EveryMediumAtBothEndsOverOpticalDepthsAndAngles) {
  for (const std::string& medium : extreme_media())
    for (const char* thickness : {"0", "1e-9", "1", "1e9"})
      for (const double mu : {1.0, 0.5, 1e-3, 1e-7, 0.0, -1e-7, -1.0}) {
        const Stack stack =
            stack_from(layer(medium + "\nalbedo = 0.9\nthickness = " + std::string(thickness)));
        for (const Estimator estimator : {Estimator::analog, Estimator::next_event})
          expect_sound(run_of(stack, direction_from_mu_phi(mu, 0.3), estimator, 256, 200),
                       medium + " thickness " + thickness + " mu " + std::to_string(mu));
      }
}

TEST_P(WalkHardCases, HalfSpacesOfAlbedoZeroAndOne) {
  for (const std::string& medium : extreme_media())
    for (const char* albedo : {"0", "1"})
      for (const double mu : {1.0, 1e-7, 0.0}) {
        const Stack stack =
            stack_from(layer(medium + "\nthickness = inf\nalbedo = " + std::string(albedo)));
        const RunResult run =
            run_of(stack, direction_from_mu_phi(mu, 0), Estimator::analog, 256, 100);
        expect_sound(run, medium + " albedo " + albedo);
        if (std::string(albedo) == "0") {
          EXPECT_EQ(run.reflected.total[0].value, 0) << medium;
        }
      }
}

TEST_P(WalkHardCases, GrazingLightOnAnIsotropicHalfSpaceHasItsLimit) {
  // Energy reflected at mu = 0 of an isotropic half space: 1 - sqrt(1 - c) H(0) with H(0) = 1.
  const Stack stack =
      stack_from(layer("medium = 'henyey_greenstein'\nalbedo = 0.8\nthickness = inf"));
  for (const double mu : {0.0, 1e-7}) {
    const RunResult run = run_of(stack, direction_from_mu_phi(mu, 0), Estimator::analog, 200000);
    EXPECT_NEAR(run.reflected.total[0].value, 1 - std::sqrt(0.2),
                allowed_z() * run.reflected.total[0].standard_error + 1e-6)
        << mu;
  }
}

TEST_P(WalkHardCases, ThinLayersReflectInProportionToTheirDepth) {
  // Order 1 of an isotropic layer tends to c depth / (2 mu) as depth -> 0: half of what collides.
  const Stack stack =
      stack_from(layer("medium = 'henyey_greenstein'\nalbedo = 1\nthickness = 1e-4"));
  const RunResult run =
      run_of(stack, direction_from_mu_phi(0.5, 0), Estimator::next_event, 4000000);
  double energy = 0, variance = 0;
  for (std::size_t k = 0; k < run.reflected.lobes[0].value.size(); ++k) {
    energy += run.grid.projected_solid_angle() * run.reflected.lobes[0].value[k];
    variance +=
        std::pow(run.grid.projected_solid_angle() * run.reflected.lobes[0].standard_error[k], 2);
  }
  // Cells share walks: the errors add up linearly at worst.
  const double error = std::sqrt(variance * static_cast<double>(run.grid.cells()));
  EXPECT_NEAR(energy, 1e-4, allowed_z() * error + 2e-7);
}

TEST_P(WalkHardCases, AThousandLayersEqualOne) {
  std::string many;
  for (int k = 0; k < 1000; ++k)
    many += layer("medium = 'henyey_greenstein'\ng = 0.5\nalbedo = 0.9\nthickness = 0.002");
  const Stack thousand = stack_from(many);
  const Stack one =
      stack_from(layer("medium = 'henyey_greenstein'\ng = 0.5\nalbedo = 0.9\nthickness = 2"));
  const Direction wi = direction_from_degrees(60, 0);
  const RunResult a = run_of(thousand, wi, Estimator::analog, 20000);
  const RunResult b = run_of(one, wi, Estimator::analog, 20000);
  for (const bool reflected : {true, false}) {
    const Estimate x = (reflected ? a.reflected : a.transmitted).total[0];
    const Estimate y = (reflected ? b.reflected : b.transmitted).total[0];
    EXPECT_LT(std::abs(testing::z_between(x, y)), allowed_z());
  }
}

TEST_P(WalkHardCases, EmptyStackIsACleanWindow) {
  const Stack stack = stack_from(layer("medium = 'lambert_sphere'\nthickness = 0"));
  for (const double mu : {1.0, 0.0, -0.5}) {
    const RunResult run = run_of(stack, direction_from_mu_phi(mu, 0), Estimator::next_event, 256);
    EXPECT_EQ(run.uncollided[0].value, 1);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, WalkHardCases, ::testing::ValuesIn(supported_isas()),
                         [](const auto& isa) { return to_text(isa.param); });

}  // namespace
}  // namespace lamella
