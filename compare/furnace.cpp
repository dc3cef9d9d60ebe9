#include "compare/furnace.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numeric>
#include <vector>

namespace lamella {
namespace {

// (mean / standard error)^2 below which a mean over batches is too skew to be judged.
constexpr double kFewestEvents = 100;

double t_quantile(double level) {
  return boost::math::quantile(complement(boost::math::students_t(kBatches - 1.0), level / 2));
}

}  // namespace

std::string to_text(FurnaceVerdict verdict) {
  switch (verdict) {
    case FurnaceVerdict::pass:
      return "pass";
    case FurnaceVerdict::fail:
      return "fail";
    case FurnaceVerdict::inconclusive:
      break;
  }
  return "inconclusive";
}

FurnaceRun judge_furnace(const Simulation& simulation, bool white, double level) {
  FurnaceRun furnace;
  furnace.run = reduce(simulation);
  const RunResult& run = furnace.run;
  const CellTargets& targets = simulation.targets();
  const std::size_t count = targets.count();
  const double solid_angle = targets.grid.projected_solid_angle();
  const double t = t_quantile(level);
  for (int c = 0; c < run.channels; ++c) {
    // The difference of the estimator and the ledger per batch: what both share cancels.
    const auto seen = [&](const BatchTally& b) {
      double sum = b.energy.uncollided[c] + b.energy.specular_up[c] + b.energy.specular_down[c];
      for (int o = 0; o < kTallyOrders; ++o)
        for (std::size_t k = 0; k < count; ++k)
          sum += solid_angle * b.f[(static_cast<std::size_t>(o) * run.channels + c) * count + k];
      return sum;
    };
    furnace.energy[c] = batch_estimate(simulation.batches(), seen);
    const double unresolved = run.unresolved[c].value;
    furnace.expected[c] = 1 - run.absorbed[c].value - unresolved;
    const Estimate defect = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
      return seen(b) + b.energy.absorbed[c] + b.energy.unresolved[c] - static_cast<double>(b.walks);
    });
    const double noise = t * defect.standard_error + 1e-12;
    // A sharp lobe that few walks hit: so few events that their mean is far from normal.
    const double error = furnace.energy[c].standard_error;
    const bool too_few =
        furnace.energy[c].value * furnace.energy[c].value < kFewestEvents * error * error;
    FurnaceVerdict verdict = FurnaceVerdict::pass;
    if ((std::abs(defect.value) > noise && !too_few) || (white && run.absorbed[c].value > 1e-12))
      verdict = FurnaceVerdict::fail;
    else if (unresolved > noise || too_few)
      verdict = FurnaceVerdict::inconclusive;
    if (verdict == FurnaceVerdict::fail || furnace.verdict == FurnaceVerdict::pass)
      furnace.verdict = verdict;
  }
  return furnace;
}

RadianceCheck check_radiance(const Stack& stack, const Plan& plan, Direction w, std::uint64_t walks,
                             std::uint64_t seed, const std::atomic<bool>* interrupted) {
  constexpr int kNodes = 16, kAzimuths = 16;
  using Rule = boost::math::quadrature::gauss<double, kNodes>;
  w = with_grazing_limit(w);
  RadianceCheck check;
  check.w = w;
  const double s = stack.one_sidedness() * (w.z > 0 ? 1 : -1);
  const StopRule rule{.walks = std::max<std::uint64_t>(walks / (2 * kNodes + 1), kBatches),
                      .target_error = {},
                      .seconds = {}};

  Simulation along(stack, plan, w, Estimator::analog, CellGrid{1, 1, false}, seed);
  lamella::run(along, rule, {}, interrupted);
  const Estimate scattered = batch_estimate(along.batches(), [&](const BatchTally& b) {
    double sum = 0;
    for (int o = 0; o < kTallyOrders; ++o) sum += (w.z > 0 ? b.energy.down : b.energy.up)[o][0];
    return sum;
  });
  check.predicted = 1 + std::expm1(s) * (scattered.value + stack.uncollided(w));
  check.predicted_error = std::abs(std::expm1(s)) * scattered.standard_error;

  // L(w) = integral of f(w_i -> w) |mu_i| dw_i over both hemispheres, plus what comes straight
  // through; in mu_i^2, where equal steps have equal weight. The azimuth is averaged by turning w:
  // equal steps, which are spectrally accurate around the circle, of half of it by symmetry.
  std::vector<Direction> turned;
  for (int k = 0; k < kAzimuths; ++k)
    turned.push_back(direction_from_mu_phi(w.z, kPi * (k + 0.5) / kAzimuths));
  double variance = 0;
  for (const double side : {1.0, -1.0})
    for (int k = 0; k < kNodes; ++k) {
      const int half = k / 2;
      const double x = (k % 2 ? 1 : -1) * Rule::abscissa()[half];
      const double mu = std::sqrt((x + 1) / 2), weight = Rule::weights()[half] / 2;
      Simulation node(stack, plan, direction_from_mu_phi(side * mu, 0), turned, seed + k + 1);
      lamella::run(node, rule, {}, interrupted);
      const Estimate f = batch_estimate(node.batches(), [](const BatchTally& b) {
        return std::accumulate(b.f.begin(), b.f.end(), 0.0) / kAzimuths;
      });
      check.measured += kPi * weight * f.value;
      variance += kPi * weight * f.standard_error * kPi * weight * f.standard_error;
    }
  check.measured += stack.uncollided(-w);
  check.standard_error = std::sqrt(variance);
  return check;
}

}  // namespace lamella
