#include "compare/drawing/color_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lamella {
namespace {

constexpr std::array<double, 3> kRound = {1, 2, 5};
constexpr double kDecades = 6;
// Keeps sums of limits finite and ratios normal.
constexpr double kLargest = 1e300, kSmallest = 1e-290;

/// The smallest of 1, 2, 5 times a power of ten at or above x > 0 (at or below, if !up).
double round_number(double x, bool up) {
  const double slack = up ? 1 - 1e-9 : 1 + 1e-9;
  const int e = static_cast<int>(std::floor(std::log10(x)));
  double below = kRound[2] * std::pow(10, e - 1);
  for (int k = e - 1; k <= e + 1; ++k)
    for (const double m : kRound) {
      const double candidate = m * std::pow(10, k);
      if (up && candidate >= x * slack) return candidate;
      if (!up && candidate > x * slack) return below;
      below = candidate;
    }
  return below;
}

std::string label_of(double value) { return fmt::format("{:.6g}", value == 0 ? 0.0 : value); }

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(std::span<const double> values, bool only_positive) {
    for (const double v : values)
      if (std::isfinite(v) && (v > 0 || !only_positive)) {
        low = std::min(low, std::clamp(v, -kLargest, kLargest));
        high = std::max(high, std::clamp(v, -kLargest, kLargest));
      }
  }
  [[nodiscard]] bool is_empty() const { return low > high; }
};

std::vector<ColorScale::Tick> logarithmic_ticks(const ColorScale& scale) {
  std::vector<ColorScale::Tick> ticks;
  const bool every_decade_only = scale.high / scale.low > 101;
  const int from = static_cast<int>(std::floor(std::log10(scale.low) + 1e-9));
  const int to = static_cast<int>(std::ceil(std::log10(scale.high) - 1e-9));
  for (int k = from; k <= to; ++k)
    for (const double m : kRound) {
      if (every_decade_only && m != 1) continue;
      const double value = m * std::pow(10, k);
      if (value < scale.low * (1 - 1e-9) || value > scale.high * (1 + 1e-9)) continue;
      ticks.push_back({scale.position(value), label_of(value)});
    }
  return ticks;
}

}  // namespace

double ColorScale::position(double value) const {
  if (kind == Kind::logarithmic)
    return value <= low ? 0 : std::clamp(std::log(value / low) / std::log(high / low), 0.0, 1.0);
  return std::clamp((value - low) / (high - low), 0.0, 1.0);
}

Color ColorScale::color_at(double position) const {
  return kind == Kind::diverging ? diverging_color(2 * position - 1) : viridis(position);
}

std::vector<ColorScale::Tick> ColorScale::ticks() const {
  if (kind == Kind::logarithmic) return logarithmic_ticks(*this);
  std::vector<Tick> ticks;
  for (int k = static_cast<int>(std::ceil(low / step - 1e-9)); k * step <= high + 1e-9 * step; ++k)
    ticks.push_back({position(k * step), label_of(k * step)});
  return ticks;
}

ColorScale magnitude_scale(std::span<const double> a, std::span<const double> b, bool logarithmic) {
  Range range;
  range.include(a, logarithmic);
  range.include(b, logarithmic);
  if (logarithmic) {
    if (range.is_empty()) return magnitude_scale(a, b, false);
    const double high = round_number(std::max(range.high, kSmallest), true);
    double low =
        round_number(std::clamp(range.low, high * std::pow(10, -kDecades), high / 2), false);
    if (!(low < high)) low = high / 10;
    return {.kind = ColorScale::Kind::logarithmic, .low = low, .high = high};
  }
  const double low = range.is_empty() ? 0 : std::min(range.low, 0.0);
  double high = range.is_empty() ? 1 : std::max(range.high, 0.0);
  if (high - low < kSmallest) high = 1;
  const double step = round_number((high - low) / 8, true);
  return {.kind = ColorScale::Kind::linear,
          .low = step * std::floor(low / step + 1e-9),
          .high = step * std::ceil(high / step - 1e-9),
          .step = step};
}

ColorScale signed_scale(std::span<const double> values) {
  Range range;
  range.include(values, false);
  double limit = range.is_empty() ? 1 : std::max(-range.low, range.high);
  if (limit < kSmallest) limit = 1;
  const double step = round_number(limit / 4, true);
  return fixed_signed_scale(step * std::ceil(limit / step - 1e-9), step);
}

ColorScale ratio_scale(std::span<const double> values) {
  double high = 10;
  for (const double v : values)
    if (std::isfinite(v)) high = std::max(high, std::min(std::fabs(v), kLargest));
  const double decades = std::ceil(std::log10(high) - 1e-9);
  return {.kind = ColorScale::Kind::logarithmic, .low = 0.1, .high = std::pow(10, decades)};
}

ColorScale fixed_signed_scale(double limit, double step) {
  return {.kind = ColorScale::Kind::diverging, .low = -limit, .high = limit, .step = step};
}

}  // namespace lamella
