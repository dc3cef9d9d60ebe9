#include "compare/judge/value_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "compare/judge/pair_values.h"

namespace lamella {
namespace {

constexpr int kOrder = 6, kPoints = 13;
constexpr double kStep = 3e-6;
// (k!)^2 / (2 k)! of k = 6, see value_noise.
constexpr double kScale = 1.0 / 924;

// The direction a little farther from the normal (or nearer, near the horizon) and turned.
Direction moved(Direction w, double step) {
  const double mu = std::abs(w.z), side = w.z < 0 ? -1 : 1, phi = azimuth(w) + 0.7 * step;
  if (mu < 0.5) return direction_from_mu_phi(side * mu * (1 + step), phi);
  const double theta = std::atan2(std::hypot(w.x, w.y), mu) + step;
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), side * std::cos(theta)};
}

bool is_float(double x) { return static_cast<double>(static_cast<float>(x)) == x; }

}  // namespace

Rgb value_noise(const Model& model, Direction wi, Direction wo) {
  std::array<DirectionPair, kPoints> pairs;
  for (int k = 0; k < kPoints; ++k) pairs[k] = {moved(wi, k * kStep), moved(wo, k * kStep)};
  const std::vector<Rgb> values = pair_values(model, pairs);
  Rgb noise;
  for (int c = 0; c < 3; ++c) {
    std::array<double, kPoints> d{};
    for (int k = 0; k < kPoints; ++k) d[k] = values[k][c];
    for (int order = 1; order <= kOrder; ++order)
      for (int k = 0; k + order < kPoints; ++k) d[k] = d[k + 1] - d[k];
    double squares = 0;
    for (int k = 0; k + kOrder < kPoints; ++k) squares += d[k] * d[k];
    noise[c] = std::sqrt(kScale * squares / (kPoints - kOrder));
  }
  return noise;
}

bool is_single_precision(const Model& model, int lobes, std::span<const DirectionPair> pairs) {
  const auto all_are = [](std::span<const Rgb> list) {
    return std::all_of(list.begin(), list.end(), [](const Rgb& v) {
      return is_float(v.r) && is_float(v.g) && is_float(v.b);
    });
  };
  if (is_batched(model)) return all_are(pair_values(model, pairs));
  std::vector<Rgb> values(static_cast<std::size_t>(lobes));
  for (const DirectionPair& pair : pairs) {
    model.eval_lobes(pair.wi, pair.wo, values);
    if (!all_are(values)) return false;
  }
  return true;
}

}  // namespace lamella
