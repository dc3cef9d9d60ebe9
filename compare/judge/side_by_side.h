#pragma once

#include <string>
#include <vector>

#include "analytic/model/model.h"
#include "compare/request/interrupt.h"
#include "compare/request/truth_request.h"

namespace lamella {

/// The relative error of a lobe on cells, as in LobeComparison: the root of the mean squared
/// difference, the noise of both removed, over the root mean square of the truth, its noise
/// removed; and the noise over the same root mean square. Differences below about half the noise
/// are not seen. Both are infinite where the truth is 0 and the other is not.
struct RelativeError {
  double rmse = 0, noise = 0;
};

/// `other_error`: standard errors of the other, empty if it has none. All per cell.
/// `missing_square`: the amount that light of cut walks may add to the sum of the cells' squares.
/// It counts as noise but is not removed from the difference, as its sign is unknown.
[[nodiscard]] RelativeError relative_error(const LobeEstimate& truth,
                                           const std::vector<double>& other,
                                           const std::vector<double>& other_error = {},
                                           double missing_square = 0);

/// Explicit geometry, a medium that stands for it, and a closed form of that medium: one lobe of
/// the reflected light. Three errors: of the medium against the geometry, of the closed form
/// against the medium, and of the closed form against the geometry.
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
/// request's stack. `stop`, once set, leaves out the runs that have not begun.
[[nodiscard]] std::vector<SideBySide> side_by_side(const TruthRequest& request,
                                                   const std::vector<RunResult>& runs,
                                                   const StopFlag* stop);

[[nodiscard]] std::string side_by_side_table(const std::vector<SideBySide>& rows);

}  // namespace lamella
