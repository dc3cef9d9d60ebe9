// Boundaries as operators between waves in the azimuth: where facets are the same along x and y
// they are those of azimuthal modes.
#include "volume/harmonics/anisotropic_boundary.h"

#include <gtest/gtest.h>

#include "volume/adding/rough_boundary.h"

namespace lamella {
namespace {

// Of a beam from either side: what is reflected and what is transmitted.
TEST(AnisotropicBoundary, IsThatOfModesWhereFacetsAreTheSameAlongBoth) {
  constexpr int kNodes = 24, kDegree = 6;
  constexpr double kAlpha = 0.4;
  const RefractiveNodes refractive{{1, 1.5}, kNodes};
  const AskedCosine asked[] = {{0.766, 1}, {0.3, 1}, {0.9, 1.5}};
  const DirectionSets above(refractive, 1, {}, asked), below(refractive, 1.5, {}, asked);
  Interface interface;
  interface.facets = {FacetShape::ggx, kAlpha, kAlpha};
  interface.ior = 1.5;
  const RoughBoundary modes(interface, above, below, 1);
  const AnisotropicBoundary waves(interface, above, below, kDegree, MatrixProduct(Isa::scalar));
  const PileOperator pile = modes.at(0);
  const auto energy = [](const DirectionSets& sets, const Eigen::MatrixXd& f, Eigen::Index column) {
    return sets.flux.dot(f.col(column).head(sets.nodes()));
  };
  for (const bool from_above : {true, false})
    for (Eigen::Index k = 0; k < 3; ++k) {
      const DirectionSets &here = from_above ? above : below, &there = from_above ? below : above;
      if (!here.in_exists[static_cast<std::size_t>(k)]) continue;
      const FaceLight light =
          waves.from_beam(1, k, from_above ? 1 : 0, from_above ? 0 : 1, 2 * kDegree + 1);
      const PileSide& side = from_above ? pile.above : pile.below;
      const Eigen::Index column = here.nodes() + k;
      // On the denser side total reflection at facets has a kink.
      EXPECT_NEAR(energy(here, from_above ? light.up : light.down, 0),
                  energy(here, side.r[0], column), from_above ? 1e-9 : 1e-4);
      EXPECT_NEAR(energy(there, from_above ? light.down : light.up, 0),
                  energy(there, side.t[0], column), 1e-6);
    }
}

}  // namespace
}  // namespace lamella
