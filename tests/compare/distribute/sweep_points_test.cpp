#include "compare/distribute/sweep_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compare/request/errors.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

Stack slab() {
  return parse_stack("[[layer]]\nmedium = \"henyey_greenstein\"\nthickness = 1\n", "test", "test");
}

TEST(SweepPoints, CountWithTheLastAxisRunningFastest) {
  const SweepPoints points(slab(), {parse_sweep_axis("layer.0.thickness=1,2"),
                                    parse_sweep_axis("layer.0.g=0,0.25,0.5")});
  EXPECT_EQ(points.count(), 6U);
  EXPECT_THAT(points.at(0), testing::ElementsAre(0, 0));
  EXPECT_THAT(points.at(1), testing::ElementsAre(0, 1));
  EXPECT_THAT(points.at(4), testing::ElementsAre(1, 1));
  EXPECT_EQ(points.values(4), "layer.0.thickness = 2 layer.0.g = 0.25");
  EXPECT_EQ(SweepPoints::name(4), "0004");
  EXPECT_NO_THROW(points.check());
}

TEST(SweepPoints, HaveStackFilesOfTheirOwn) {
  const SweepPoints points(slab(), {parse_sweep_axis("layer.0.thickness=1,2")});
  const Stack second = parse_stack(points.toml(1), "test", "second");
  EXPECT_EQ(second.layers[0].thickness, 2);
}

TEST(SweepPoints, AreRefusedWhereTheyAreTooManyOrLeadNowhere) {
  const SweepAxis axis = parse_sweep_axis("layer.0.thickness=1:2:200");
  EXPECT_THROW(SweepPoints(slab(), {axis, axis}), UsageError);
  EXPECT_THROW(SweepPoints(slab(), {parse_sweep_axis("layer.1.g=0,1")}).check(), UsageError);
  EXPECT_THROW(SweepPoints(slab(), {parse_sweep_axis("layer.0.thickness=-1,1")}).check(),
               StackFileError);
}

}  // namespace
}  // namespace lamella
