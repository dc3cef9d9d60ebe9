#pragma once

#include <cstddef>
#include <vector>

namespace lamella {

/// Sums per batch of some quantities, with the batches' numbers of walks: the data of a test of
/// correlated estimates. sums[b][k]: quantity k in batch b.
struct BatchSums {
  std::vector<double> walks;
  std::vector<std::vector<double>> sums;

  [[nodiscard]] int batches() const { return static_cast<int>(sums.size()); }
  [[nodiscard]] int quantities() const {
    return sums.empty() ? 0 : static_cast<int>(sums[0].size());
  }
};

/// Mean per walk and standard error of every quantity.
struct Means {
  std::vector<double> value, standard_error;
};
[[nodiscard]] Means means_of(const BatchSums& sums);

/// Quantities summed in groups: group[k] is the group of quantity k, or -1 to leave it out.
[[nodiscard]] BatchSums grouped(const BatchSums& sums, const std::vector<int>& group, int groups);

/// Groups of neighbouring quantities, each with at least `events` effective events ((mean /
/// standard error)^2), so that its mean is near enough to normal; remaining quantities join the
/// last group. Returns the group of each quantity; the number of groups is 1 + the largest, 0 if
/// all together are too few.
[[nodiscard]] std::vector<int> pooled_groups(const BatchSums& sums, double events);

/// Hotelling's test of the means against given values, known to +-uncertainty each: uses the
/// covariance over batches, so that quantities may be correlated in any way, with the squared
/// uncertainties added (next-event estimates of neighbours share nearly all of their noise, and
/// their differences are known far better than the values). Directions in which nothing varies are
/// left out. Returns a p-value; 1 if nothing varies.
[[nodiscard]] double hotelling_p_value(const BatchSums& sums, const std::vector<double>& expected,
                                       const std::vector<double>& uncertainty);

/// p-value of the largest |difference| over the quantities in units of its error (standard error
/// and uncertainty of the given value together), by Student's t with Bonferroni's bound, which
/// holds under any correlation. A quantity without any error counts as infinitely far off if it
/// differs at all (beyond rounding), else as exact. `missing`, if not empty: how much each mean may
/// be too low by itself, which is no deviation.
[[nodiscard]] double largest_deviation_p_value(const Means& means,
                                               const std::vector<double>& expected,
                                               const std::vector<double>& uncertainty, int batches,
                                               const std::vector<double>& missing = {});

/// The level of each of `tests` independent tests at which the probability that any of them rejects
/// a true hypothesis is `false_alarm` (Sidak 1967): 1 - (1 - false_alarm)^(1/tests).
[[nodiscard]] double sidak_level(double false_alarm, std::size_t tests);

/// p-value of Pearson's chi-square for counts against expected ones that are known to
/// +-uncertainty, by which each difference is reduced. Neighbouring cells are pooled until each
/// expects 10; a rest that expects less may only show counts where none belong. Expected numbers
/// that are not finite have the p-value 0. Of counts of a multinomial law the p-value is too large
/// by less than one degree of freedom's worth, as their sum is taken to be free.
[[nodiscard]] double chi_square_p_value(const std::vector<double>& observed,
                                        const std::vector<double>& expected,
                                        const std::vector<double>& uncertainty);

}  // namespace lamella
