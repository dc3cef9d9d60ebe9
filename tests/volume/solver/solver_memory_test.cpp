#include <gtest/gtest.h>

#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

TEST(SolverMemory, EndsAtTheLimitAndTellsIt) {
  for (const std::string& medium : {kSphere, henyey_greenstein(0.7)}) {
    const Stack stack = stack_of(layer(medium, 0.9, 4));
    std::size_t before = 0;
    for (const std::size_t limit : {std::size_t{1} << 18, std::size_t{1} << 20}) {
      const DeterministicSolution s =
          solve_deterministic(stack, {.tolerance = 1e-12, .max_bytes = limit});
      EXPECT_FALSE(s.accuracy().reached) << medium;
      EXPECT_EQ(s.accuracy().limit, DeterministicLimit::memory) << medium;
      EXPECT_LE(s.accuracy().bytes, limit) << medium;
      EXPECT_GT(s.accuracy().bytes, before) << medium;
      before = s.accuracy().bytes;
    }
  }
}

}  // namespace
}  // namespace lamella
