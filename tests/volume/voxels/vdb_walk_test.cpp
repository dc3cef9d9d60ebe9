// What light makes of a .vdb file.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/volume/voxels/grids.h"
#include "tests/volume/voxels/vdb_fixture.h"

namespace lamella {
namespace {

using testing::stripe;
using testing::VdbFile;
using testing::write;

TEST_F(VdbFile, AStripeBetweenMarginsOfZerosStaysAStripe) {
  const auto uncollided = [&](const std::string& keys) {
    const Stack stack = testing::stack_from(
        "[[layer]]\nmedium = 'henyey_greenstein'\nalbedo = 0.8\nthickness = 0.5\ndensity = 8\n" +
        keys);
    Simulation simulation(stack, make_plan(stack), {0, 0, 1}, Estimator::analog,
                          CellGrid{2, 4, false}, 1);
    simulation.advance(200000);
    return reduce(simulation).uncollided[0];
  };
  // Light that arrives along the normal meets the stripe, a depth of 8 x 0.25, or nothing.
  const double expected = 0.75 + 0.25 * std::exp(-2.0), cropped = std::exp(-4.0);
  for (const double voxel : {1.0 / 16, 1.0}) {
    write(file("stripe.vdb"), {stripe(voxel)});
    const std::string grid = "grid = '" + file("stripe.vdb") + "'\nsize = [1, 1]\n";
    const Estimate whole = uncollided(grid + "voxels = [16, 16, 8]\n");
    EXPECT_NEAR(whole.value, expected, 5 * whole.standard_error) << voxel;
    // Without the key: the file's voxel size tells, or the crop is told of.
    const Estimate plain = uncollided(grid);
    EXPECT_NEAR(plain.value, voxel < 1 ? expected : cropped, 5 * plain.standard_error) << voxel;
  }
}

}  // namespace
}  // namespace lamella
