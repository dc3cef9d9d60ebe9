#pragma once

#include <optional>
#include <string>

#include "compare/request/run_monitor.h"
#include "volume/run/simulation.h"
#include "volume/solver/deterministic.h"

namespace lamella {

enum class FurnaceVerdict { pass, fail, inconclusive };

[[nodiscard]] std::string to_text(FurnaceVerdict verdict);

/// Error of an energy above which a furnace is not judged: a standard error of walks, a bound of
/// the solver.
inline constexpr double kWidestFurnaceError = 1e-3;

/// The furnace of one incident direction: the energy that leaves, measured by what arrives at the
/// targets, against the walk's own ledger.
struct FurnaceRun {
  RunResult run;
  std::array<Estimate, 3> energy{};  ///< reflected + transmitted + uncollided, by the estimator
  std::array<double, 3> expected{};  ///< 1 - absorbed - unresolved - thinned by the ledger
  FurnaceVerdict verdict = FurnaceVerdict::pass;
  bool loses = false, gains = false;  ///< where it fails: whether a channel loses or gains energy
  bool is_wide = false;               ///< an error is above kWidestFurnaceError
  bool is_cut = false;                ///< more is unresolved than the noise
  bool has_few_events = false;        ///< too few to judge a mean by
};

/// "none", "loss", "gain" or "both".
[[nodiscard]] std::string loss_or_gain(bool loses, bool gains);

/// Judges a furnace: the energy that leaves must be 1 (with absorption kept: 1 less the energy that
/// the ledger has as absorbed) within furnace_quantile(level) standard errors. The verdict is
/// `inconclusive` in three cases: the light that the order limit cut is more than the noise and
/// accounts for the deficit; the estimator saw fewer than some 100 effective events (sharp lobes
/// that few walks hit); the energy's standard error, thinning's part included, is above
/// kWidestFurnaceError. `level`: the probability with which a true furnace may fail by chance.
/// Without batches the run has error bounds: the sum of its cells must be 1 within them, and bounds
/// above kWidestFurnaceError are inconclusive.
[[nodiscard]] FurnaceRun judge_furnace(const RunResult& run, const Simulation* batches, bool white,
                                       double level);

/// Standard errors that a true furnace of walks exceeds with the probability `level`, on either
/// side: Student's t over the batches.
[[nodiscard]] double furnace_quantile(double level);

/// A one-sided stack's second furnace: the radiance seen along w under uniform light of radiance 1
/// from both sides.
struct RadianceCheck {
  Direction w{};
  double measured = 0, standard_error = 0;
  double predicted = 0, predicted_error = 0;  ///< 1 + (exp(+-S) - 1) T(w)
};

/// Measures that radiance by walks from directions drawn over both hemispheres, and predicts it
/// from the total transmittance of light entering along w reversed; both are means over the ring of
/// directions within w's sixteenth of mu^2, so that no lobe is too narrow to be met. For stacks
/// that are open below, symmetric about z and white, without delta flakes. `walks` in all; the
/// monitor's `stop`, once set, ends each part early.
[[nodiscard]] RadianceCheck check_radiance(const Stack& stack, const Plan& plan, Direction w,
                                           std::uint64_t walks, std::uint64_t seed,
                                           const RunMonitor& monitor = {});

/// The radiance furnace of a solved stack; errors are bounds.
[[nodiscard]] RadianceCheck check_radiance(const DeterministicSolution& solution, Direction w);

}  // namespace lamella
