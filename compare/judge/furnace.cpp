#include "compare/judge/furnace.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <vector>

#include "compare/request/run_keeper.h"
#include "phase/random/random.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

// (mean / standard error)^2 below which a mean over batches is too skew to be judged.
constexpr double kFewestEvents = 100;
FurnaceVerdict verdict_of(const FurnaceRun& f) {
  if (f.loses || f.gains) return FurnaceVerdict::fail;
  return f.is_wide || f.is_cut || f.has_few_events ? FurnaceVerdict::inconclusive
                                                   : FurnaceVerdict::pass;
}

// The energy of the cells, which are integrals over directions of their own, against the absorption
// that the solver added up on its nodes.
FurnaceRun judge_bounded(const RunResult& run, bool white) {
  FurnaceRun furnace;
  furnace.run = run;
  for (int c = 0; c < run.channels; ++c) {
    double energy = run.uncollided[c].value, bound = run.absorbed[c].standard_error;
    bound += run.lost[c].standard_error;
    for (const SideResult* side : {&run.reflected, &run.transmitted}) {
      if (!side->lobes[Order::all].value.empty()) energy += side->specular[c].value;
      const LobeEstimate& all = side->lobes[Order::all];
      const std::size_t cells = all.value.size() / run.channels;
      if (all.value.empty()) {  // the depth of a half space has no cells
        energy += side->total[c].value;
        bound += side->total[c].standard_error;
      }
      for (std::size_t k = c * cells; k < (c + 1) * cells; ++k) {
        energy += run.grid.projected_solid_angle() * all.value[k];
        bound += run.grid.projected_solid_angle() * all.standard_error[k];
      }
    }
    furnace.energy[c] = {energy, bound};
    const double missing = run.absorbed[c].value + run.lost[c].value;
    furnace.expected[c] = 1 - missing;
    const double defect = energy - furnace.expected[c], noise = bound + 1e-12;
    furnace.gains = furnace.gains || defect > noise;
    furnace.loses = furnace.loses || defect < -noise || (white && missing > noise);
    furnace.is_wide = furnace.is_wide || !(bound <= kWidestFurnaceError);
  }
  furnace.verdict = verdict_of(furnace);
  return furnace;
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

std::string loss_or_gain(bool loses, bool gains) {
  return loses ? gains ? "both" : "loss" : gains ? "gain" : "none";
}

double furnace_quantile(double level) {
  return boost::math::quantile(complement(boost::math::students_t(kBatches - 1.0), level / 2));
}

FurnaceRun judge_furnace(const RunResult& run, const Simulation* batches, bool white,
                         double level) {
  if (!batches) return judge_bounded(run, white);
  const Simulation& simulation = *batches;
  FurnaceRun furnace;
  furnace.run = run;
  const CellTargets& targets = simulation.targets();
  const std::size_t count = targets.count();
  const double solid_angle = targets.grid.projected_solid_angle();
  const double t = furnace_quantile(level);
  // A closed form's sampler gives weights that are the albedo in the mean only.
  const bool weighs = simulation.stack().substrate && simulation.stack().substrate->law;
  for (int c = 0; c < run.channels; ++c) {
    // The difference of the estimator and the ledger per batch: what both share cancels.
    const auto seen = [&](const BatchTally& b) {
      double sum = b.energy.uncollided[c] + b.energy.specular_up[c] + b.energy.specular_down[c];
      for (int o = 0; o < simulation.plan().order_slots(); ++o)
        for (std::size_t k = 0; k < count; ++k)
          sum += solid_angle * b.f[(static_cast<std::size_t>(o) * run.channels + c) * count + k];
      return sum;
    };
    furnace.energy[c] = batch_estimate(simulation.batches(), seen);
    const double unresolved = run.unresolved[c].value;
    furnace.expected[c] =
        1 - run.absorbed[c].value - unresolved - run.lost[c].value - run.thinned[c].value;
    const Estimate defect = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
      return seen(b) + b.energy.absorbed[c] + b.energy.unresolved[c] + b.energy.lost[c] +
             b.energy.thinned[c] - static_cast<double>(b.walks);
    });
    const double noise = t * defect.standard_error + 1e-12;
    // A sharp lobe that few walks hit: so few events that their mean is far from normal.
    const double error = furnace.energy[c].standard_error;
    const bool too_few =
        furnace.energy[c].value * furnace.energy[c].value < kFewestEvents * error * error;
    const double lost = run.absorbed[c].value + run.lost[c].value -
                        (weighs ? t * run.absorbed[c].standard_error : 0);
    furnace.gains = furnace.gains || (defect.value > noise && !too_few);
    furnace.loses = furnace.loses || (defect.value < -noise && !too_few) || (white && lost > 1e-12);
    furnace.is_cut = furnace.is_cut || unresolved > noise;
    furnace.has_few_events = furnace.has_few_events || too_few;
    furnace.is_wide = furnace.is_wide || !(error <= kWidestFurnaceError);
  }
  furnace.verdict = verdict_of(furnace);
  return furnace;
}

RadianceCheck check_radiance(const Stack& stack, const Plan& plan, Direction w, std::uint64_t walks,
                             std::uint64_t seed, const RunMonitor& monitor) {
  // Rings are wider than the strata of the light: what is seen on one, as a function of where the
  // light comes from, is at least as wide as it, however narrow the lobes are.
  constexpr int kRings = 16, kStrata = 32, kDraws = 2, kNodes = 4;
  using Rule = boost::math::quadrature::gauss<double, kNodes>;
  w = with_grazing_limit(w);
  RadianceCheck check;
  check.w = w;
  const double s = stack.one_sidedness() * (w.z > 0 ? 1 : -1);
  const StopRule rule{
      .walks = std::max<std::uint64_t>(walks / (2 * kStrata * kDraws + kNodes), kBatches),
      .target_error = {},
      .seconds = {}};
  const int ring = std::min(static_cast<int>((1 - w.z * w.z) * kRings), kRings - 1);
  const double lowest = 1 - (ring + 1.0) / kRings;

  // Light that enters along the ring's directions, in mu^2, where equal steps have equal weight.
  double predicted_variance = 0;
  for (int k = 0; k < kNodes; ++k) {
    const double x = (k % 2 ? 1 : -1) * Rule::abscissa()[k / 2];
    const double mu2 = lowest + (x + 1) / 2 / kRings, weight = Rule::weights()[k / 2] / 2;
    const Direction v = direction_from_mu_phi(std::copysign(std::sqrt(mu2), w.z), 0);
    Simulation along(stack, plan, v, Estimator::analog, CellGrid{1, 1, false}, seed + k);
    run_kept(along, rule, {}, monitor);
    const Estimate scattered = batch_estimate(along.batches(), [&](const BatchTally& b) {
      double sum = 0;
      for (int o = 0; o < kTallyOrders; ++o) sum += (w.z > 0 ? b.energy.down : b.energy.up)[o][0];
      return sum;
    });
    check.predicted += weight * (1 + std::expm1(s) * (scattered.value + stack.uncollided(v)));
    const double error = weight * std::expm1(s) * scattered.standard_error;
    predicted_variance += error * error;
    check.measured += weight * stack.uncollided(-v);
  }
  check.predicted_error = std::sqrt(predicted_variance);

  // L = integral of f(w_i -> ring) |mu_i| dw_i over both hemispheres, plus what comes straight
  // through: w_i drawn in strata of mu_i^2, w_o all over the ring by every walk.
  double variance = 0;
  std::uint64_t draw = 0;
  for (const bool above : {true, false})
    for (int k = 0; k < kStrata; ++k) {
      std::array<double, kDraws> f{};
      for (double& value : f) {
        RandomStream stream(seed, draw, StreamPurpose::measure);
        const double mu = std::sqrt((k + stream.uniform()) / kStrata);
        Simulation node(stack, plan, direction_from_mu_phi(above ? mu : -mu, 0),
                        Estimator::next_event, CellGrid{kRings, 1, false}, seed + kNodes + draw);
        run_kept(node, rule, {}, monitor);
        ++draw;
        const auto target = static_cast<std::size_t>(target_of(node.targets(), w.z > 0, ring));
        const std::size_t count = node.targets().count();
        value = batch_estimate(node.batches(), [&](const BatchTally& b) {
                  double sum = 0;
                  for (int o = 0; o < kTallyOrders; ++o)
                    sum += b.f[static_cast<std::size_t>(o) * plan.channels * count + target];
                  return sum;
                }).value;
      }
      const double weight = kPi / kStrata;
      check.measured += weight * (f[0] + f[1]) / 2;
      // Of the mean of two draws: half of their difference, squared.
      variance += weight * weight * (f[0] - f[1]) * (f[0] - f[1]) / 4;
    }
  check.standard_error = std::sqrt(variance);
  return check;
}

RadianceCheck check_radiance(const DeterministicSolution& solution, Direction w) {
  w = with_grazing_limit(w);
  RadianceCheck check;
  check.w = w;
  const Stack& stack = solution.stack();
  const double along[] = {w.z};
  const DeterministicEnergies entering = solution.energies(along)[0];
  const double node_error = solution.accuracy().node_error + solution.accuracy().second_error;
  const double through = entering.transmitted[Order::all].r + entering.uncollided.r;
  const double factor = std::expm1(stack.one_sidedness() * (w.z > 0 ? 1 : -1));
  check.predicted = 1 + factor * through;
  check.predicted_error =
      std::abs(factor) * (node_error * through + std::abs(entering.sum().r - 1));

  // L(w) = 2 pi times the integral of the mean of f over the azimuth times |mu_i|, from both sides.
  double before = 0;
  for (const int nodes : {24, 32}) {
    const Quadrature rule = grazing_quadrature(nodes);
    std::vector<double> mu_i(rule.points.begin(), rule.points.end());
    for (int k = 0; k < nodes; ++k) mu_i.push_back(-mu_i[k]);
    const DeterministicField field = solution.field(mu_i, along);
    before = check.measured;
    check.measured = stack.uncollided(-w);
    for (std::size_t k = 0; k < mu_i.size(); ++k)
      check.measured += 2 * kPi * rule.weights[static_cast<Eigen::Index>(k % nodes)] *
                        std::abs(mu_i[k]) * field.mean(0, k, 0);
  }
  check.standard_error = std::abs(check.measured - before) + node_error * check.measured;
  return check;
}

}  // namespace lamella
