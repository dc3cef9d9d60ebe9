#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "phase/math/direction.h"
#include "phase/random/random.h"

namespace lamella::testing {

/// The probability with which any statistical test of the whole suite may fail by chance, and the
/// number of tests that share the budget (Sidak). Seeds are fixed, so a pass stays a pass.
inline constexpr double kFalseAlarmBudget = 1e-3;
inline constexpr int kStatisticalTests = 4000;

/// The significance level of one test: 1 - (1 - budget)^(1 / tests).
[[nodiscard]] double test_level();

/// |z| that a standard normal exceeds with probability `level`, two-sided.
[[nodiscard]] double normal_quantile(double level);

/// p-value of Pearson's chi-square for observed against expected counts; neighbouring cells are
/// pooled until each expects at least 10.
[[nodiscard]] double chi_square_p_value(const std::vector<double>& observed,
                                        const std::vector<double>& expected);

/// Cells of the sphere about an axis, in two coordinates in [0, 1]: one for the angle with the
/// axis, half of it within about `width` radians, so that a narrow lobe along the axis fills many
/// cells (infinite: equal steps in mu); one for the azimuth, half of it within `azimuth_width` of
/// the plane through `towards` (1: equal steps).
struct SphereCells {
  Direction axis;
  double width = std::numeric_limits<double>::infinity();
  Direction towards = frame_around(axis).s;
  double azimuth_width = 1;
  int rows = 12, columns = 12;
  /// A few points per cell instead of adaptive quadrature: for costly densities that are smooth.
  bool smooth = false;
};

/// Draws `samples` directions and compares their counts in the cells with the integral of the
/// density over each cell. Returns the p-value; on failure (p below test_level()) writes the table
/// of cells to stderr under `name`.
[[nodiscard]] double sampler_p_value(const std::string& name, const SphereCells& cells,
                                     const std::function<Direction(RandomStream&)>& sample,
                                     const std::function<double(Direction)>& density,
                                     int samples = 200000, std::uint64_t seed = 1);

/// The same over 12 x 12 cells of equal steps in mu and phi about `axis`.
[[nodiscard]] double sampler_p_value(const std::string& name, Direction axis,
                                     const std::function<Direction(RandomStream&)>& sample,
                                     const std::function<double(Direction)>& density,
                                     int samples = 200000, std::uint64_t seed = 1);

/// Two-sided p-value of a sample mean against its expectation, by the normal limit.
[[nodiscard]] double mean_p_value(const std::vector<double>& values, double expectation);

/// Integral of a density over the sphere by quadrature in the coordinates of the cells: adaptive,
/// or Gauss rules in each cell where they are smooth.
[[nodiscard]] double integrate_sphere(const std::function<double(Direction)>& density,
                                      const SphereCells& cells, double tolerance = 1e-8);

/// The same about `axis`, adaptive, without any narrow lobe.
[[nodiscard]] double integrate_sphere(const std::function<double(Direction)>& density,
                                      Direction axis, double tolerance = 1e-8);

}  // namespace lamella::testing
