#pragma once

#include <string>
#include <vector>

#include "compare/judge/side_by_side.h"
#include "compare/request/run_monitor.h"
#include "compare/request/truth_request.h"

namespace lamella {

/// A height field beside Smith's surface of the same slopes, whose heights neighbours do not share:
/// one lobe of the light that white mirrors reflect.
struct SmithDifference {
  Direction wi{};
  Order order = Order::all;
  double energy_field = 0, energy_field_error = 0;
  double energy_smith = 0, energy_smith_error = 0;
  RelativeError cells;  ///< of Smith's surface, the height field being the truth
};

/// Walks on both surfaces, as many as the request says, for order 1 and for all orders of each
/// incident direction. Throws UsageError where the request's stack is no height field of mirrors,
/// or where light comes from below. Fewer rows once the monitor is stopped.
[[nodiscard]] std::vector<SmithDifference> smith_difference(const TruthRequest& request,
                                                            const RunMonitor& monitor);

[[nodiscard]] std::string smith_difference_table(const std::vector<SmithDifference>& rows);

}  // namespace lamella
