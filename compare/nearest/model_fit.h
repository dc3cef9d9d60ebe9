#pragma once

#include <string>
#include <vector>

#include "compare/nearest/fit_subject.h"
#include "compare/request/interrupt.h"
#include "volume/result/run_result.h"

namespace lamella {

/// What is made least. m and t: means of model and truth over cells, which have equal projected
/// solid angles, so that cosines weigh them; every incident direction counts the same.
enum class FitNorm {
  relative,    ///< root of the mean over directions of sum (m - t)^2 / sum t^2
  logarithmic  ///< root of the mean over cells of ln^2 ((m + e) / (t + e)), e = kLogFloor of the
               ///< direction's root mean square of t
};
inline constexpr double kLogFloor = 1e-3;

/// "relative", "log"
[[nodiscard]] std::string to_text(FitNorm norm);

/// How a free number came out.
enum class FreeState {
  found,
  at_low,  ///< at an end of its range
  at_high,
  without_effect,  ///< the model's lobes do not change with it
  undetermined     ///< together with others it changes nothing that these lobes show
};
/// "found", "at its lowest", "at its highest", "no effect", "undetermined"
[[nodiscard]] std::string to_text(FreeState state);

struct FittedNumber {
  FreeNumber number;
  double value = 0;
  FreeState state = FreeState::found;
  /// One standard deviation from the Jacobian J of the residuals, as if what is left over were
  /// independent from cell to cell: root of the diagonal of (J^T J)^-1 s^2, s^2 the squares left
  /// over per degree of freedom. Infinite where the number is not determined; at an end of the
  /// range, 0: it is held there.
  double deviation = 0;
  /// The part that the truth's own error makes: one standard error, or, where the truth has bounds,
  /// the most that they allow, to first order.
  double of_truth = 0;
};

/// What a fit leaves over of one lobe.
struct FittedLobe {
  Direction wi{};
  bool reflected = true;
  double energy_truth = 0, energy_model = 0;  ///< luminance (Rec. 709), deltas apart
  double energy_missing = 0;                  ///< of the truth, at most, as walks were cut
  double relative_rmse = 0;                   ///< over cells and channels
  double noise = 0;                           ///< the truth's part of relative_rmse
};

struct ModelFit {
  const ModelInfo* info = nullptr;  ///< none: a stack was fitted
  ModelRequest request;             ///< complete, six digits; sources: "given", "fitted", "default"
  std::vector<FittedNumber> numbers;
  std::vector<double> scaled;      ///< the same, scaled to [0, 1]
  std::vector<double> covariance;  ///< [number][number], as deviation; 0 where one is not `found`
  std::vector<FittedLobe> lobes;
  double misfit = 0;         ///< in the norm that was made least
  double relative_rmse = 0;  ///< FitNorm::relative, whichever was made least
  double noise = 0;          ///< the truth's part of it
  double relative_rmse_without_noise = 0;
  int starts = 0, agreeing = 0;  ///< searches, and those that ended at the same misfit
  int iterations = 0;
  std::string stack{};  ///< the fitted stack's file, and by what its lobes were found
  std::string estimator{};
  std::vector<RunResult> runs{};  ///< of a stack: its lobes, per incident direction of the target
};

/// The least of the subject's searches, without `info`, `request` and what is said of stacks.
/// Throws UsageError where the subject has no values at all.
[[nodiscard]] ModelFit fit_subject(const FitSubject& subject, const FitTarget& target, FitNorm norm,
                                   const StopFlag* stop);

/// The least of kStarts searches: from the model's defaults, and from those of kTried points,
/// spread evenly over the ranges, that are nearest. Each search asks for 2 x 2 points in a cell;
/// the best goes on with 4 x 4, then with what the exact projection (judge/projection.h) adds to
/// those. Equal input gives equal output, for any number of threads. Throws UsageError where the
/// model gives no values at all; stops between steps where the flag is set, with the best so
/// far.
[[nodiscard]] ModelFit fit_model(const ParametricModel& model, const FitTarget& target,
                                 FitNorm norm, Isa isa, const StopFlag* stop);
inline constexpr int kStarts = 4, kTried = 24;

}  // namespace lamella
