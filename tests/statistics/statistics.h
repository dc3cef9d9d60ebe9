#pragma once

#include <functional>
#include <string>
#include <vector>

#include "phase/direction.h"
#include "phase/random.h"

namespace lamella::testing {

/// The probability with which any statistical test of the whole suite may fail by chance, and the
/// number of such tests that it is shared by (Sidak). Seeds are fixed, so a pass stays a pass.
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

/// Draws `samples` directions and compares their counts in cells of the sphere (equal steps in mu
/// and phi about `axis`) with the integral of the density over each cell. Returns the p-value; on
/// failure (p below test_level()) writes the table of cells to stderr under `name`.
[[nodiscard]] double sampler_p_value(const std::string& name, Direction axis,
                                     const std::function<Direction(RandomStream&)>& sample,
                                     const std::function<double(Direction)>& density,
                                     int samples = 200000, std::uint64_t seed = 1);

/// Integral of a density over the sphere by adaptive quadrature in mu and phi about `axis`.
[[nodiscard]] double integrate_sphere(const std::function<double(Direction)>& density,
                                      Direction axis, double tolerance = 1e-8);

}  // namespace lamella::testing
