#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "phase/stack/single_scattering.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

const std::vector<std::string>& media_under_test() {
  static const std::vector<std::string> list{kIsotropic,
                                             kSphere,
                                             henyey_greenstein(0.7),
                                             henyey_greenstein(-0.5),
                                             sggx(0.5, "mirror"),
                                             sggx(0.3, "lambert"),
                                             fiber(0.4, "mirror"),
                                             vmf(0.5, "lambert"),
                                             vmf(0.01, "lambert"),
                                             vmf(0, "lambert"),
                                             vmf(0.4, "mirror")};
  return list;
}

TEST(DeterministicEnergy, IsConservedAtAlbedoOneAtEveryDepth) {
  const double both[] = {1, 0.3, 0.01, 1e-7, 0, -0.01, -0.6, -1};
  for (const std::string& medium : media_under_test())
    for (const double thickness : {1e-6, 1.0, 1e6, kInfinity}) {
      const Stack stack = stack_of(layer(medium, 1, thickness));
      const DeterministicSolution s =
          solve_deterministic(stack, {.tolerance = 1e-2, .min_nodes = 12, .max_nodes = 12});
      const std::span<const double> mu(both, stack.is_open_below() ? 8 : 5);
      for (const DeterministicEnergies& e : s.energies(mu)) {
        EXPECT_NEAR(e.sum().r, 1, 1e-10) << medium << ' ' << thickness;
        EXPECT_EQ(e.absorbed.r, 0) << medium << ' ' << thickness;
      }
    }
}

TEST(DeterministicEnergy, AbsorptionClosesTheLedger) {
  const double both[] = {1, 0.3, 0.01, 0, -0.01, -0.6, -1};
  for (const std::string& medium : media_under_test())
    for (const bool ground : {false, true}) {
      const Stack stack = stack_of(layer(medium, 0.7, 1) + layer(kSphere, 0.9, 2) +
                                   (ground ? lambert_ground(0.8) : ""));
      const DeterministicSolution s =
          solve_deterministic(stack, {.tolerance = 1e-2, .min_nodes = 12, .max_nodes = 12});
      for (const DeterministicEnergies& e : s.energies({both, ground ? 4u : 7u}))
        EXPECT_NEAR(e.sum().r, 1, 1e-10) << medium << ' ' << ground;
    }
}

TEST(DeterministicEnergy, SchlickMirrorsAbsorbWhatTheyDoNotReflect) {
  const Stack stack = stack_of(layer(sggx(0.5, "mirror") + "\nf0 = 0.04", 1, 3));
  const DeterministicSolution s =
      solve_deterministic(stack, {.tolerance = 1e-2, .min_nodes = 12, .max_nodes = 12});
  const double mu[] = {0.8, 0.05, -0.5};
  for (const DeterministicEnergies& e : s.energies(mu)) {
    EXPECT_NEAR(e.sum().r, 1, 1e-10);
    EXPECT_GT(e.absorbed.r, 0.3);
  }
}

TEST(DeterministicEnergy, TransmissionOfAWhiteSlabFallsLikeOneOverItsDepth) {
  // The diffusion limit: T (tau + 2 q) -> const, q = 0.7104 the extrapolation length.
  const double mu[] = {1};
  double scaled[2];
  int k = 0;
  for (const double thickness : {1e5, 1e6}) {
    const DeterministicSolution s =
        solve_deterministic(stack_of(layer(kIsotropic, 1, thickness)), {.tolerance = 1e-6});
    scaled[k++] = s.energies(mu)[0].transmitted[Order::all].r * (thickness + 1.42089);
  }
  EXPECT_NEAR(scaled[1] / scaled[0], 1, 1e-9);
  // Milne's problem: the emergent radiance of a deep source is proportional to H(mu) / sqrt(3).
  EXPECT_NEAR(scaled[1], 2.907810529 / std::sqrt(3.0), 1e-6);
}

TEST(DeterministicEnergy, FlakesThatFaceDownLetLightEscapeToTheDepth) {
  const DeterministicSolution s = solve_deterministic(
      stack_of(layer(vmf(0.3, "lambert") + "\naxis = [0, 0, -1]", 1, kInfinity)),
      {.tolerance = 1e-2, .min_nodes = 12, .max_nodes = 12});
  const double mu[] = {0.7};
  const DeterministicEnergies e = s.energies(mu)[0];
  EXPECT_GT(e.escaped[Order::all].r, 0.1);
  EXPECT_NEAR(e.sum().r, 1, 1e-10);
}

TEST(DeterministicHardCase, AThinLayerIsSingleScattering) {
  for (const std::string& medium : {kSphere, sggx(0.5, "mirror"), vmf(0.5, "lambert")}) {
    const Stack stack = stack_of(layer(medium, 0.9, 1e-6));
    const DeterministicSolution s = solve_deterministic(stack, {.tolerance = 1e-6});
    const Direction wi = direction_from_mu_phi(0.6, 0), wo = direction_from_mu_phi(0.3, 2);
    const DeterministicValue f = s.f(wi, wo);
    EXPECT_EQ(f.order[0].r, single_scattering(stack, wi, wo).layers.r);
    EXPECT_NEAR(f.order[Order::all].r / f.order[0].r, 1, 2e-5);
    EXPECT_GT(f.order[1].r, 0);
    EXPECT_LT(f.order[2].r, 1e-4 * f.order[1].r);
  }
}

TEST(DeterministicHardCase, AThickLayerIsAHalfSpace) {
  for (const std::string& medium : {kSphere, vmf(0.5, "lambert")}) {
    const DeterministicOptions options{.tolerance = 1e-2, .min_nodes = 16, .max_nodes = 16};
    const Direction wi = direction_from_mu_phi(0.6, 0), wo = direction_from_mu_phi(0.3, 2);
    double f[2];
    int k = 0;
    for (const double thickness : {1e6, kInfinity})
      f[k++] = solve_deterministic(stack_of(layer(medium, 0.95, thickness)), options)
                   .f(wi, wo)
                   .order[Order::all]
                   .r;
    EXPECT_NEAR(f[0] / f[1], 1, 1e-13) << medium;
  }
}

TEST(DeterministicHardCase, StronglyForwardScatteringThickLayer) {
  const Stack stack = stack_of(layer(henyey_greenstein(0.95), 1, 100));
  const DeterministicOptions coarse{
      .tolerance = 1e-3, .min_nodes = 32, .max_nodes = 32, .max_modes = 12};
  const DeterministicOptions fine{
      .tolerance = 1e-3, .min_nodes = 48, .max_nodes = 48, .max_modes = 12};
  const DeterministicSolution a = solve_deterministic(stack, coarse),
                              b = solve_deterministic(stack, fine);
  const double mu[] = {0.2, 0.9};
  const auto ea = a.energies(mu), eb = b.energies(mu);
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(ea[k].sum().r, 1, 1e-10);
    EXPECT_NEAR(ea[k].reflected[Order::all].r, eb[k].reflected[Order::all].r, 1e-5);
    EXPECT_NEAR(ea[k].transmitted[Order::all].r, eb[k].transmitted[Order::all].r, 1e-5);
  }
}

TEST(DeterministicHardCase, GrazingDirectionsHaveALimit) {
  for (const std::string& medium : {kSphere, vmf(0.5, "lambert"), sggx(0.5, "lambert")}) {
    const DeterministicSolution s =
        solve_deterministic(stack_of(layer(medium, 0.9, 1)), {.tolerance = 1e-5});
    const Direction wi = direction_from_mu_phi(0.6, 0);
    const double at = s.f(wi, direction_from_mu_phi(0, 2)).order[Order::all].r;
    const double near = s.f(wi, direction_from_mu_phi(1e-7, 2)).order[Order::all].r;
    EXPECT_NEAR(near / at, 1, 1e-5) << medium;
    EXPECT_NEAR(
        s.f(direction_from_mu_phi(0, 0), direction_from_mu_phi(0.6, 2)).order[Order::all].r / at, 1,
        1e-9)
        << medium;
  }
}

}  // namespace
}  // namespace lamella
