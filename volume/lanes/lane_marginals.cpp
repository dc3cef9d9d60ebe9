#include "volume/lanes/lane_marginals.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "volume/lanes/lane_layers.h"

namespace lamella {
namespace {

// Quantiles of a density on [0, end], from its integral over small intervals by Simpson's rule.
template <class Density>
class Quantiles {
 public:
  Quantiles(const Density& density, double end)
      : density_(density), width_(end / kIntervals), sums_(kIntervals + 1) {
    for (int k = 0; k < kIntervals; ++k)
      sums_[k + 1] = sums_[k] + integral(k * width_, (k + 1) * width_);
  }
  double operator()(double probability) const {
    const double goal = probability * sums_.back();
    const auto above = std::upper_bound(sums_.begin(), sums_.end() - 1, goal);
    const auto k = std::max<std::ptrdiff_t>(above - sums_.begin() - 1, 0);
    const double from = static_cast<double>(k) * width_;
    double low = 0, high = width_;
    for (int step = 0; step < 50; ++step) {
      const double middle = (low + high) / 2;
      (sums_[k] + integral(from, from + middle) < goal ? low : high) = middle;
    }
    return from + (low + high) / 2;
  }
  double normalised(double x) const { return density_(x) / sums_.back(); }

 private:
  static constexpr int kIntervals = 4096;
  double integral(double a, double b) const {
    return (b - a) / 6 * (density_(a) + 4 * density_((a + b) / 2) + density_(b));
  }
  Density density_;
  double width_;
  std::vector<double> sums_;
};

}  // namespace

void append_cubics(std::vector<float>& table, const std::function<double(double)>& value) {
  constexpr int n = kMarginalPieces;
  std::vector<double> y(n + 1), slope(n + 1);
  for (int k = 0; k <= n; ++k) y[k] = value(static_cast<double>(k) / n);
  const auto secant = [&](int k) { return y[k + 1] - y[k]; };
  constexpr double kStep = 1e-3;  // of a piece
  for (int k = 0; k <= n; ++k) {
    const double low = std::max(0.0, (k - kStep) / n), high = std::min(1.0, (k + kStep) / n);
    slope[k] = (value(high) - value(low)) / (high - low) / n;
    double least = std::abs(secant(std::min(k, n - 1)));
    if (k > 0) least = std::min(least, std::abs(secant(k - 1)));
    slope[k] = std::clamp(slope[k], -3 * least, 3 * least);
  }
  for (int k = 0; k < n; ++k)
    for (const double c : {y[k], slope[k], 3 * secant(k) - 2 * slope[k] - slope[k + 1],
                           -2 * secant(k) + slope[k] + slope[k + 1]})
      table.push_back(static_cast<float>(c));
}

std::vector<float> vmf_marginals(double kappa) {
  // Of the densities exp(-kLargest) is left at most there.
  constexpr double kLargest = 45;
  const double scale = std::max(kappa, 1.0), end = std::min(scale, kLargest);
  const double angle_end =
      std::min(std::numbers::pi, std::sqrt(2 * kLargest / std::max(kappa, 1e-3)));
  std::vector<float> table;
  table.reserve(12 * kMarginalPieces);
  const auto probability = [](double exponential) { return -std::expm1(-exponential); };
  const auto by_root = [&](double t) { return probability(kLargestExponential * t * t); };
  const auto by_cube_root = [&](double t) { return probability(kLargestExponential * t * t * t); };
  const Quantiles axial([=](double y) { return (1 - y / scale) * std::exp(-y * (kappa / scale)); },
                        end);
  append_cubics(table, [&](double t) { return axial(by_root(t)) / scale; });
  const Quantiles back([=](double y) { return y * std::exp(-y * (kappa / scale)); }, end);
  append_cubics(table, [&](double t) { return 1 + back(by_root(t)) / scale; });
  // By the angle from the mean normal.
  const Quantiles tangential(
      [=](double angle) {
        const double s = std::sin(angle), half = std::sin(angle / 2);
        return s * s * std::exp(-2 * kappa * half * half);
      },
      angle_end);
  append_cubics(table, [&](double t) {
    const double s = std::sin(tangential(by_cube_root(t)) / 2);
    return 2 * s * s;
  });
  return table;
}

}  // namespace lamella
