#include "volume/result/run_bytes.h"

#include <gtest/gtest.h>

#include "volume/result/number_bytes.h"

namespace lamella {
namespace {

RunResult solved() {
  RunResult run;
  run.incident = {0.6, 0, 0.8};
  run.estimator = Estimator::deterministic;
  run.grid = {2, 4, true};
  run.channels = 3;
  run.seconds = 0.1;
  run.reflected.total[1] = {0.3, 1e-9};
  run.reflected.orders[3][2] = {1.0 / 3, 1e-17};
  run.reflected.lobes[Order::all] = {std::vector<double>(12, 0.1), std::vector<double>(12, 1e-5)};
  run.unresolved[0] = {1e-300, 0};
  run.accuracy.emplace();
  run.accuracy->limit = DeterministicLimit::time;
  run.accuracy->channel_modes = {3, 4, 5};
  run.accuracy->bytes = std::size_t{1} << 40;
  return run;
}

TEST(RunBytes, GiveBackEveryBit) {
  const std::string bytes = to_bytes(solved());
  const RunResult run = run_from_bytes(bytes);
  EXPECT_EQ(to_bytes(run), bytes);
  EXPECT_EQ(run.incident.z, 0.8);
  EXPECT_EQ(run.grid, (CellGrid{2, 4, true}));
  EXPECT_EQ(run.reflected.orders[3][2].value, 1.0 / 3);
  EXPECT_EQ(run.reflected.lobes[Order::all].standard_error, std::vector<double>(12, 1e-5));
  EXPECT_EQ(run.unresolved[0].value, 1e-300);
  EXPECT_EQ(run.accuracy->limit, DeterministicLimit::time);
  EXPECT_EQ(run.accuracy->bytes, std::size_t{1} << 40);
}

TEST(RunBytes, RefuseWhatIsCutOrMadeUp) {
  const std::string bytes = to_bytes(solved());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_THROW((void)run_from_bytes(std::string_view(bytes).substr(0, size)), DamagedBytes);
  EXPECT_THROW((void)run_from_bytes(bytes + "x"), DamagedBytes);
  const auto changed = [](const auto& change) {
    RunResult run = solved();
    change(run);
    return to_bytes(run);
  };
  EXPECT_THROW((void)run_from_bytes(changed([](auto& r) { r.channels = 2; })), DamagedBytes);
  EXPECT_THROW((void)run_from_bytes(changed([](auto& r) { r.grid.mu_cells = 1 << 30; })),
               DamagedBytes);
  EXPECT_THROW((void)run_from_bytes(changed([](auto& r) { r.accuracy.reset(); })), DamagedBytes);
  EXPECT_THROW((void)run_from_bytes(changed([](auto& r) { r.estimator = Estimator::analog; })),
               DamagedBytes);
  EXPECT_THROW((void)run_from_bytes(changed([](auto& r) { r.reflected.lobes[0].value = {1.0}; })),
               DamagedBytes);
}

}  // namespace
}  // namespace lamella
