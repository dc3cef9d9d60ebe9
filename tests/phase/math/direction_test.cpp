#include "phase/math/direction.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lamella {
namespace {

// Whole turns change nothing, however many there are.
TEST(Direction, AzimuthsOfAnySizeAreTakenModuloATurn) {
  for (const double phi : {1e7, -1e7, 1e12, 1e20, 1e300}) {
    const Direction w = direction_from_degrees(30, phi);
    const Direction same = direction_from_degrees(30, std::fmod(phi, 360));
    EXPECT_EQ(w, same) << phi;
    EXPECT_NEAR(dot(w, w), 1, 1e-15);
  }
}

}  // namespace
}  // namespace lamella
