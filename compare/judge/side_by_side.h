#pragma once

#include <string>
#include <vector>

#include "analytic/model/model.h"
#include "compare/request/interrupt.h"
#include "compare/request/truth_request.h"

namespace lamella {

/// How far a lobe on cells is from a truth, as LobeComparison has it: the root of the mean squared
/// difference, the noise that both carry removed, over the root mean square of the truth, its noise
/// removed. And that noise over the same: below about half of it a difference is not seen. Both
/// infinite where the truth is 0 and the other is not.
struct RelativeError {
  double rmse = 0, noise = 0;
};

/// `other_error`: standard errors of the other, empty if it has none. All per cell.
/// `missing_square`: what light that cut walks held may add to the sum of the cells' squares; it
/// counts as noise of unknown sign: the difference keeps it.
[[nodiscard]] RelativeError relative_error(const LobeEstimate& truth,
                                           const std::vector<double>& other,
                                           const std::vector<double>& other_error = {},
                                           double missing_square = 0);

/// Explicit geometry, a medium that stands for it, and a closed form of that medium: one lobe of
/// the reflected light. What the medium leaves out of the geometry, what the form leaves out of the
/// medium, and what it leaves out of the geometry, which is the truth of the first and the last.
struct SideBySide {
  Direction wi{};
  std::string medium;  ///< its layer's
  std::string model;   ///< empty: no closed form of that medium stands for this order
  Order order = Order::all;
  double energy_geometry = 0, energy_medium = 0, energy_model = 0;  ///< luminance (Rec. 709)
  double energy_missing = 0;  ///< that either of the first two may be too low by, as walks were cut
  RelativeError medium_error;  ///< of the medium, geometry being the truth
  RelativeError model_error;   ///< of the model, the medium being the truth
  RelativeError total_error;   ///< of the model, geometry being the truth
};

/// Measures the geometry, walks the media that can stand for it (volume/grains/grain_measure.h) and
/// projects the closed forms that apply to those, for each of the runs among the grains of the
/// request's stack. `stop`, once set, leaves out what is still to be had.
[[nodiscard]] std::vector<SideBySide> side_by_side(const TruthRequest& request,
                                                   const std::vector<RunResult>& runs,
                                                   const StopFlag* stop);

[[nodiscard]] std::string side_by_side_table(const std::vector<SideBySide>& rows);

}  // namespace lamella
