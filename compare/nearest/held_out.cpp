#include "compare/nearest/held_out.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>

#include "phase/math/degrees.h"

namespace lamella {
namespace {

// As fits have them at last.
constexpr int kPoints = 4;

}  // namespace

double held_out_error(const FitTarget& target, std::span<const double> means,
                      std::span<const double> errors) {
  struct Sums {
    double off = 0, truth = 0;
  };
  std::map<std::size_t, Sums> runs;
  for (std::size_t l = 0; l < target.lobes.size(); ++l) {
    Sums& sums = runs[target.lobes[l].run];
    for (std::size_t k = l * target.block(); k < (l + 1) * target.block(); ++k) {
      const double t = target.value[k], d = means[k] - t;
      const double noise = target.is_bounded ? 0 : target.error[k] * target.error[k];
      sums.off += d * d - noise - (errors.empty() ? 0 : errors[k] * errors[k]);
      sums.truth += t * t - noise;
    }
  }
  double sum = 0;
  for (const auto& [run, s] : runs) sum += s.truth > 0 ? std::max(s.off, 0.0) / s.truth : 0;
  return std::sqrt(sum / static_cast<double>(runs.size()));
}

std::vector<Direction> held_out_directions(std::vector<Direction> fitted) {
  std::sort(fitted.begin(), fitted.end(), [](Direction a, Direction b) { return a.z > b.z; });
  std::vector<Direction> others;
  const auto half_way = [&](double from, double to, Direction at) {
    others.push_back(direction_from_degrees((from + to) / 2, phi_degrees(at)));
  };
  for (std::size_t k = 0; k + 1 < fitted.size(); ++k) {
    const double from = theta_degrees(fitted[k]), to = theta_degrees(fitted[k + 1]);
    if (to - from > 1 && (from < 90) == (to < 90)) half_way(from, to, fitted[k]);
  }
  if (others.empty())
    for (const Direction w : fitted) {
      const double theta = theta_degrees(w);
      if (std::abs(theta - 90) > 1) half_way(theta, 90, w);
    }
  return others;
}

void judge_held_out(NearestModels& nearest, const TargetTruths& others) {
  FitTarget target;
  try {
    target = fit_target(others.truths, nearest.transmitted);
  } catch (const std::invalid_argument&) {
    return;
  }
  nearest.held_out = {};
  for (const Truth& truth : others.truths)
    nearest.held_out.directions.push_back(truth.run.incident);
  const std::vector<BoundModel> models = bound_models(nearest);
  for (const BoundModel& model : models)
    nearest.held_out.relative_rmse.push_back(held_out_error(
        target,
        cell_means(*model.model, target, cell_points(target, kPoints), others.request.isa)));
}

}  // namespace lamella
