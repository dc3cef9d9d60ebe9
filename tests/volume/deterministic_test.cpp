#include "volume/deterministic.h"

#include <gtest/gtest.h>

#include "phase/stack_file.h"

namespace lamella {
namespace {

Stack stack_of(const std::string& toml) { return parse_stack(toml, "test", "test"); }

TEST(Deterministic, IsotropicSlabMatchesVanDeHulst1980Table12) {
  const Stack stack = stack_of(
      "[[layer]]\nmedium = \"henyey_greenstein\"\nalbedo = 0.8\nthickness = 2.0\n");
  const DeterministicSolution s = solve_deterministic(stack);
  printf("%d nodes %d modes err %g sec %g\n", s.accuracy().nodes, s.accuracy().modes, s.accuracy().error, s.accuracy().seconds);
  const double mu[] = {1, 0.9, 0.7, 0.5, 0.3, 0.1};
  const double reflected[] = {0.28616, 0.30277, 0.34188, 0.39102, 0.45353, 0.53214};
  const double transmitted[] = {0.14864, 0.14731, 0.13963, -1, 0.09425, 0.06601};
  for (int k = 0; k < 6; ++k) {
    const Direction wi = direction_from_mu_phi(mu[k], 0), up = direction_from_mu_phi(0.5, 1),
                    down = direction_from_mu_phi(-0.5, 1);
    EXPECT_NEAR(kPi * s.f(wi, up).order[4].r, reflected[k], 6e-6);
    if (transmitted[k] > 0) {
      EXPECT_NEAR(kPi * s.f(wi, down).order[4].r, transmitted[k], 6e-6);
    }
  }
  const double grazing[] = {0, 0.01, 1, -0.3};
  for (const DeterministicEnergies& e : s.energies(grazing))
    printf("%.3e sum-1, %.12g %.12g\n", e.sum().r - 1, e.reflected[4].r, e.absorbed.r);
}

}  // namespace
}  // namespace lamella
