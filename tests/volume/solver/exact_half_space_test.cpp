#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "analytic/half_space/lambert_sphere_models.h"
#include "analytic/half_space/three_term.h"
#include "tests/volume/run/stacks.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/adding/doubling.h"
#include "volume/adding/layer_operator.h"
#include "volume/solver/deterministic.h"

// Half spaces that have exact solutions in H functions, against adding and doubling.

namespace lamella {
namespace {

const std::vector<double> kCosines{0.01, 0.1, 0.4, 0.7, 1};

// Largest difference of f_m between the two, relative to f_0.
double worst_difference(const ThreeTermPhase& w, int nodes) {
  const ThreeTermHalfSpace exact(w);
  const DirectionSets sets(nodes, kCosines, kCosines);
  const double terms[] = {1, w[1] / w[0], w[2] / w[0]};
  const LayerScattering scattering(legendre_modes(terms, sets, 3), w[0], sets);
  double worst = 0;
  for (int m = 0; m < 3; ++m) {
    const LayerOperator half_space = homogeneous_layer(
        scattering, std::numeric_limits<double>::infinity(), OperatorRules{sets, m, 1});
    // The solver's modes are in x = pi - phi, the exact ones include the factor 2.
    const double factor = m == 0 ? 1 : m == 1 ? -2 : 2;
    for (std::size_t i = 0; i < kCosines.size(); ++i)
      for (std::size_t o = 0; o < kCosines.size(); ++o) {
        const double f = factor * half_space.above.r[0](nodes + static_cast<int>(o),
                                                        nodes + static_cast<int>(i));
        worst = std::max(worst, std::abs(f - exact.mode(m, kCosines[i], kCosines[o])) /
                                    exact.mode(0, kCosines[i], kCosines[o]));
      }
  }
  return worst;
}

class ExactHalfSpaceWalk : public testing::OnEveryIsa {};

TEST(ExactHalfSpace, ThreeTermsOfLambertSpheresAgreeToEightDigits) {
  for (const double albedo : {0.3, 0.9, 0.99, 1.0})
    EXPECT_LT(worst_difference(lambert_sphere_phase_terms(albedo), 48), 1e-8) << albedo;
}

TEST(ExactHalfSpace, ForwardAndRayleighLikeSeriesAgreeToEightDigits) {
  for (const double albedo : {0.6, 0.99}) {
    EXPECT_LT(worst_difference({albedo, 1e-3 * albedo, albedo / 2}, 48), 1e-8) << albedo;
    EXPECT_LT(worst_difference({albedo, albedo, albedo * 0.4}, 48), 1e-8) << albedo;
  }
}

TEST(ExactHalfSpace, IsotropicScatteringIsTheFirstTerm) {
  for (const double albedo : {0.5, 0.9, 1.0})
    EXPECT_LT(worst_difference({albedo, 0, 0}, 48), 1e-8) << albedo;
}

// Rayleigh's phase function is the series 1 + P_2 / 2.
TEST(ExactHalfSpace, RayleighScatteringReflectsAsItsThreeTermSolution) {
  for (const double albedo : {0.6, 0.9, 0.99}) {
    const Stack stack = stack_of(layer("medium = \"rayleigh\"", albedo, kInfinity));
    const DeterministicSolution solved = solve_deterministic(stack, {.tolerance = 1e-7});
    const ThreeTermHalfSpace exact({albedo, 0, albedo / 2});
    for (const double mu_i : {0.1, 0.5, 1.0})
      for (const double mu_o : {0.05, 0.4, 0.9})
        for (const double phi : {0.0, 1.0, 2.5}) {
          const double f =
              solved.f(direction_from_mu_phi(mu_i, 0.3), direction_from_mu_phi(mu_o, 0.3 + phi))
                  .order[Order::all]
                  .r;
          const double expected = exact.mode(0, mu_i, mu_o) +
                                  exact.mode(1, mu_i, mu_o) * std::cos(phi) +
                                  exact.mode(2, mu_i, mu_o) * std::cos(2 * phi);
          EXPECT_NEAR(f, expected, 2e-7 * exact.mode(0, mu_i, mu_o))
              << albedo << " from " << mu_i << " to " << mu_o << " at " << phi;
        }
  }
}

TEST_P(ExactHalfSpaceWalk, RayleighScatteringReflectsItsAlbedo) {
  const Stack stack =
      testing::stack_from(testing::layer("medium = 'rayleigh'\nalbedo = 0.9\nthickness = inf"));
  const ThreeTermHalfSpace exact({0.9, 0, 0.45});
  for (const double mu : {0.1, 0.8}) {
    Simulation simulation(stack, testing::plan_of(stack), direction_from_mu_phi(mu, 0),
                          Estimator::analog, {}, 1);
    simulation.advance(testing::soaked(200000));
    const Estimate reflected = reduce(simulation).reflected.total[0];
    EXPECT_LT(std::abs(reflected.value - exact.albedo(mu)), 5 * reflected.standard_error) << mu;
    EXPECT_LT(reflected.standard_error, 2e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, ExactHalfSpaceWalk, ::testing::ValuesIn(supported_isas()),
                         [](const auto& which) { return to_text(which.param); });

}  // namespace
}  // namespace lamella
