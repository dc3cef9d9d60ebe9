// Order 1 on cells in closed form: against adaptive quadrature of single scattering itself, which
// knows no modes of Lambertian flakes, and against the solver's energies.
#include "volume/solver/closed_first.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "phase/math/degrees.h"
#include "phase/stack/single_scattering.h"
#include "tests/volume/run/stacks.h"
#include "volume/quadrature/cell_quadrature.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

struct FirstCase {
  const char* what;
  std::string toml;
  double theta;
};

const std::string kThinLayer = "\nalbedo = [0.8, 0.5, 0.9]\nthickness = 0.7";

std::vector<FirstCase> first_cases() {
  return {
      {"vMF, half space",
       testing::layer("medium = 'vmf_flake'\nroughness = 0.5\nalbedo = 0.9\nthickness = inf"), 60},
      {"vMF, near grazing", testing::layer("medium = 'vmf_flake'\nroughness = 0.2" + kThinLayer),
       88},
      {"narrow vMF from below",
       testing::layer("medium = 'vmf_flake'\nroughness = 0.05" + kThinLayer), 140},
      {"vMF downwards",
       testing::layer("medium = 'vmf_flake'\nroughness = 0.4\naxis = [0, 0, -1]" + kThinLayer), 30},
      {"Lambertian SGGX under mirrors, substrate",
       testing::layer("medium = 'sggx'\nroughness = 0.3" + kThinLayer) +
           testing::layer("medium = 'sggx'\nroughness = 0.4\nflake = 'lambert'" + kThinLayer) +
           "[substrate]\nalbedo = [0.5, 0.1, 1]\n",
       45},
      {"fibers",
       testing::layer("medium = 'sggx'\nshape = 'fiber'\nroughness = 0.3\naxis = [1, 0.4, 0.3]" +
                      kThinLayer),
       70},
      {"spheres", testing::layer("medium = 'lambert_sphere'" + kThinLayer), 120},
      {"under a smooth interface",
       testing::layer("interface = 'smooth'\nior = 1.5") +
           testing::layer("medium = 'lambert_sphere'" + kThinLayer) + "[substrate]\nalbedo = 0.5\n",
       50},
  };
}

TEST(ClosedFirst, IsTheMeanOfSingleScatteringOverEveryCell) {
  for (const FirstCase& c : first_cases()) {
    const Stack stack = testing::stack_from(c.toml);
    if (stack.has_boundaries()) continue;  // the solver's energies, below
    ASSERT_FALSE(why_no_closed_first(stack)) << c.what;
    const Direction wi = direction_from_degrees(c.theta, 20);
    const CellGrid grid{4, 8, stack.is_symmetric_about_z()};
    const bool both = stack.is_open_below();
    const ClosedFirst first = closed_first(stack, grid, wi, 3, both);
    for (const bool up : {true, false}) {
      const LobeEstimate& lobe = up ? first.up : first.down;
      ASSERT_EQ(lobe.value.empty(), !up && !both) << c.what;
      if (lobe.value.empty()) continue;
      for (const int cell : {0, grid.cells() / 2 + 1, grid.cells() - 1}) {
        const int row = cell / grid.columns(), column = cell % grid.columns();
        const CellMean direct = cell_mean(
            [&](double mu, double phi) {
              const SingleScattering s = single_scattering(
                  stack, wi, direction_from_mu_phi(up ? mu : -mu, azimuth(wi) + phi));
              return s.layers + s.substrate;
            },
            {grid.edge_mu(row + 1), grid.edge_mu(row), grid.edge_phi(column),
             grid.edge_phi(column + 1)},
            Rgb(1e-7), {{std::abs(wi.z), 0}, {std::abs(wi.z), kPi}});
        for (int channel = 0; channel < 3; ++channel) {
          const std::size_t k = static_cast<std::size_t>(channel) * grid.cells() + cell;
          EXPECT_NEAR(lobe.value[k], direct.value[channel],
                      lobe.standard_error[k] + direct.error[channel] + 1e-9)
              << c.what << ", up " << up << ", cell " << cell;
          EXPECT_LT(lobe.standard_error[k], 3e-5 * std::max(1.0, lobe.value[k])) << c.what;
        }
      }
    }
  }
}

TEST(ClosedFirst, HasTheSolversEnergies) {
  for (const FirstCase& c : first_cases()) {
    const Stack stack = testing::stack_from(c.toml);
    // One of Lambertian flakes and one under an interface: the others take the solver long.
    if (!stack.is_half_space() && !stack.has_boundaries()) continue;
    const Direction wi = direction_from_degrees(c.theta, 0);
    const DeterministicSolution solution = solve_deterministic(stack, {.tolerance = 1e-4});
    const double along[] = {wi.z};
    const DeterministicEnergies solved = solution.energies(along)[0];
    const CellGrid grid{8, 16, true};
    const ClosedFirst first = closed_first(stack, grid, wi, 3, stack.is_open_below());
    for (const bool up : {true, false}) {
      const LobeEstimate& lobe = up ? first.up : first.down;
      if (lobe.value.empty()) continue;
      for (int channel = 0; channel < 3; ++channel) {
        double energy = 0;
        for (int cell = 0; cell < grid.cells(); ++cell)
          energy += grid.projected_solid_angle() *
                    lobe.value[static_cast<std::size_t>(channel) * grid.cells() + cell];
        const bool reflected = up == (wi.z > 0);
        const double expected =
            (reflected ? solved.reflected : solved.transmitted)[Order::one][channel];
        EXPECT_NEAR(energy, expected, 1e-3 * expected + 1e-7) << c.what << ", up " << up;
      }
    }
    EXPECT_NEAR(first.uncollided.value_or(solved.uncollided.r), solved.uncollided.r, 1e-12)
        << c.what;
  }
}

TEST(ClosedFirst, SaysWhyThereIsNone) {
  using ::testing::HasSubstr;
  const auto why = [](const std::string& toml) {
    return why_no_closed_first(testing::stack_from(toml)).value_or("");
  };
  EXPECT_EQ(why(testing::layer("medium = 'lambert_sphere'\nthickness = 1")), "");
  EXPECT_THAT(
      why(testing::layer("medium = 'vmf_flake'\nroughness = 0\nflake = 'mirror'\nthickness = 1")),
      HasSubstr("delta"));
  EXPECT_THAT(
      why(testing::layer("medium = 'vmf_flake'\nroughness = 0.3\naxis = [1, 0, 1]\nthickness = 1")),
      HasSubstr("tilted"));
  EXPECT_THAT(why(testing::layer("interface = 'ggx'\nior = 1.5\nroughness = 0.3") +
                  testing::layer("medium = 'lambert_sphere'\nthickness = 1")),
              HasSubstr("rough"));
  EXPECT_THAT(
      why(testing::layer("medium = 'sphere_bed'\nradius = 0.02\npacking = 0.1\nthickness = 1")),
      HasSubstr("geometry"));
  std::string many;
  for (int k = 0; k < 17; ++k) many += testing::layer("medium = 'lambert_sphere'\nthickness = 0.1");
  EXPECT_THAT(why(many), HasSubstr("17 layers"));
}

}  // namespace
}  // namespace lamella
