#include "compare/judge/sampler_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "compare/judge/pair_values.h"
#include "compare/request/stopwatch.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

constexpr std::size_t kPoints = 256;
constexpr std::uint64_t kBlock = 4096;  // samples

}  // namespace

SamplerStatistics sampler_statistics(const Model& model, Direction wo, std::uint64_t samples,
                                     std::uint64_t seed) {
  wo = with_grazing_limit(wo);
  SamplerStatistics s;
  double m2 = 0;
  std::uint64_t lost = 0;
  // Of a block of samples: those with a direction, and their places.
  std::vector<DirectionPair> pairs;
  std::vector<std::size_t> places;
  std::vector<double> weights;
  const auto find_weights = [&](std::uint64_t from, std::uint64_t to) {
    pairs.clear();
    places.clear();
    weights.assign(to - from, 0.0);
    for (std::uint64_t k = from; k < to; ++k) {
      RandomStream stream(seed, k, StreamPurpose::model);
      const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
      const auto wi = model.sample(wo, u1, u2, u3);
      if (!wi) continue;
      pairs.push_back({*wi, wo});
      places.push_back(k - from);
    }
    const std::vector<Rgb> values = pair_values(model, pairs);
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      const double f = values[n].max();
      if (f != 0) weights[places[n]] = f * std::abs(pairs[n].wi.z) / model.pdf(pairs[n].wi, wo);
    }
  };
  for (std::uint64_t k = 0; k < samples; ++k) {
    if (k % kBlock == 0) find_weights(k, std::min(samples, k + kBlock));
    const double weight = weights[k % kBlock];
    if (!std::isfinite(weight))
      throw std::domain_error("a sample's weight is not finite: its density is 0 or not a number");
    lost += weight == 0;
    s.max_weight = std::max(s.max_weight, weight);
    const double delta = weight - s.mean;
    s.mean += delta / static_cast<double>(k + 1);
    m2 += delta * (weight - s.mean);
  }
  const auto n = static_cast<double>(samples);
  s.variance = samples > 1 ? m2 / (n - 1) : 0;
  s.mean_error = std::sqrt(s.variance / n);
  s.lost = static_cast<double>(lost) / n;
  return s;
}

SamplerTimes sampler_times(const Model& model, double seconds) {
  RandomStream stream(1, 0, StreamPurpose::model);
  std::array<DirectionPair, kPoints> pairs;
  std::array<std::array<double, 3>, kPoints> uniforms;
  const auto draw = [&] {
    const double mu = stream.uniform();
    return direction_from_mu_phi(mu, 2 * kPi * stream.uniform());
  };
  for (std::size_t k = 0; k < kPoints; ++k) {
    pairs[k].wi = draw();
    pairs[k].wo = draw();
    uniforms[k] = {stream.uniform(), stream.uniform(), stream.uniform()};
  }
  volatile double sink = 0;  // keeps the loops
  const auto evaluate = [&] {
    double sum = 0;
    for (const DirectionPair& p : pairs) sum += model.eval(p.wi, p.wo).g;
    sink = sum;
  };
  const auto sample = [&] {
    double sum = 0;
    for (std::size_t k = 0; k < kPoints; ++k) {
      const auto& u = uniforms[k];
      if (const auto wi = model.sample(pairs[k].wo, u[0], u[1], u[2]))
        sum += model.eval(*wi, pairs[k].wo).g / model.pdf(*wi, pairs[k].wo);
    }
    sink = sum;
  };
  const auto nanoseconds = [&](const std::function<void()>& f) {
    int rounds = 1;
    const auto repeat = [&] {
      for (int k = 0; k < rounds; ++k) f();
    };
    while (rounds < 1 << 20 && seconds_of(repeat) < seconds / 8) rounds *= 2;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 5; ++k) least = std::min(least, seconds_of(repeat));
    return least * 1e9 / rounds / static_cast<double>(kPoints);
  };
  return {nanoseconds(evaluate), nanoseconds(sample)};
}

}  // namespace lamella
