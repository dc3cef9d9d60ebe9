#include "compare/truth/lobe_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/request/errors.h"
#include "compare/truth/estimator_choice.h"
#include "phase/stack/single_scattering.h"
#include "volume/solver/answer_check.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

constexpr double kTolerance = 1e-4;  // of the solver: far below the interpolation's error
constexpr double kWorst = 1e-2;      // error beyond which walks are as good

struct Place {
  int node;
  double fraction;
};

Place place_of_mu(double mu) {
  constexpr int last = LobeTable::kMuNodes - 1;
  const double share = std::max(0.0, (mu - LobeTable::kLeastMu) / (1 - LobeTable::kLeastMu));
  const double x = std::min(std::sqrt(share), 1.0) * last;
  const int node = std::min(static_cast<int>(x), last - 1);
  return {node, x - node};
}

Place place_of_phi(double phi) {
  constexpr int last = LobeTable::kPhiNodes - 1;
  const double folded = phi > kPi ? 2 * kPi - phi : phi;
  const double x = std::clamp(folded / kPi, 0.0, 1.0) * last;
  const int node = std::min(static_cast<int>(x), last - 1);
  return {node, x - node};
}

double node_phi(int k) { return kPi * k / (LobeTable::kPhiNodes - 1); }

// Away from the limit: where both directions graze, single scattering has none.
Direction lifted(Direction w) {
  if (w.z >= LobeTable::kLeastMu) return w;
  return direction_from_mu_phi(LobeTable::kLeastMu, azimuth(w));
}

}  // namespace

double LobeTable::node_mu(int k) {
  const double x = static_cast<double>(k) / (kMuNodes - 1);
  return kLeastMu + (1 - kLeastMu) * x * x;
}

Rgb LobeTable::operator()(Direction wi, Direction wo) const {
  const Direction i = lifted(wi), o = lifted(wo);
  const SingleScattering first = single_scattering(stack_, i, o);
  double phi = azimuth(o) - azimuth(i);
  if (phi < 0) phi += 2 * kPi;
  const Place a = place_of_mu(i.z), b = place_of_mu(o.z), c = place_of_phi(phi);
  Rgb rest;
  for (int k = 0; k < 8; ++k) {
    const int x = k & 1, y = k >> 1 & 1, z = k >> 2;
    const double weight = (x ? a.fraction : 1 - a.fraction) * (y ? b.fraction : 1 - b.fraction) *
                          (z ? c.fraction : 1 - c.fraction);
    rest += weight * at(a.node + x, b.node + y, c.node + z);
  }
  return first.layers + first.substrate + rest;
}

std::optional<std::string> LobeTable::solve(const Stack& stack, double worst, const StopFlag* stop,
                                            const SolverReport& report) {
  DeterministicOptions options;
  options.tolerance = kTolerance;
  options.stop = stop;
  options.report = report;
  const DeterministicSolution solution = solve_deterministic(stack, options);
  if (auto reason = why_no_answer(solution.accuracy())) return reason;
  if (solution.accuracy().error > worst)
    return fmt::format("its error is {:.1e}", solution.accuracy().error);
  std::vector<double> mu;
  for (int k = 0; k < kMuNodes; ++k) mu.push_back(node_mu(k));
  const DeterministicField field = solution.field(mu, mu);
  for (int i = 0; i < kMuNodes; ++i)
    for (int o = 0; o < kMuNodes; ++o)
      for (int p = 0; p < kPhiNodes; ++p)
        at(i, o, p) = field
                          .multiple(static_cast<std::size_t>(i), static_cast<std::size_t>(o),
                                    kPi - node_phi(p))
                          .order[4];
  if (!std::all_of(values_.begin(), values_.end(),
                   [](const Rgb& f) { return std::isfinite(f.r + f.g + f.b); }))
    return "its numbers are not finite";
  source_ = fmt::format("adding and doubling, tolerance {:g}", kTolerance);
  return std::nullopt;
}

void LobeTable::walk(const TruthRequest& request, const StopFlag* stop) {
  std::vector<Direction> points;
  for (int o = 0; o < kMuNodes; ++o)
    for (int p = 0; p < kPhiNodes; ++p)
      points.push_back(direction_from_mu_phi(node_mu(o), node_phi(p)));
  const Plan plan = plan_of(request);
  for (int i = 0; i < kMuNodes; ++i) {
    Simulation simulation(request.stack, plan, direction_from_mu_phi(node_mu(i), 0), points,
                          request.seed);
    run(simulation, {.walks = request.effort.walks, .target_error = {}, .seconds = {}}, {}, stop);
    for (std::size_t j = 0; j < points.size(); ++j)
      for (int c = 0; c < 3; ++c) {
        const int channel = std::min(c, plan.channels - 1);
        const auto rest = [&](const BatchTally& b) {
          double sum = 0;
          for (int order = 1; order < kTallyOrders; ++order)
            sum +=
                b.f[static_cast<std::size_t>(order * plan.channels + channel) * points.size() + j];
          return sum;
        };
        at(i, static_cast<int>(j) / kPhiNodes, static_cast<int>(j) % kPhiNodes)[c] =
            batch_estimate(simulation.batches(), rest).value;
      }
  }
  source_ = fmt::format("{} next-event walks for each of {} incoming cosines", request.effort.walks,
                        kMuNodes);
}

LobeTable LobeTable::make(const TruthRequest& request, const StopFlag* stop,
                          const SolverReport& report) {
  LobeTable table;
  table.stack_ = request.stack;
  table.values_.resize(static_cast<std::size_t>(kMuNodes) * kMuNodes * kPhiNodes);
  check_estimator(request);
  const bool solvable = !why_not_deterministic(request.stack) && request.given.empty();
  const bool must = request.estimator == Estimator::deterministic;
  if (must || (solvable && !request.estimator)) {
    const double worst = must ? std::numeric_limits<double>::infinity() : kWorst;
    const auto reason = table.solve(request.stack, worst, stop, report);
    if (!reason) return table;
    if (must) refuse_answer(request.stack, *reason);
  }
  table.walk(request, stop);
  return table;
}

void check_preview(const std::string& what, const Stack& stack) {
  const char* found = !stack.is_symmetric_about_z() ? "a stack with a preferred azimuth"
                      : stack.grains()              ? "explicit geometry"
                      : stack.has_grid()            ? "a density grid"
                                                    : nullptr;
  if (found)
    throw UsageError(
        fmt::format("{} {}: found {}; allowed: homogeneous layers that are symmetric about z", what,
                    stack.name, found));
}

}  // namespace lamella
