#include "volume/adding/rough_crossing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "phase/interface/dielectric.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/adding/pile_modes.h"
#include "volume/quadrature/quadrature.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

// From 1 and 1.3 through 1.6. The reference's points do not end where facets do, which costs it
// 5e-6.
TEST(RoughCrossing, IsTheIntegralOverTheDirectionInBetween) {
  const Stack stack = stack_of(layer(vmf(0.6, "lambert"), 0, 0.4));
  const Layer& absorber = stack.layers[0];
  Interface upper, lower;
  upper.facets = {FacetShape::ggx, 0.4, 0.4};
  upper.ior = 1.6;
  lower.facets = {FacetShape::beckmann, 0.3, 0.3};
  lower.ior = 1.3;
  const RefractiveNodes refractive{{1, 1.3, 1.6}, 8, {}};
  const std::vector<AskedCosine> asked{{1, 1}, {0.6, 1}, {0.2, 1}, {0.95, 1.3}, {0.5, 1.3}};
  const DirectionSets above(refractive, 1, asked, asked), between(refractive, 1.6, asked, asked),
      below(refractive, 1.3, asked, asked);
  constexpr int kModes = 40;
  const RoughCrossing crossing(upper, lower, above, between, below, {&absorber}, kModes);
  const Dielectric first{
      .facets = upper.facets, .masking = upper.masking, .above = 1, .below = 1.6},
      second{.facets = lower.facets, .masking = lower.masking, .above = 1.6, .below = 1.3};
  const Quadrature &theta = cached_gauss_legendre(240), &phi = cached_gauss_legendre(240);
  const auto expected = [&](Direction wi, Direction wo, bool down) {
    const Dielectric &in = down ? first : second, &out = down ? second : first;
    double sum = 0;
    for (int a = 0; a < 240; ++a)
      for (int b = 0; b < 240; ++b) {
        const double mu = std::cos(kPi / 2 * theta.points[a]);
        const Direction w = direction_from_mu_phi(down ? -mu : mu, 2 * kPi * phi.points[b]);
        const double f = in.single(wi, w) * out.single(-w, wo);
        sum += f * mu * crossing.survives(mu, down) * kPi / 2 * theta.weights[a] *
               std::sqrt(1 - mu * mu) * 2 * kPi * phi.weights[b];
      }
    return sum;
  };
  const double x = 0.4;
  for (const bool down : {true, false})
    for (int i = 0; i < 3; ++i)
      for (int o = 0; o < 2; ++o) {
        const double outside = asked[i].mu, inside = asked[3 + o].mu;
        const Direction top = direction_from_mu_phi(outside, 0),
                        bottom = direction_from_mu_phi(-inside, kPi - x);
        const double f = down ? expected(top, bottom, true) : expected(bottom, top, false);
        double sum = 0;
        for (int m = 0; m < kModes; ++m)
          sum += (m == 0 ? 1 : 2) * std::cos(m * x) *
                 (down ? crossing.down[m](3 + o, i) : crossing.up[m](i, 3 + o));
        EXPECT_NEAR(sum, f, 1e-5 * f + 1e-15) << down << ' ' << outside << ' ' << inside;
      }
}

// Two rough faces about a layer: straight through along the normal, where both lobes are narrow.
TEST(RoughCrossing, SparesPlatesNodes) {
  const auto face = [](double ior) {
    return fmt::format("[[layer]]\ninterface = \"ggx\"\nior = {}\nroughness = 0.4\n", ior);
  };
  const Stack stack = stack_of(face(1.5) + layer(kIsotropic, 0.9, 0.8) + face(1));
  const auto solve = [&](int nodes) {
    return solve_deterministic(stack, {.tolerance = 1e-6,
                                       .min_nodes = nodes,
                                       .max_nodes = nodes,
                                       .max_modes = 24,
                                       .max_seconds = 1e4});
  };
  const DeterministicSolution coarse = solve(16), fine = solve(24);
  const double mu_i[] = {1, 0.6}, mu_o[] = {-1, -0.6, -0.05};
  const DeterministicField a = coarse.field(mu_i, mu_o), b = fine.field(mu_i, mu_o);
  for (int i = 0; i < 2; ++i)
    for (int o = 0; o < 3; ++o)
      EXPECT_NEAR(a.mode(0, 4, 0, i, o) / b.mode(0, 4, 0, i, o), 1, 5e-4) << i << ' ' << o;
}

}  // namespace
}  // namespace lamella
