#pragma once

#include <string>
#include <vector>

#include "analytic/model/model.h"
#include "compare/request/interrupt.h"
#include "compare/request/truth_request.h"

namespace lamella {

/// The relative root mean square difference of a lobe on cells from a reference, the noise that
/// both carry removed, and that noise, relative too: below about half of it a difference is not
/// seen.
struct RelativeError {
  double rmse = 0, noise = 0;
};

/// `reference_error`: standard errors of the reference, empty if it has none. All per cell.
[[nodiscard]] RelativeError relative_error(const LobeEstimate& truth,
                                           const std::vector<double>& reference,
                                           const std::vector<double>& reference_error = {});

/// Explicit geometry, a medium that stands for it, and a closed form of that medium: one lobe of
/// the reflected light. Errors are relative root mean square differences over the cells, without
/// noise: what the medium leaves out of the geometry, and what the form leaves out of the medium.
struct SideBySide {
  Direction wi{};
  std::string medium;  ///< its layer's
  std::string model;   ///< empty: no closed form of that medium stands for this order
  Order order = Order::all;
  double energy_geometry = 0, energy_medium = 0, energy_model = 0;  ///< luminance (Rec. 709)
  RelativeError medium_error;                                       ///< geometry against medium
  RelativeError model_error;                                        ///< medium against model
  RelativeError total_error;                                        ///< geometry against model
};

/// Measures the geometry, walks the media that can stand for it (volume/grains/grain_measure.h) and
/// projects the closed forms that apply to those, for each of the runs among the grains of the
/// request's stack. `stop`, once set, leaves out what is still to be had.
[[nodiscard]] std::vector<SideBySide> side_by_side(const TruthRequest& request,
                                                   const std::vector<RunResult>& runs,
                                                   const StopFlag* stop);

[[nodiscard]] std::string side_by_side_table(const std::vector<SideBySide>& rows);

}  // namespace lamella
