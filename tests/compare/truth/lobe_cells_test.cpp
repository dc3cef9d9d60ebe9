#include "compare/truth/lobe_cells.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compare/truth/half_vector_grid.h"

namespace lamella {
namespace {

// f mu_i dw_i = D(h) h.z dh with a Gaussian of the slopes of h (Beckmann's distribution): all of
// its energy as long as few half vectors lead below the horizon.
Rgb gaussian_lobe(double roughness, Direction wi, Direction wo) {
  const Direction h = normalized(wi + wo);
  const double tan2 = (1 - h.z * h.z) / (h.z * h.z), a2 = roughness * roughness;
  const double d = std::exp(-tan2 / a2) / (kPi * a2 * h.z * h.z * h.z * h.z);
  return Rgb(d * h.z / (4 * wi.z * dot(wo, h)));
}

TEST(LobeCells, HoldTheEnergyOfLobesOfAnyWidth) {
  for (const double mu : {1.0, 0.9, 0.6, 0.3}) {
    const Direction wo = direction_from_mu_phi(mu, 0);
    for (const double roughness : {0.005, 0.02, 0.05, 0.1}) {
      if (roughness > 0.3 * mu) continue;  // too many half vectors lead below the horizon
      const LobeCells lobe =
          lobe_cells([&](Direction wi) { return gaussian_lobe(roughness, wi, wo); }, mu);
      EXPECT_TRUE(lobe.resolved);
      EXPECT_NEAR(lobe.energy.r, 1, kLobeTolerance) << "mu_o " << mu << ", roughness " << roughness;
    }
    const LobeCells white = lobe_cells([](Direction) { return Rgb(1 / kPi); }, mu);
    EXPECT_NEAR(white.energy.g, 1, 1e-6);
  }
}

TEST(LobeCells, CoverTheHalfDiscAndAreSmallestAtTheMirrorDirection) {
  const double mu = 0.7;
  const Direction wo = direction_from_mu_phi(mu, 0);
  const LobeCells lobe = lobe_cells([&](Direction wi) { return gaussian_lobe(0.02, wi, wo); }, mu);
  const DiscPoint mirror = on_lambert_disc({-wo.x, 0, wo.z});
  double least = 1, away = 0;
  for (const LobeCells::Cell& cell : lobe.cells)
    if (cell.size < least) {
      least = cell.size;
      away = std::hypot(cell.x - mirror.x, cell.y - mirror.y);
    }
  EXPECT_LT(least, 0.05);
  EXPECT_LT(away, 0.1);
}

TEST(LambertDisc, IsItsOwnWayBackAndKeepsSolidAngles) {
  for (const double mu : {1.0, 0.8, 0.3, 0.01})
    for (const double phi : {0.0, 1.0, 3.0}) {
      const Direction w = direction_from_mu_phi(mu, phi);
      const DiscPoint p = on_lambert_disc(w);
      EXPECT_NEAR(p.x * p.x + p.y * p.y, 1 - mu, 1e-14);
      const Direction back = from_lambert_disc(p);
      EXPECT_NEAR(back.x, w.x, 1e-14);
      EXPECT_NEAR(back.y, w.y, 1e-14);
      EXPECT_NEAR(back.z, w.z, 1e-14);
    }
}

TEST(HalfVectorGrid, ReturnsItsNodes) {
  HalfVectorGrid grid;
  const auto value = [](Direction wi, Direction wo) { return 1 + wi.x - 0.5 * wi.z * wo.z; };
  for (int o = 0; o < HalfVectorGrid::kOut; ++o) {
    const double mu = HalfVectorGrid::node_mu(o);
    EXPECT_NEAR(HalfVectorGrid::place_of_mu(mu), o, 1e-6);
    for (int a = 0; a < HalfVectorGrid::kAlpha; ++a)
      for (int b = 0; b < HalfVectorGrid::kBeta; ++b)
        grid.at(o, a, b) =
            Rgb(value(HalfVectorGrid::node_wi(mu, a, b), direction_from_mu_phi(mu, 0)));
  }
  for (int o = 1; o < HalfVectorGrid::kOut; o += 3) {
    const Direction wo = direction_from_mu_phi(HalfVectorGrid::node_mu(o), 0);
    for (int a = 1; a < HalfVectorGrid::kAlpha - 1; a += 4)
      for (int b = 0; b < HalfVectorGrid::kBeta; b += 4) {
        const Direction wi = HalfVectorGrid::node_wi(wo.z, a, b);
        if (wi.z <= 1.001 * HalfVectorGrid::kLeastMu) continue;  // raised from below the horizon
        EXPECT_NEAR(grid(wi, wo).r, value(wi, wo), 1e-5) << o << " " << a << " " << b;
      }
  }
}

// Between nodes a lobe moves with w_o, as narrow as it is.
TEST(HalfVectorGrid, HoldsANarrowLobeBetweenItsNodes) {
  const double roughness = 0.03;
  HalfVectorGrid grid;
  for (int o = 0; o < HalfVectorGrid::kOut; ++o) {
    const double mu = HalfVectorGrid::node_mu(o);
    for (int a = 0; a < HalfVectorGrid::kAlpha; ++a)
      for (int b = 0; b < HalfVectorGrid::kBeta; ++b)
        grid.at(o, a, b) = gaussian_lobe(roughness, HalfVectorGrid::node_wi(mu, a, b),
                                         direction_from_mu_phi(mu, 0));
  }
  for (const double place : {1.5, 5.5, 9.5, 12.5}) {
    const double mu = HalfVectorGrid::node_mu(place);
    const Direction wo = direction_from_mu_phi(mu, 0);
    const Rgb energy = lobe_cells([&](Direction wi) { return grid(wi, wo); }, mu).energy;
    // Chords lie above the tail of a Gaussian: 0.4 of its width apart, by 8 % of its energy.
    EXPECT_NEAR(energy.r, 1, 0.09) << mu;
    const Direction mirror{-wo.x, -wo.y, wo.z};
    EXPECT_NEAR(grid(mirror, wo).r / gaussian_lobe(roughness, mirror, wo).r, 1, 0.03) << mu;
  }
}

}  // namespace
}  // namespace lamella
