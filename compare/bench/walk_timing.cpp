#include "compare/bench/walk_timing.h"

#include <cmath>

namespace lamella {

double mean_target_error(const Simulation& simulation, int targets) {
  double sum = 0;
  int lit = 0;
  const std::size_t stride =
      simulation.batches().front().f.size() / simulation.plan().order_slots();
  for (int j = 0; j < targets; ++j) {
    const Estimate e = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
      double f = 0;
      for (int o = 0; o < simulation.plan().order_slots(); ++o) f += b.f[o * stride + j];
      return f;
    });
    if (e.value <= 0) continue;
    sum += e.standard_error / e.value;
    ++lit;
  }
  return lit ? sum / lit : std::nan("");
}

double core_frequency() {
  constexpr int kChain = 3'000'000;
  std::uint64_t x = 3;
  const double seconds = seconds_of([&] {
    for (int k = 0; k < kChain; ++k) {
      x *= 0x9E3779B97F4A7C15u;
      asm volatile("" : "+r"(x));
    }
  });
  return 3 * kChain / seconds;
}

}  // namespace lamella
