#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <memory>

#include "compare/truth/lobe_table.h"
#include "volume/harmonics/harmonic_degrees.h"
#include "volume/harmonics/harmonic_solution.h"
#include "volume/solver/distinct_channels.h"

namespace lamella {

using Grid = HalfVectorGrid;

// For a picture: one degree, a step above the first one that is worth its time. Reflection is
// reciprocal here: the beam comes from where the viewer is.
void LobeTable::solve_in_harmonics(const TruthRequest& request, const StopFlag* stop) {
  constexpr std::size_t kSteps = 1;
  const std::size_t step = std::min(first_degree(stack_) + kSteps, std::size(kHarmonicDegrees) - 1);
  const int degree = kHarmonicDegrees[step];
  const DistinctChannels distinct = distinct_channels(stack_);
  std::vector<std::unique_ptr<HarmonicTransport>> transports;
  for (const int channel : distinct.channels)
    transports.push_back(std::make_unique<HarmonicTransport>(
        stack_, channel,
        resolution_of(degree, 1, Grid::kLeastMu, request.tolerance, request.isa, nullptr)));
  const HarmonicBasis& basis = transports.front()->basis();
  constexpr int kOneSide = Grid::kAlpha * Grid::kBeta;
  std::vector<Direction> wi(2 * kOneSide);
  Eigen::MatrixXd harmonics(basis.size(), 2 * kOneSide);
  for (int k = 0; k < kSectors; ++k) {
    if (mirror_sector(k)) continue;
    Sector& sector = tables_[k];
    for (int o = 0; o < Grid::kOut; ++o) {
      if (is_set(stop)) return;
      tbb::parallel_for(0, 2 * kOneSide, [&](int j) {
        wi[j] = incoming(sector, o, j % kOneSide / Grid::kBeta, j % Grid::kBeta, j / kOneSide);
        basis.values(wi[j], harmonics.col(j));
      });
      RestEnergy& energy = sector.energies.emplace_back();
      for (std::size_t n = 0; n < transports.size(); ++n) {
        const HarmonicSolution solution(*transports[n], outgoing(sector, o));
        const Eigen::VectorXd rest = solution.multiple(wi, harmonics);
        const HarmonicEnergies& e = solution.energies();
        const double total = e.up[0] + e.up[1] + e.up[2] + e.up[3];
        for (int c = 0; c < 3; ++c) {
          if (distinct.channel_of[c] != static_cast<int>(n)) continue;
          for (int j = 0; j < 2 * kOneSide; ++j)
            (j < kOneSide ? sector.rest : sector.right)
                .at(o, j % kOneSide / Grid::kBeta, j % Grid::kBeta)[c] = rest[j];
          energy.total[c] = total;
          energy.direct[c] = total - e.up[0];
          energy.total_error[c] = energy.direct_error[c] = std::abs(e.sum() - 1);
        }
      }
    }
  }
  source_ = fmt::format("spherical harmonics of degree {}", degree);
}

}  // namespace lamella
