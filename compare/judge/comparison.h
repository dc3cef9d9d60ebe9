#pragma once

#include <string>
#include <vector>

#include "compare/judge/projection.h"
#include "volume/run/simulation.h"

namespace lamella {

enum class Verdict { agrees, differs, insufficient };

[[nodiscard]] std::string to_text(Verdict verdict);

/// A closed form against the truth, on one lobe: one incident direction, side and order.
/// Cells have equal projected solid angles, so plain means over cells are means over the lobe.
struct LobeComparison {
  Direction wi{};
  bool reflected = true;
  Order order = Order::all;
  std::vector<double> energy_truth, energy_error, energy_model;  ///< per channel
  /// Per channel, how much energy_truth may be too low, as walks were cut (missing_light.h).
  std::vector<double> energy_missing;
  double rmse = 0;                ///< root of the mean squared difference [1/sr], all channels
  double relative_rmse = 0;       ///< over the root mean square of the truth; inf if that is 0
  double rmse_without_noise = 0;  ///< with the variance of the noise removed, a stochastic model's
                                  ///< own too; 0 if that exceeds it
  double relative_rmse_without_noise = 0;
  /// Between these lies relative_rmse_without_noise, wherever the missing light belongs; both are
  /// equal to it where none is missing.
  double relative_rmse_least = 0, relative_rmse_most = 0;
  double rmse_most = 0;  ///< the RMSE without noise that goes with relative_rmse_most [1/sr]
  double max_error = 0;  ///< largest |difference| of a cell, noise included [1/sr]
  double p_value = 1;    ///< of the hypothesis that model and truth are the same
  int empty_cells = 0;   ///< of the truth: no standard error, pooled in the test
  bool bounded = false;  ///< the truth has error bounds in place of standard errors, no noise
  Verdict verdict = Verdict::agrees;

  // The maps, [channel][cell].
  std::vector<double> truth, standard_error, model;
  std::vector<double> model_error;  ///< standard errors of a stochastic model; else empty
  /// The projection's error beyond kProjectionTolerance, per cell; empty if there is none.
  std::vector<double> projection_error;

  /// The sum over cells and channels of projection_error over that of |model|, 0 if nothing is
  /// open.
  [[nodiscard]] double open_share() const;
  /// Whether walks were cut whose light may have belonged to this lobe.
  [[nodiscard]] bool is_cut() const;
  /// (model - truth) / the standard error of both; 0 in cells without one.
  [[nodiscard]] std::vector<double> z() const;
};

/// Compares a projected model with every lobe it stands for and the lobe "all" of one run, of which
/// `simulation` holds the walks. Where order 1 is exact its lobe has error bounds, and the lobes
/// with it are tested by what walks have of them, against the model less order 1. Without a
/// simulation the run has error bounds: the p-value is 1 where every cell of the model is within
/// the bound and its own projection error, else 0, and there is no noise to remove. A stochastic
/// model's noise is removed like the truth's, and counts in the p-value with its covariance over
/// cells; against bounds the p-value is then a test's, each cell known to its bound. Where walks
/// were cut the hypothesis is that model and truth are the same wherever the missing light belongs:
/// means that are too low by no more than the missing light do not count, and Hotelling's test,
/// which is not one-sided, gives way to the largest deviation of a patch or of the whole lobe.
/// Verdicts are left at `agrees` until `decide` has seen all comparisons of a report.
[[nodiscard]] std::vector<LobeComparison> compare(const RunResult& run,
                                                  const Simulation* simulation,
                                                  const ProjectedLobes& model, bool reflected);

/// Probability that a report with only true models calls one of them different.
inline constexpr double kReportFalseAlarm = 0.01;

/// The relative RMSE within which a model `agrees`.
inline constexpr double kAgreesWithin = 0.1;

/// Sets the verdicts: `differs` if the p-value is below the level that the report's lobes share
/// (Sidak), `insufficient` if it is not but the noise, the bound or the missing light could hide a
/// relative RMSE of kAgreesWithin, else `agrees`.
void decide(const std::vector<LobeComparison*>& lobes);

}  // namespace lamella
