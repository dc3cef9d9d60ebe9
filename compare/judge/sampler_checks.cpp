#include "compare/judge/sampler_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "analytic/model/stochastic_model.h"
#include "compare/judge/density_cells.h"
#include "compare/judge/sampler_statistics.h"
#include "compare/judge/statistics.h"
#include "phase/math/degrees.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

// Below it an integral of a density or of an albedo is right for any use; the furnace of closed
// forms allows a thousand times as much.
constexpr double kIntegralTolerance = 1e-6;
constexpr std::uint64_t kQuadratureValues = 200000;
constexpr double kUndecided = 0.1;  // of the mean
constexpr double kLargest = 1e200;
constexpr std::size_t kPilot = 2048;
constexpr double kCellTolerance = 1e-5;  // of a panel's share; a cell has a share of 1/48

// Integrals over w_i at one w_o, by one quadrature.
struct SamplerIntegrals {
  double mean = 0, second = 0, density = 0;  // of f |mu_i|, its square over pdf, pdf
  double mean_error = 0, second_error = 0, density_error = 0;
  double max_weight = 0;
  bool grey = true;
  std::string refused{};  // what the model said where it refused a value; those count as 0
};

SamplerIntegrals integrals_of(const CheckedModel& m, Direction wo, double seconds) {
  SamplerIntegrals found;
  std::vector<DirectionPair> pairs;
  std::vector<Rgb> f;
  const auto at = [&](std::span<const Direction> directions, std::span<Rgb> values) {
    pairs.clear();
    for (const Direction& wi : directions) pairs.push_back({wi, wo});
    f.resize(pairs.size());
    try {
      m.model.eval(pairs, f, Isa::scalar);
    } catch (const std::domain_error& error) {
      found.refused = error.what();
      std::fill(f.begin(), f.end(), Rgb());
    }
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const double c = std::abs(directions[k].z), most = f[k].max();
      const double pdf = m.model.pdf(directions[k], wo);
      const double weight = pdf > 0 ? most * c / pdf : 0;
      found.max_weight = std::max(found.max_weight, weight);
      found.grey = found.grey && f[k].is_grey();
      // Larger ones would overflow in sums, and hide the density.
      values[k] = {std::min(most, kLargest), std::min(most * weight, kLargest), pdf / c};
    }
  };
  const DirectionalIntegral integral = integrate_projected(
      at, wo, std::array{1.0, -1.0},
      {.tolerance = kIntegralTolerance, .evaluations = kQuadratureValues, .seconds = seconds});
  found.mean = integral.value.r, found.mean_error = integral.error.r;
  found.second = integral.value.g, found.second_error = integral.error.g;
  found.density = integral.value.b, found.density_error = integral.error.b;
  return found;
}

// |mean - expectation| that N values in [0, most] of that variance exceed with probability `level`
// at most: Bernstein's inequality, solved for the deviation.
double bernstein_bound(double variance, double most, double n, double level) {
  const double l = std::log(2 / level), linear = most * l / 3;
  return (linear + std::sqrt(linear * linear + 2 * n * variance * l)) / n;
}

CheckCase at_direction(const CheckedModel& m, Direction wo, std::string text) {
  return {.text = std::move(text), .parameters = m.request, .wi = std::nullopt, .wo = wo};
}

struct Draws {
  std::vector<Direction> directions;
  std::uint64_t all = 0;  // those without a direction among them
};

Draws draw(const CheckedModel& m, Direction wo, std::uint64_t count, std::uint64_t seed,
           const std::function<bool()>& stop) {
  Draws draws;
  for (; draws.all < count; ++draws.all) {
    if (draws.all % 256 == 0 && stop()) break;
    RandomStream stream(seed, draws.all, StreamPurpose::model);
    const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
    if (const auto wi = m.model.sample(wo, u1, u2, u3)) draws.directions.push_back(*wi);
  }
  return draws;
}

// Runs one case of a line, in which a value that is refused fails it.
template <class Run>
void run_case(const CheckedModel& m, Direction wo, CheckLine& line, const Run& run) {
  try {
    run();
  } catch (const std::domain_error& error) {
    line.offer(HUGE_VAL, 0, [&] { return at_direction(m, wo, error.what()); });
  }
}

void check_samples(const CheckedModel& m, Direction wo, const Draws& draws,
                   const SamplerCheckSettings& settings, CheckLine& line) {
  const Draws pilot = draw(m, wo, kPilot, settings.seed + 1, settings.stop);
  if (pilot.directions.size() < kPilot / 8 || draws.directions.empty()) return;
  const DensityCells cells(pilot.directions);
  const auto density = [&](Direction wi) { return m.model.pdf(wi, wo); };
  const DensityCells::Shares shares = cells.integrate(density, kCellTolerance, settings.stop);
  const auto n = static_cast<double>(draws.all);
  std::vector<double> observed(cells.count()), expected(shares.value), uncertainty(shares.error);
  for (const Direction& wi : draws.directions) observed[cells.cell_of(wi)] += 1;
  for (double& x : expected) x *= n;
  for (double& x : uncertainty) x *= n;
  if (std::any_of(uncertainty.begin(), uncertainty.end(), [](double x) { return std::isinf(x); }))
    return;  // the time was out
  const double p = chi_square_p_value(observed, expected, uncertainty);
  // As a ratio that orders cases: of the logarithms, 1 at the level.
  line.offer(-std::log(std::max(p, 1e-300)), -std::log(settings.level), [&] {
    std::size_t worst = 0;
    const auto z = [&](std::size_t k) {
      return (observed[k] - expected[k]) / std::sqrt(std::max(expected[k], 1.0));
    };
    for (std::size_t k = 0; k < cells.count(); ++k)
      if (std::abs(z(k)) > std::abs(z(worst))) worst = k;
    return at_direction(
        m, wo,
        fmt::format("p = {:.1e}, allowed from {:.1e}; the worst of {} cells has {:.0f} "
                    "samples where the density has {:.1f}",
                    p, settings.level, cells.count(), observed[worst], expected[worst]));
  });
}

}  // namespace

void check_sampler(const CheckedModel& m, Direction wo, const SamplerCheckSettings& settings,
                   SamplerLines& lines) {
  wo = with_grazing_limit(wo);
  SamplerIntegrals integrals;
  bool integrated = false;
  Draws draws;
  run_case(m, wo, lines.density, [&] {
    integrals = integrals_of(m, wo, settings.seconds);
    integrated = true;
  });
  run_case(m, wo, lines.samples, [&] {
    draws = draw(m, wo, settings.samples, settings.seed, settings.stop);
    if (draws.all < settings.samples) return;
    check_samples(m, wo, draws, settings, lines.samples);
  });
  if (integrated && draws.all > 0) {
    const double n = static_cast<double>(draws.all);
    const double found = static_cast<double>(draws.directions.size()) / n;
    const double allowed =
        kIntegralTolerance + integrals.density_error +
        bernstein_bound(found * (1 - found), found < 1 ? 1 : 0, n, settings.level);
    if (allowed > kUndecided) ++lines.density.undecided;
    lines.density.offer(std::abs(integrals.density - found), allowed, [&] {
      return at_direction(
          m, wo,
          fmt::format("the integral is {:.6f}, {:.6f} of the draws have a direction, "
                      "allowed {:.1e}",
                      integrals.density, found, allowed));
    });
  }
  if (settings.stop()) return;
  run_case(m, wo, lines.weights, [&] {
    const SamplerStatistics s =
        sampler_statistics(m.model, wo, settings.samples, settings.seed + 2);
    SamplerExtremes& e = lines.extremes;
    if (s.variance >= e.variance) {
      e.theta_o = theta_degrees(wo);
      e.parameters = m.request;
    }
    e.variance = std::max(e.variance, s.variance);
    e.max_weight = std::max(e.max_weight, s.max_weight);
    e.lost = std::max(e.lost, s.lost);
    if (!integrated) return;
    if (!integrals.refused.empty()) throw std::domain_error(integrals.refused);
    const double most = std::max(integrals.max_weight, s.max_weight);
    const double variance =
        std::max({0.0, integrals.second + integrals.second_error - integrals.mean * integrals.mean,
                  s.variance});
    const double allowed =
        kIntegralTolerance + integrals.mean_error +
        bernstein_bound(variance, most, static_cast<double>(settings.samples), settings.level);
    if (!(allowed <= kUndecided * std::max(integrals.mean, 1e-3))) ++lines.weights.undecided;
    lines.weights.offer(std::abs(s.mean - integrals.mean), allowed, [&] {
      return at_direction(m, wo,
                          fmt::format("mean {:.5f}, the integral is {:.5f}, allowed {:.1e}", s.mean,
                                      integrals.mean, allowed));
    });
  });
  if (!integrated || !integrals.refused.empty() || !m.reciprocal || m.transmits || !integrals.grey)
    return;
  run_case(m, wo, lines.albedo, [&] {
    const AlbedoEstimate albedo = m.model.albedo_with_error(wo);
    double error = albedo.error.max() + integrals.mean_error + kIntegralTolerance;
    if (const auto* stochastic = dynamic_cast<const StochasticModel*>(&m.model)) {
      // Values share their random numbers, so their errors may all have one sign.
      const double deviations =
          boost::math::quantile(complement(boost::math::normal(), settings.level / 2));
      double sum = 0, errors = 0;
      for (std::size_t k = 0; k < std::min<std::size_t>(64, draws.directions.size()); ++k) {
        const ValueWithError v = stochastic->eval_with_error(draws.directions[k], wo);
        sum += v.f.max();
        errors += v.standard_error.max();
      }
      error = kIntegralTolerance + integrals.mean_error +
              deviations * (albedo.error.max() + (sum > 0 ? errors / sum * integrals.mean : 0));
    }
    lines.albedo.offer(std::abs(albedo.value.max() - integrals.mean), error, [&] {
      return at_direction(m, wo,
                          fmt::format("told {:.7g}, integrated {:.7g}, allowed {:.1e}",
                                      albedo.value.max(), integrals.mean, error));
    });
  });
}

}  // namespace lamella
