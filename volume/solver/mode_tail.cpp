#include "volume/solver/mode_tail.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "phase/math/larger_error.h"

namespace lamella {
namespace {

constexpr int kShortest = 48;
constexpr int kReach = 24;  // of the tail's sum, in units of its first mode

ModeTail through(std::span<const double> modes, const std::array<int, 3>& m) {
  std::array<double, 3> log_m, log_f;
  for (int k = 0; k < 3; ++k) {
    log_m[k] = std::log(m[k]);
    log_f[k] = std::log(std::abs(modes[m[k]]));
  }
  const double a1 = log_m[1] - log_m[0], b1 = m[1] - m[0], c1 = log_f[0] - log_f[1];
  const double a2 = log_m[2] - log_m[1], b2 = m[2] - m[1], c2 = log_f[1] - log_f[2];
  const double determinant = a1 * b2 - a2 * b1;
  ModeTail tail;
  tail.exponent = (c1 * b2 - c2 * b1) / determinant;
  tail.rate = (a1 * c2 - a2 * c1) / determinant;
  if (tail.rate < 0) {
    tail.rate = 0;
    tail.exponent = (c1 + c2) / (a1 + a2);
  } else if (tail.exponent < 0) {
    tail.exponent = 0;
    tail.rate = (c1 + c2) / (b1 + b2);
  }
  tail.amplitude =
      std::copysign(std::exp(log_f[2] + tail.exponent * log_m[2] + tail.rate * m[2]), modes[m[2]]);
  return tail;
}

double without_fit(std::span<const double> modes) {
  const std::size_t count = modes.size();
  const auto largest = [&](std::size_t from) {
    double size = 0;
    for (std::size_t m = from; m < from + 4; ++m) size = larger_error(size, std::abs(modes[m]));
    return size;
  };
  if (count < 8) return count == 0 ? 0 : 2 * std::abs(modes.back());
  const double newer = largest(count - 4), older = largest(count / 2 - 2);
  if (newer == 0) return 0;
  const double exponent = larger_error(1.25, std::log2(larger_error(older, newer) / newer));
  return 2 * newer * static_cast<double>(count) / (exponent - 1);
}

}  // namespace

double ModeTail::at(double m) const {
  return amplitude * std::exp(-exponent * std::log(m) - rate * m);
}

double ModeTail::sum(double x) const {
  if (amplitude == 0) return 0;
  double total = 0;
  const double least = 1e-6 * std::abs(at(first));
  for (int m = first; m < kReach * first; ++m) {
    const double f = at(m);
    total += 2 * f * std::cos(m * x);
    if (std::abs(f) < least) break;
  }
  return total;
}

ModeTail fit_mode_tail(std::span<const double> modes) {
  const int count = static_cast<int>(modes.size());
  ModeTail none;
  none.first = count;
  none.error = without_fit(modes);
  if (count < kShortest) return none;
  for (int m = 3 * count / 8; m + 1 < count; ++m)
    if (!(modes[m] * modes[m + 1] > 0 && std::abs(modes[m + 1]) < std::abs(modes[m]))) return none;
  ModeTail tail = through(modes, {count / 2, 3 * count / 4, count - 1});
  const ModeTail earlier = through(modes, {3 * count / 8, count / 2, 5 * count / 8});
  // Modes that fall out of the range of double leave nothing to continue.
  if (!std::isfinite(tail.amplitude) || !(tail.rate * count + tail.exponent >= 1.5)) return none;
  tail.first = count;
  const double trust = std::abs(earlier.at(count - 1) / modes[count - 1] - 1);
  tail.error = std::min(none.error, std::clamp(trust, 1e-3, 1.0) * std::abs(tail.sum(0)));
  return tail;
}

}  // namespace lamella
