#include "compare/judge/model_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <chrono>
#include <cmath>

#include "compare/judge/model_furnace.h"
#include "compare/judge/statistics.h"
#include "compare/judge/value_checks.h"
#include "compare/judge/value_noise.h"
#include "phase/math/degrees.h"

namespace lamella {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kFalseAlarms = 1e-3;
// Share of the time that draws of one direction may take, and quadratures of one direction.
constexpr double kDrawShare = 0.02, kQuadratureShare = 0.05;
constexpr double kLongestQuadrature = 2;
constexpr std::uint64_t kFewestSamples = 256;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::vector<Direction> angles_of(const ModelCheckSettings& settings) {
  std::vector<double> thetas{0, 60, 90};
  if (!settings.few_angles) thetas = {0, 30, 60, 80, 89, 90};
  if (settings.transmits) thetas.push_back(135);
  std::vector<Direction> list;
  for (const double theta : thetas)
    list.push_back(with_grazing_limit(direction_from_degrees(theta, 20)));
  return list;
}

void check_energy(const CheckedModel& m, Direction wi, CheckLine& line) {
  const auto told = [&](std::string text) {
    return CheckCase{
        .text = std::move(text), .parameters = m.request, .wi = wi, .wo = std::nullopt};
  };
  try {
    const ModelFurnace furnace = judge_model_furnace(m.model, wi, true, kFurnaceTolerance);
    if (furnace.verdict == FurnaceVerdict::inconclusive) ++line.undecided;
    int most = 0;
    for (int c = 1; c < 3; ++c)
      if (furnace.energy[c] > furnace.energy[most]) most = c;
    const double energy = furnace.energy[most], error = furnace.error[most];
    // The furnace's verdict decides: what is above the tolerance may be the energy's own error.
    const double allowed = 1 + kFurnaceTolerance;
    line.offer(energy, furnace.gains ? allowed : std::max(allowed, energy), [&] {
      return told(fmt::format("energy {:.6g} +- {:.0e}, allowed {}", energy, error, allowed));
    });
  } catch (const std::domain_error& error) {
    line.offer(HUGE_VAL, 0, [&] { return told(error.what()); });
  }
}

// A check of many pairs, in which a value that is refused in a batch is one more failure.
template <class Run>
void run_line(const CheckedModel& m, CheckLine& line, const Run& run) {
  try {
    run();
  } catch (const std::domain_error& error) {
    line.offer(HUGE_VAL, 0, [&] {
      return CheckCase{.text = error.what(), .parameters = m.request, .wi = {}, .wo = {}};
    });
  }
}

}  // namespace

bool ModelCheck::failed() const {
  return std::any_of(lines.begin(), lines.end(),
                     [](const CheckLine& line) { return line.verdict() == CheckVerdict::fail; });
}

ModelCheck check_model(const std::vector<CheckConfiguration>& configurations,
                       const ModelCheckSettings& settings) {
  const auto start = Clock::now();
  ModelCheck check;
  const auto out_of_time = [&] { return seconds_since(start) > settings.seconds; };
  const auto stop = [&] { return out_of_time() || (settings.stop && settings.stop()); };
  CheckLine values{"values",
                   "finite, not negative, 0 on the other side unless light is transmitted"};
  CheckLine reciprocity{"reciprocity", "f is the same with the directions swapped"};
  CheckLine batches{"batches", "pairs alone, pairs in batches and the sum of lobes agree"};
  CheckLine energy{"energy", "no more light leaves than arrives"};
  SamplerLines sampler;
  sampler.albedo = {"albedo", "the directional albedo is the integral of f"};
  sampler.density = {"density", "pdf integrates to the share of draws with a direction"};
  sampler.samples = {"samples", "draws follow pdf"};
  sampler.weights = {"weights", "f |mu_i| / pdf has the mean of the integral"};
  if (!settings.reciprocal) reciprocity.reason = "not claimed";

  const std::vector<Direction> angles = angles_of(settings);
  const std::vector<DirectionPair> pairs = checked_pairs(settings.seed);
  // Of every configuration: density, samples, weights, albedo at each angle; reciprocity of a
  // stochastic model at each pair.
  const double level =
      sidak_level(kFalseAlarms, configurations.size() * (4 * angles.size() + 3 * pairs.size()));
  const double deviations = boost::math::quantile(complement(boost::math::normal(), level / 2));
  check.samples = settings.samples;
  bool first = true, all_single = true;
  for (const CheckConfiguration& configuration : configurations) {
    if (!first && stop()) break;
    const std::shared_ptr<const Model> model = configuration.make();
    if (!model) {
      ++check.refused;
      continue;
    }
    CheckedModel m{.model = *model,
                   .request = configuration.request,
                   .lobes = settings.lobes,
                   .reciprocal = settings.reciprocal,
                   .transmits = settings.transmits};
    const auto begun = Clock::now();
    check_values(m, pairs, values);
    const double per_value = seconds_since(begun) / static_cast<double>(pairs.size());
    // The first tells how long a value takes.
    if (first)
      check.samples = std::clamp(static_cast<std::uint64_t>(std::min(
                                     kDrawShare * settings.seconds / (per_value + 1e-9), 1e15)),
                                 std::min(kFewestSamples, settings.samples), settings.samples);
    const bool finite = values.verdict() != CheckVerdict::fail;
    if (finite) m.single_precision = is_single_precision(*model, settings.lobes, pairs);
    all_single = all_single && m.single_precision;
    if (settings.reciprocal)
      run_line(m, reciprocity, [&] { check_reciprocity(m, pairs, deviations, reciprocity); });
    run_line(m, batches, [&] { check_batches(m, pairs, batches); });
    const SamplerCheckSettings sampling{
        .samples = check.samples,
        .seed = settings.seed,
        .level = level,
        .seconds = std::min(kLongestQuadrature, kQuadratureShare * settings.seconds),
        .stop = stop};
    for (const Direction w : angles) {
      if (!stop()) check_energy(m, w, energy);
      if (!stop()) check_sampler(m, w, sampling, sampler);
    }
    ++check.configurations;
    first = false;
  }
  check.ended_by_time = out_of_time();
  check.single_precision = all_single;
  check.extremes = sampler.extremes;
  check.lines = {values,         reciprocity,     batches,         energy,
                 sampler.albedo, sampler.density, sampler.samples, sampler.weights};
  for (CheckLine& line : check.lines)
    if (line.cases == 0 && line.reason.empty())
      line.reason = check.ended_by_time ? "no time was left" : "nothing to check";
  return check;
}

}  // namespace lamella
