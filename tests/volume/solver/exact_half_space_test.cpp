#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "analytic/half_space/lambert_sphere_models.h"
#include "analytic/half_space/three_term.h"
#include "volume/adding/layer_operator.h"

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

}  // namespace
}  // namespace lamella
