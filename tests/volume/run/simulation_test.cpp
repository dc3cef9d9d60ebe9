#include "volume/run/simulation.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "phase/stack/builtin_stacks.h"
#include "tests/volume/run/tally_sums.h"

namespace lamella {
namespace {

std::vector<double> sums_with_threads(int threads, Estimator estimator,
                                      const std::vector<std::uint64_t>& checkpoints) {
  const Stack stack = load_stack("spongecake_plant");
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
  tbb::task_arena arena(threads);
  return arena.execute([&] {
    Simulation simulation(stack, make_plan(stack), direction_from_degrees(60, 30), estimator,
                          CellGrid{4, 8, false}, 7);
    for (const std::uint64_t walks : checkpoints) simulation.advance(walks);
    return testing::tally_sums(simulation);
  });
}

TEST(Simulation, IsBitIdenticalForOneTwoAndSevenThreads) {
  for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
    const auto one = sums_with_threads(1, estimator, {5000});
    EXPECT_EQ(one, sums_with_threads(2, estimator, {5000}));
    EXPECT_EQ(one, sums_with_threads(7, estimator, {5000}));
  }
}

TEST(Simulation, IsBitIdenticalWhateverTheCheckpoints) {
  const auto once = sums_with_threads(2, Estimator::analog, {5000});
  EXPECT_EQ(once, sums_with_threads(2, Estimator::analog, {1, 130, 131, 2048, 4999, 5000}));
}

}  // namespace
}  // namespace lamella
