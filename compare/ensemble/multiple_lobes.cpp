#include "compare/ensemble/multiple_lobes.h"

#include <algorithm>
#include <cmath>

#include "volume/plan/plan.h"
#include "volume/run/sample_run.h"

namespace lamella {

double MultipleLobes::relative_noise() const {
  double sum = 0, noise = 0;
  for (std::size_t k = 0; k < value.size(); ++k) {
    sum += static_cast<double>(value[k]) * value[k];
    noise += variance[k];
  }
  return sum > 0 ? std::sqrt(noise / sum) : 0;
}

MultipleLobes multiple_lobes(const Stack& stack, const std::vector<Direction>& incident,
                             const CellGrid& grid, std::uint64_t walks, std::uint64_t seed,
                             const StopFlag* stop) {
  Plan plan = make_plan(stack, {.max_order = kMaxOrder, .thinning = Thinning{}});
  plan.isa = isa_from_text("auto");
  MultipleLobes lobes{
      .grid = grid, .incident = incident, .walks = walks, .value = {}, .variance = {}};
  const std::size_t cells = lobes.cells_per_direction();
  const double n = static_cast<double>(walks), area = grid.projected_solid_angle();
  std::vector<double> sum(3 * cells), squares(3 * cells);
  for (std::size_t d = 0; d < incident.size(); ++d) {
    const SampleRun run(stack, plan, incident[d], seed + ((d + 1) << 40));
    std::fill(sum.begin(), sum.end(), 0.0);
    std::fill(squares.begin(), squares.end(), 0.0);
    const double phi = azimuth(incident[d]);
    for (std::uint64_t chunk = 0; chunk < run.chunks(walks) && !is_set(stop); ++chunk) {
      const WalkSamples rows = run.take(chunk, walks);
      for (std::size_t k = 0; k < rows.count(); ++k) {
        if (rows.order[k] < 2 || std::abs(rows.side[k]) != 1) continue;
        const float* w = &rows.wo[3 * k];
        double turned = std::atan2(w[1], w[0]) - phi;
        turned -= 2 * kPi * std::floor(turned / (2 * kPi));
        const std::size_t cell = grid.cell(static_cast<double>(w[2]) * w[2], turned) +
                                 (rows.side[k] == 1 ? 0 : grid.cells());
        for (int c = 0; c < 3; ++c) {
          const double weight = rows.weight[rows.channels * k + (rows.channels == 3 ? c : 0)];
          sum[3 * cell + c] += weight;
          squares[3 * cell + c] += weight * weight;
        }
      }
    }
    for (std::size_t k = 0; k < sum.size(); ++k) {
      lobes.value.push_back(static_cast<float>(sum[k] / (n * area)));
      lobes.variance.push_back(static_cast<float>(std::max(squares[k] - sum[k] * sum[k] / n, 0.0) /
                                                  (n * n * area * area)));
    }
  }
  return lobes;
}

}  // namespace lamella
