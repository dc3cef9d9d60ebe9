#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analytic/model/model.h"
#include "compare/files/exr_image.h"
#include "compare/library/library_stacks.h"
#include "compare/report/lobe_set.h"
#include "compare/request/run_monitor.h"
#include "compare/request/truth_request.h"

namespace lamella {

/// How a part of an entry was found, and how well.
struct ReferenceMethod {
  /// "adding-doubling" or "harmonics" (bounds), "analog" or "next-event" (standard errors).
  std::string name{};
  std::string reason{};  ///< why walks, where they are
  double tolerance = 0;  ///< that the solver was asked for; of walks 0
  /// Of lobes by the solver: the bound relative to the mean over the azimuth; by walks: the largest
  /// relative standard error of an energy above 1e-3. Of points: the largest bound or standard
  /// error relative to f, where that is above 1e-6 of the brightest.
  double error = 0;
  std::uint64_t walks = 0;  ///< per direction, the fewest of them; 0 from the solver

  [[nodiscard]] bool is_bounded() const { return walks == 0; }
  /// Of the solver: whether the bound is within the tolerance.
  [[nodiscard]] bool reached() const { return error <= tolerance; }
};

/// An entry of the library: lobes of every order on cells, and f at pairs of directions.
struct Reference {
  LobeSet set{};  ///< lobes and energies with bounds or standard errors
  /// Per [direction][channel], the energy that all lobes together may lack, as walks were cut
  /// (judge/missing_light.h); empty if there is none.
  std::vector<double> unresolved{};
  std::vector<DirectionPair> pairs{};
  std::vector<Rgb> f, f_error;  ///< [1/sr], per pair
  ReferenceMethod lobe_method{}, point_method{};
};

/// What an entry may cost.
struct ReferenceEffort {
  double tolerance = 1e-6;        ///< of lobes, relative to the mean over the azimuth
  double point_tolerance = 1e-8;  ///< of points
  double seconds = 120;           ///< of lobes and points together, nearly
  std::uint64_t walks = 4000000;  ///< per incident direction, where the solver does not apply
  std::uint64_t seed = 1;
  Isa isa = Isa::scalar;
  CellGrid cells{.mu_cells = 8, .phi_cells = 16};
  /// Walks in the place of the solver: verification by another method.
  bool walks_only = false;
};

/// Pairs of an entry: four directions above for each incident direction and, of a stack that is
/// open below, two below.
[[nodiscard]] std::vector<DirectionPair> library_pairs(const Stack& stack);

/// Finds an entry: by the solver where it applies and has an answer that walks do not better, else
/// by walks, which the time may end early. Nothing where the monitor stopped it. `image`, if there
/// is one, becomes the lobes as an EXR file has them.
[[nodiscard]] std::optional<Reference> find_reference(const Stack& stack,
                                                      const ReferenceEffort& effort,
                                                      const RunMonitor& monitor,
                                                      ExrImage* image = nullptr);

/// The entry as a NumPy archive: that of lobe_npz with "points.wi", "points.wo" [n, 3], "points.f",
/// "points.error" [n, channels], "energy.SIDE.NAME" and "energy.SIDE.NAME.se" [direction, channel],
/// and "unresolved" [direction, channel].
[[nodiscard]] std::string reference_npz(const Reference& reference);
/// Reads it back, methods apart. Throws FormatError.
[[nodiscard]] Reference reference_of_npz(const std::string& bytes, const std::string& file);

/// The points as CSV: directions as mu and phi in degrees, then f and error per channel, with 17
/// digits.
[[nodiscard]] std::string reference_csv(const Reference& reference);

}  // namespace lamella
