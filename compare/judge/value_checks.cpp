#include "compare/judge/value_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analytic/model/grazing_pair.h"
#include "analytic/model/stochastic_model.h"
#include "compare/judge/pair_values.h"
#include "compare/judge/value_noise.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

// The error of the quadratures and tables of closed forms that are reciprocal in the formula.
constexpr double kReciprocity = 1e-9;
// Noise is measured within a factor 2, and a difference of two values has sqrt(2) times it: eight
// times the measured one is exceeded by nothing that rounds.
constexpr double kNoises = 8;
// Error of lanes, of the lobes' sizes and 1 / (pi mu): the bound of batch_lanes.h's tests, 6e-16,
// of a value whose own rounding is some units more.
constexpr double kLaneError = 2e-15;
// Pairs that a BatchedModel is asked for alone.
constexpr std::size_t kFewPairs = 32;

CheckCase at_pair(const CheckedModel& m, const DirectionPair& p, std::string text) {
  return {.text = std::move(text), .parameters = m.request, .wi = p.wi, .wo = p.wo};
}

double sum_of_sizes(std::span<const Rgb> lobes, int c) {
  double sum = 0;
  for (const Rgb& v : lobes) sum += std::abs(v[c]);
  return sum;
}

}  // namespace

std::vector<DirectionPair> checked_pairs(std::uint64_t seed) {
  std::vector<DirectionPair> above;
  constexpr double kCosines[] = {1, 0.9, 0.5, 0.1, 1e-3, 1e-7, 0};
  for (const double mu_i : kCosines)
    for (const double mu_o : kCosines)
      for (const double phi : {0.0, 1.0, 2.5, kPi}) {
        if (mu_i == 0 && mu_o == 0) continue;
        const Direction wi = direction_from_mu_phi(mu_i, 0.3);
        above.push_back(
            {wi, phi == 0 && mu_i == mu_o ? wi : direction_from_mu_phi(mu_o, 0.3 + phi)});
      }
  RandomStream stream(seed, 1, StreamPurpose::model);
  for (int k = 0; k < 128; ++k) {
    const auto draw = [&] {
      const double u = stream.uniform(), mu = k % 2 ? u : std::pow(1e-8, u);
      return direction_from_mu_phi(mu, 2 * kPi * stream.uniform());
    };
    const Direction wi = draw();
    above.push_back({wi, draw()});
  }
  std::vector<DirectionPair> pairs;
  for (const auto& [wi, wo] : above) {
    const Direction i = with_grazing_limit(wi), o = with_grazing_limit(wo);
    pairs.push_back({i, o});
    // A cosine of 0 is a limit from above, and in single precision it has no side.
    if (wi.z == 0 || wo.z == 0) continue;
    // w_o mirrored at the horizon and at the origin: transmission, straight on among it.
    pairs.push_back({i, {o.x, o.y, -o.z}});
    pairs.push_back({i, -o});
    pairs.push_back({-i, o});
    pairs.push_back({-i, -o});
  }
  return pairs;
}

void check_values(const CheckedModel& m, std::span<const DirectionPair> pairs, CheckLine& line) {
  std::vector<Rgb> together;
  if (is_batched(m.model)) {
    try {
      together = pair_values(m.model, pairs);
    } catch (const std::domain_error& error) {
      line.offer(HUGE_VAL, 0, [&] {
        return CheckCase{.text = error.what(), .parameters = m.request, .wi = {}, .wo = {}};
      });
      return;
    }
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const DirectionPair& pair = pairs[k];
    const bool through = (pair.wi.z < 0) != (pair.wo.z < 0);
    try {
      const Rgb f = together.empty() ? m.model.eval(pair.wi, pair.wo) : together[k];
      for (int c = 0; c < 3; ++c) {
        const bool good =
            std::isfinite(f[c]) && f[c] >= 0 && (!through || m.transmits || f[c] == 0);
        line.offer(good                  ? 0
                   : std::isfinite(f[c]) ? std::abs(f[c])
                                         : HUGE_VAL,
                   0, [&] {
                     const char* what = !good && through && !m.transmits && f[c] > 0
                                            ? ", where light would have to pass through"
                                            : "";
                     return at_pair(m, pair, fmt::format("f = {:.6g}{}", f[c], what));
                   });
      }
    } catch (const std::domain_error& error) {
      line.offer(HUGE_VAL, 0, [&] { return at_pair(m, pair, error.what()); });
    }
  }
}

void check_reciprocity(const CheckedModel& m, std::span<const DirectionPair> pairs,
                       double deviations, CheckLine& line) {
  const auto* stochastic = dynamic_cast<const StochasticModel*>(&m.model);
  const double rounding = std::max(kReciprocity, unit_rounding(m.single_precision));
  std::vector<Rgb> there, swapped;
  if (is_batched(m.model)) {
    std::vector<DirectionPair> turned;
    for (const DirectionPair& pair : pairs) turned.push_back({pair.wo, pair.wi});
    there = pair_values(m.model, pairs);
    swapped = pair_values(m.model, turned);
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const DirectionPair& pair = pairs[k];
    const Direction wi = pair.wi, wo = pair.wo;
    if ((wi.z < 0) != (wo.z < 0)) continue;
    Rgb forth, back, error;
    if (stochastic) {
      const ValueWithError a = stochastic->eval_with_error(wi, wo),
                           b = stochastic->eval_with_error(wo, wi);
      forth = a.f, back = b.f;
      for (int c = 0; c < 3; ++c)
        error[c] = deviations * std::hypot(a.standard_error[c], b.standard_error[c]);
    } else if (!there.empty()) {
      forth = there[k], back = swapped[k];
    } else {
      forth = m.model.eval(wi, wo), back = m.model.eval(wo, wi);
    }
    bool exceeds = false;
    for (int c = 0; c < 3; ++c) {
      error[c] += rounding * std::max(std::abs(forth[c]), std::abs(back[c]));
      exceeds = exceeds || !(std::abs(forth[c] - back[c]) <= error[c]);
    }
    if (exceeds && !stochastic) {
      const Rgb a = value_noise(m.model, wi, wo), b = value_noise(m.model, wo, wi);
      for (int c = 0; c < 3; ++c) error[c] += kNoises * std::max(a[c], b[c]);
    }
    for (int c = 0; c < 3; ++c)
      line.offer(std::abs(forth[c] - back[c]), error[c], [&] {
        return at_pair(
            m, {wi, wo},
            fmt::format("f = {:.6g}, with the directions swapped {:.6g}, apart by {:.1e}, "
                        "allowed {:.1e}",
                        forth[c], back[c], std::abs(forth[c] - back[c]), error[c]));
      });
  }
}

void check_batches(const CheckedModel& m, std::span<const DirectionPair> pairs, CheckLine& line) {
  std::vector<DirectionPair> turned(pairs.rbegin(), pairs.rend());
  struct Batch {
    std::string name;
    std::vector<Rgb> values;
  };
  std::vector<Batch> batches;
  for (const Isa isa : supported_isas()) {
    Batch& batch = batches.emplace_back(Batch{fmt::format("a batch ({})", to_text(isa)), {}});
    batch.values.resize(pairs.size());
    m.model.eval(pairs, batch.values, isa);
  }
  Batch& reversed = batches.emplace_back(Batch{"a batch in reversed order", {}});
  reversed.values.resize(pairs.size());
  m.model.eval(turned, reversed.values, supported_isas().back());
  std::reverse(reversed.values.begin(), reversed.values.end());
  std::vector<Rgb> lobes(static_cast<std::size_t>(m.lobes));
  std::vector<Rgb> sizes;
  // A model that is asked for many pairs at a time has one lobe, and is asked for few alone.
  const bool batched = is_batched(m.model);
  const std::size_t step = batched ? std::max<std::size_t>(1, pairs.size() / kFewPairs) : 1;
  if (batched)
    for (const Rgb& v : batches.front().values)
      sizes.emplace_back(std::abs(v.r), std::abs(v.g), std::abs(v.b));
  else
    batches.emplace_back(Batch{"the sum of the lobes", {}});
  for (const DirectionPair& pair : pairs) {
    if (batched) break;
    m.model.eval_lobes(pair.wi, pair.wo, lobes);
    Rgb sum, size;
    for (const Rgb& v : lobes) sum += v;
    for (int c = 0; c < 3; ++c) size[c] = sum_of_sizes(lobes, c);
    batches.back().values.push_back(sum);
    sizes.push_back(size);
  }
  for (std::size_t k = 0; k < pairs.size(); k += step) {
    const Direction wi = pairs[k].wi, wo = pairs[k].wo;
    const Rgb f = m.model.eval(wi, wo);
    const double mu = std::max({std::abs(wi.z), std::abs(wo.z), kGrazingLimit});
    Rgb noise;
    bool measured = false;
    for (const Batch& batch : batches)
      for (int c = 0; c < 3; ++c) {
        const double apart = std::abs(batch.values[k][c] - f[c]);
        double allowed = kLaneError * (sizes[k][c] + 1 / (kPi * mu));
        if (m.single_precision) allowed += unit_rounding(true) * sizes[k][c];
        if (!(apart <= allowed)) {
          if (!measured) noise = value_noise(m.model, wi, wo);
          measured = true;
          allowed += kNoises * noise[c];
        }
        line.offer(apart, allowed, [&] {
          return at_pair(m, pairs[k],
                         fmt::format("f = {:.6g} alone, {:.6g} as {}, apart by {:.1e}, allowed "
                                     "{:.1e}",
                                     f[c], batch.values[k][c], batch.name, apart, allowed));
        });
      }
  }
}

}  // namespace lamella
