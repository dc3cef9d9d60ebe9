#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "phase/math/direction.h"

namespace lamella {

/// `undecided`: no case failed, and in none could the check have found anything. `skipped`: no case
/// was tried.
enum class CheckVerdict { pass, fail, undecided, skipped };

/// "pass", "fail", "undecided", "skipped"
[[nodiscard]] inline const char* to_text(CheckVerdict verdict) {
  constexpr const char* kTexts[] = {"pass", "fail", "undecided", "skipped"};
  return kTexts[static_cast<int>(verdict)];
}

/// One case of a check: a deviation and the largest that is allowed.
struct CheckCase {
  double found = 0, allowed = 0;
  std::string text{};        ///< the deviation in words and numbers
  std::string parameters{};  ///< the model as --model takes it
  std::optional<Direction> wi{}, wo{};
};

/// One check of a battery over all its cases, of which it keeps the worst.
struct CheckLine {
  std::string name{};
  std::string claim{};  ///< what holds where it passes
  std::uint64_t cases = 0, undecided = 0;
  double worst_ratio = -1;  ///< of found to allowed; above 1: failed
  std::optional<CheckCase> worst{};
  std::string reason{};  ///< why no case was tried, or not all

  /// Counts a case: `make` gives it whole, and is called where it is the worst so far. Found values
  /// that are not a number are the worst of all.
  template <class Make>
  void offer(double found, double allowed, const Make& make) {
    ++cases;
    double ratio = found <= 0 ? 0 : found / allowed;
    if (std::isnan(ratio)) ratio = std::numeric_limits<double>::infinity();
    if (ratio <= worst_ratio) return;
    worst_ratio = ratio;
    worst = make();
    worst->found = found;
    worst->allowed = allowed;
  }

  [[nodiscard]] CheckVerdict verdict() const {
    if (worst_ratio > 1) return CheckVerdict::fail;
    if (cases == 0) return CheckVerdict::skipped;
    return cases == undecided ? CheckVerdict::undecided : CheckVerdict::pass;
  }
};

}  // namespace lamella
