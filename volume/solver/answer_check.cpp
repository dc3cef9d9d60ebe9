#include "volume/solver/answer_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

constexpr double kRounding = 1e-12;
// Of an energy, as a share of the light that arrives; where the clock or Ctrl-C ended refinement,
// what is there is kept: the first nodes know it to 1.
constexpr double kWidestBound = 0.1, kWidestCutBound = 2;
// A bound as large as the energy itself says that no digit is known, and may be short of the error;
// of energies below this share it is a bound like others.
constexpr double kDarkest = 1e-3;

bool all_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

std::optional<std::string> why_not_an_energy(const std::string& name, const Estimate& energy,
                                             bool is_cut) {
  const auto& [value, bound] = energy;
  if (!std::isfinite(value) || !std::isfinite(bound))
    return fmt::format("its {} is not finite", name);
  if (value < -bound - kRounding || value > 1 + bound + kRounding)
    return fmt::format("its {} is {:.3g}, outside of 0 to 1 by more than its bound, {:.1e}", name,
                       value, bound);
  if (bound > (is_cut ? kWidestCutBound : kWidestBound))
    return fmt::format("the bound of its {} is {:.1e}", name, bound);
  return std::nullopt;
}

// The same of an energy of all orders, of which a digit must be known.
std::optional<std::string> why_no_energy(const std::string& name, const Estimate& energy,
                                         bool is_cut) {
  if (auto reason = why_not_an_energy(name, energy, is_cut)) return reason;
  const auto& [value, bound] = energy;
  if (!is_cut && bound >= value && value > kDarkest)
    return fmt::format("its {} is {:.3g} with a bound of {:.1e}", name, value, bound);
  return std::nullopt;
}

std::optional<std::string> why_no_side(const std::string& name, const SideResult& side,
                                       int channels, bool is_cut) {
  for (int c = 0; c < channels; ++c) {
    if (auto reason = why_no_energy(name, side.total[c], is_cut)) return reason;
    for (int order = 0; order < kTallyOrders; ++order)
      if (auto reason = why_not_an_energy(name + " by order", side.orders[order][c], is_cut))
        return reason;
  }
  for (const LobeEstimate& lobe : side.lobes)
    if (!all_finite(lobe.value) || !all_finite(lobe.standard_error))
      return "cells of its " + name + " are not finite";
  return std::nullopt;
}

}  // namespace

std::optional<std::string> why_no_answer(const DeterministicAccuracy& accuracy) {
  if (accuracy.is_answer()) return std::nullopt;
  if (!std::isfinite(accuracy.error))
    return fmt::format("its numbers are not finite, with {} nodes or fewer", accuracy.nodes);
  return fmt::format("its error is {:.1e} of f with {} nodes and {} modes", accuracy.error,
                     accuracy.nodes, accuracy.modes);
}

std::optional<std::string> why_no_answer(const RunResult& run, bool repeats) {
  const bool is_cut =
      repeats || (run.accuracy && (run.accuracy->limit == DeterministicLimit::time ||
                                   run.accuracy->limit == DeterministicLimit::interrupted));
  if (auto reason = why_no_side("reflected energy", run.reflected, run.channels, is_cut))
    return reason;
  if (auto reason = why_no_side("transmitted energy", run.transmitted, run.channels, is_cut))
    return reason;
  for (int c = 0; c < run.channels; ++c) {
    if (auto reason = why_no_energy("uncollided energy", run.uncollided[c], is_cut)) return reason;
    if (auto reason = why_no_energy("absorbed energy", run.absorbed[c], is_cut)) return reason;
    // The bound of what is absorbed holds the defect itself: the others must cover it.
    const double defect = std::abs(ledger_sum(run, c) - 1);
    const double covered = run.reflected.total[c].standard_error +
                           run.transmitted.total[c].standard_error +
                           (run.accuracy ? run.accuracy->error : 0) + kRounding;
    if (!(defect <= covered))
      return fmt::format("its energies sum to 1 {:+.1e}, more than their bounds, {:.1e}",
                         ledger_sum(run, c) - 1, covered);
  }
  return std::nullopt;
}

}  // namespace lamella
