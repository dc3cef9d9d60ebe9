// The program without Embree: this test links the stand-in of grain_scene.cpp.
#include <gtest/gtest.h>

#include "tests/volume/run/stacks.h"

namespace lamella::testing {
namespace {

TEST(GrainsWithoutEmbree, AreRefusedWithAMessageThatSaysSo) {
  EXPECT_FALSE(GrainScene::is_available());
  const Stack stack =
      stack_from(layer("medium = 'sphere_bed'\nradius = 0.02\npacking = 0.1\nthickness = 1"));
  try {
    Simulation simulation(stack, make_plan(stack), {0, 0, 1}, Estimator::analog, {4, 8, false}, 1);
    FAIL() << "taken";
  } catch (const GeometryError& error) {
    EXPECT_NE(std::string(error.what()).find("-DLAMELLA_EMBREE=OFF"), std::string::npos);
  }
  const Stack slab = stack_from(layer("medium = 'lambert_sphere'\nthickness = 1"));
  Simulation simulation(slab, make_plan(slab), {0, 0, 1}, Estimator::analog, {4, 8, false}, 1);
  simulation.advance(1000);
  EXPECT_EQ(simulation.walks(), 1000U);
}

}  // namespace
}  // namespace lamella::testing
