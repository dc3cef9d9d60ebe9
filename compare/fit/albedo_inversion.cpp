#include "compare/fit/albedo_inversion.h"

#include <fmt/format.h>

#include <cmath>

namespace lamella {
namespace {

constexpr int kMostEvaluations = 80;

}  // namespace

AlbedoInversion invert_albedo(const std::function<Rgb(Rgb)>& color, Rgb target, double tolerance) {
  Rgb low(0), high(1);
  const Rgb least = color(low), most = color(high);
  AlbedoInversion result{.evaluations = 2};
  Rgb below, above;  // the colour less the target, halved where an end stays
  for (int c = 0; c < 3; ++c) {
    below[c] = least[c] - target[c];
    above[c] = most[c] - target[c];
    if (below[c] > tolerance || above[c] < -tolerance)
      throw UnreachableColor(fmt::format(
          "found {}; allowed: from {:.6g} (albedo 0) to {:.6g} "
          "(albedo 1){}",
          target[c], least[c], most[c], target.is_grey() ? "" : fmt::format(" in channel {}", c)));
    if (below[c] >= -tolerance) high[c] = low[c];
    if (above[c] <= tolerance && low[c] != high[c]) low[c] = high[c];
  }
  result.slope = most - least;
  Rgb last(1), last_color = most;
  for (; result.evaluations < kMostEvaluations; ++result.evaluations) {
    Rgb guess;
    for (int c = 0; c < 3; ++c)
      guess[c] = low[c] == high[c]
                     ? low[c]
                     : low[c] + (high[c] - low[c]) * -below[c] / (above[c] - below[c]);
    const Rgb value = color(guess);
    bool done = true;
    for (int c = 0; c < 3; ++c) {
      if (guess[c] != last[c]) result.slope[c] = (value[c] - last_color[c]) / (guess[c] - last[c]);
      const double error = value[c] - target[c];
      if (low[c] == high[c] || std::abs(error) <= tolerance) {
        low[c] = high[c] = guess[c];
        continue;
      }
      done = false;
      if (error < 0) {
        if (guess[c] - low[c] < 0.5 * (high[c] - low[c])) above[c] /= 2;
        low[c] = guess[c];
        below[c] = error;
      } else {
        if (high[c] - guess[c] < 0.5 * (high[c] - low[c])) below[c] /= 2;
        high[c] = guess[c];
        above[c] = error;
      }
    }
    result.albedo = guess;
    result.reached = value;
    last = guess;
    last_color = value;
    if (done) break;
  }
  return result;
}

}  // namespace lamella
