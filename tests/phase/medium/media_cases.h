#pragma once

#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include "phase/medium/medium.h"
#include "phase/parameters/parameters.h"
#include "tests/statistics/statistics.h"

namespace lamella::testing {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A medium at one setting, and what the tests need to know of its lobes.
struct MediumCase {
  std::string name;
  Medium medium;
  Direction axis{0, 0, 1};  ///< mean normal, or fiber direction
  double roughness = 1;     ///< width in radians of the distribution of normals
  bool fiber = false;       ///< mirror lobes are rings about the axis
  bool costly = false;      ///< phase() is a quadrature
};

/// How a failed test names its case.
inline void PrintTo(const MediumCase& c, std::ostream* out) { *out << c.name; }

/// A mean normal that is neither vertical nor in a coordinate plane.
inline const Direction kTilted = normalized(Direction{0.4, -0.3, 0.8});

/// S with eigenvalues 1, 0.3 and 0.05 along axes that are no coordinate axes.
[[nodiscard]] std::array<double, 6> tilted_matrix();

/// Every medium at both ends of its roughness and in between, axes vertical and tilted.
[[nodiscard]] std::vector<MediumCase> media_cases();

/// Incident directions from normal to grazing on both sides.
[[nodiscard]] std::vector<Direction> incident_directions();

/// Whether light from w_i meets anything: not at the back of flakes that are all alike.
[[nodiscard]] bool scatters(const MediumCase& c, Direction wi);

/// Cells in which the lobe of p(w_i -> .) is resolved.
[[nodiscard]] SphereCells lobe_cells(const MediumCase& c, Direction wi);

[[nodiscard]] std::string to_text(Direction w);

}  // namespace lamella::testing
