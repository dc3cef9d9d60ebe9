#include "compare/truth/texel_mean.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "compare/request/errors.h"
#include "compare/request/run_keeper.h"
#include "compare/request/stopwatch.h"
#include "compare/truth/estimator_choice.h"
#include "compare/truth/solved_texels.h"

namespace lamella {
namespace {

Plan plan_of_texel(const TruthRequest& request, const Stack& texel) {
  TruthRequest of_texel;
  of_texel.stack = texel;
  of_texel.limits = request.limits;
  // The batches of all texels are summed: no closed form is that of their sum.
  of_texel.limits.order_one = OrderOne::walked;
  of_texel.isa = request.isa;
  return plan_of(of_texel);
}

// The texel's own layers, and everything else as all texels need it.
Plan widened(Plan plan, const Plan& all) {
  plan.channels = all.channels;
  plan.folded = all.folded;
  plan.boundaries = all.boundaries;
  plan.rough_boundaries = all.rough_boundaries;
  plan.transmits = all.transmits;
  plan.max_order = all.max_order;
  plan.thinning = all.thinning;
  return plan;
}

void add(EnergySums::Channels& to, const EnergySums::Channels& from) {
  for (std::size_t c = 0; c < to.size(); ++c) to[c] += from[c];
}

void add(BatchTally& to, const BatchTally& from) {
  to.walks += from.walks;
  to.collisions += from.collisions;
  to.holes += from.holes;
  for (std::size_t o = 0; o < to.energy.up.size(); ++o) {
    add(to.energy.up[o], from.energy.up[o]);
    add(to.energy.down[o], from.energy.down[o]);
  }
  const EnergySums& e = from.energy;
  add(to.energy.zero_up, e.zero_up);
  add(to.energy.zero_down, e.zero_down);
  add(to.energy.specular_up, e.specular_up);
  add(to.energy.specular_down, e.specular_down);
  add(to.energy.uncollided, e.uncollided);
  add(to.energy.absorbed, e.absorbed);
  add(to.energy.unresolved, e.unresolved);
  add(to.energy.lost, e.lost);
  add(to.energy.thinned, e.thinned);
  to.f.resize(std::max(to.f.size(), from.f.size()));
  for (std::size_t k = 0; k < from.f.size(); ++k) to.f[k] += from.f[k];
}

std::uint64_t whole_batches(double walks) {
  const double batches = std::ceil(walks / kBatches);
  return kBatches * static_cast<std::uint64_t>(std::max(1.0, batches));
}

}  // namespace

void check_texel_mean(const TruthRequest& request) {
  const auto refuse = [](const std::string& found) {
    throw UsageError(fmt::format(
        "--at mean: found {}; allowed: the solver, or a number of walks or a time, through "
        "homogeneous layers (--at U,V takes one place)",
        found));
  };
  for (const Stack& texel : request.texels) {
    if (texel.grains()) refuse("explicit geometry");
    if (texel.has_grid()) refuse("a density grid");
  }
  const std::vector<std::size_t> first = first_equals(request.texels);
  for (std::size_t k = 0; k < first.size(); ++k)
    if (first[k] == k) check_estimator(request_of_texel(request, k, 1));
}

TruthRequest request_of_texel(const TruthRequest& request, std::size_t texel, double share) {
  TruthRequest of_texel = request;
  of_texel.stack = request.texels[texel];
  of_texel.texels.clear();
  of_texel.texel_ends.clear();
  if (!request.texel_ends.empty()) of_texel.solver_end = request.texel_ends[texel];
  if (of_texel.effort.seconds) *of_texel.effort.seconds *= share;
  return of_texel;
}

Plan plan_of_texel(const TruthRequest& request, std::size_t texel, const Plan& all) {
  return widened(plan_of_texel(request, request.texels[texel]), all);
}

Plan texel_plan(const TruthRequest& request) {
  Plan all = plan_of_texel(request, request.texels.front());
  for (const Stack& texel : request.texels) {
    const Plan plan = plan_of_texel(request, texel);
    all.channels = std::max(all.channels, plan.channels);
    all.folded = all.folded && plan.folded;
    all.boundaries = all.boundaries || plan.boundaries;
    all.rough_boundaries = all.rough_boundaries || plan.rough_boundaries;
    all.transmits = all.transmits || plan.transmits;
    all.max_order = std::max(all.max_order, plan.max_order);
    if (!all.thinning.is_on()) all.thinning = plan.thinning;
  }
  return all;
}

namespace {

// The walks of the texels whose batches are in the simulation's range, added to these batches.
// Whether all texels had theirs.
bool walk_into(Simulation& all, const TruthRequest& request, std::uint64_t walks,
               const std::function<std::unique_ptr<Simulation>(std::size_t)>& simulation_of,
               const RunMonitor& monitor) {
  const std::size_t count = request.texels.size();
  const BatchRange range = all.range();
  std::vector<BatchTally> batches(kBatches);
  std::uint64_t done = 0;
  std::size_t k = 0;
  for (; k < count && !(monitor.is_stopped() && k > 0); ++k) {
    const int own = static_cast<int>(k % kBatches);
    done += walks;
    if (own < range.first || own >= range.end) continue;
    const auto simulation = simulation_of(k);
    simulation->advance(walks);
    for (const BatchTally& batch : simulation->batches()) add(batches[k % kBatches], batch);
    if (monitor.progress)
      monitor.progress(fmt::format("texel {} of {}", k + 1, count), {done, walks * count, 0});
  }
  const std::size_t size = all.batches().front().f.size();
  for (int b = 0; b < kBatches; ++b) {
    batches[static_cast<std::size_t>(b)].f.resize(size);
    all.restore(b, std::move(batches[static_cast<std::size_t>(b)]), "");
  }
  all.restore_walks(done);
  return k == count;
}

// Rounds of 1, 2, 4, ... walks per batch and texel, `most` per texel at most, until one of them
// reaches the target; a round that is stopped leaves the one before it.
TexelWalks walk_to_target(const TruthRequest& request, double target, std::uint64_t most,
                          const std::function<std::unique_ptr<Simulation>(std::size_t)>& simulation,
                          const RunMonitor& monitor) {
  TexelWalks reached{};
  for (std::uint64_t walks = std::min<std::uint64_t>(kBatches, most);;
       walks = std::min(2 * walks, most)) {
    auto round = simulation(0);
    const bool whole = walk_into(*round, request, walks, simulation, monitor);
    if (!whole && reached.batches) {
      reached.is_whole = false;
      return reached;
    }
    reached.is_whole = whole;
    const double before = reached.error, error = largest_relative_error(*round);
    reached.batches = std::move(round);
    reached.error = error;
    // error^2 is what texels leave plus what walks do, and the latter half of what it was.
    reached.of_texels =
        before > 0 ? std::sqrt(std::max(0.0, 2 * error * error - before * before)) : 0;
    if (!whole || error <= target || walks == most) return reached;
  }
}

}  // namespace

TexelWalks walk_texels(const TruthRequest& request, const Plan& plan, Direction wi,
                       Estimator estimator, StopRule rule, const RunMonitor& monitor) {
  const std::vector<Stack>& texels = request.texels;
  const auto simulation_of = [&](std::size_t k) {
    // Seeds of their own, far apart: walks of neighbouring texels share no numbers.
    const std::uint64_t seed = request.seed + 0x9E3779B97F4A7C15ULL * k;
    return std::make_unique<Simulation>(texels[k], plan_of_texel(request, k, plan), wi, estimator,
                                        request.cells, seed);
  };
  auto all = simulation_of(0);
  if (monitor.keeper)
    if (const RunKeeper::Found found = monitor.keeper->begin(*all); found.done)
      return {std::move(all), found.seconds};
  TexelWalks walked{};
  const auto count = static_cast<double>(texels.size());
  std::uint64_t walks = whole_batches(static_cast<double>(rule.walks) / count);
  const double seconds = wall_seconds_of([&] {
    if (rule.seconds) {
      const auto pilot = simulation_of(texels.size() / 2);
      StopRule share = rule;
      share.walks = walks;
      // Rounds take as long again as the last of them.
      share.seconds = *rule.seconds / count / (rule.target_error ? 2 : 1);
      share.target_error.reset();
      run(*pilot, share, {}, monitor.stop);
      walks = std::min(walks, whole_batches(static_cast<double>(pilot->walks())));
    }
    if (rule.target_error) {
      walked = walk_to_target(request, *rule.target_error, walks, simulation_of, monitor);
    } else {
      walked.is_whole = walk_into(*all, request, walks, simulation_of, monitor);
      walked.batches = std::move(all);
    }
  });
  walked.seconds = seconds;
  if (monitor.keeper && walked.is_whole) monitor.keeper->end(*walked.batches, seconds);
  return walked;
}

}  // namespace lamella
