#include "compare/judge/statistics.h"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

namespace lamella {

Means means_of(const BatchSums& sums) {
  const int n = sums.batches(), quantities = sums.quantities();
  const double walks = std::accumulate(sums.walks.begin(), sums.walks.end(), 0.0);
  Means means{std::vector<double>(quantities), std::vector<double>(quantities)};
  for (int k = 0; k < quantities; ++k) {
    double sum = 0, variance = 0;
    for (int b = 0; b < n; ++b) sum += sums.sums[b][k];
    means.value[k] = sum / walks;
    for (int b = 0; b < n; ++b) {
      const double excess = sums.sums[b][k] - means.value[k] * sums.walks[b];
      variance += excess * excess;
    }
    means.standard_error[k] = std::sqrt(variance * n / (n - 1.0)) / walks;
  }
  return means;
}

BatchSums grouped(const BatchSums& sums, const std::vector<int>& group, int groups) {
  BatchSums out{sums.walks, {}};
  for (const auto& batch : sums.sums) {
    std::vector<double> row(groups);
    for (std::size_t k = 0; k < batch.size(); ++k)
      if (group[k] >= 0) row[group[k]] += batch[k];
    out.sums.push_back(std::move(row));
  }
  return out;
}

std::vector<int> pooled_groups(const BatchSums& sums, double events) {
  const int n = sums.batches(), quantities = sums.quantities();
  const double walks = std::accumulate(sums.walks.begin(), sums.walks.end(), 0.0);
  std::vector<int> group(quantities, -1);
  std::vector<double> running(n);
  int current = 0, first = 0;
  for (int k = 0; k < quantities; ++k) {
    double total = 0, variance = 0;
    for (int b = 0; b < n; ++b) {
      running[b] += sums.sums[b][k];
      total += running[b];
    }
    for (int b = 0; b < n; ++b) {
      const double excess = running[b] - total * sums.walks[b] / walks;
      variance += excess * excess;
    }
    if (total > 0 && total * total >= events * variance) {
      for (int j = first; j <= k; ++j) group[j] = current;
      ++current;
      first = k + 1;
      std::fill(running.begin(), running.end(), 0.0);
    }
  }
  if (current > 0)
    for (int j = first; j < quantities; ++j) group[j] = current - 1;
  return group;
}

double hotelling_p_value(const BatchSums& sums, const std::vector<double>& expected,
                         const std::vector<double>& uncertainty) {
  const int n = sums.batches(), quantities = sums.quantities();
  if (quantities == 0) return 1;
  const double walks = std::accumulate(sums.walks.begin(), sums.walks.end(), 0.0);
  const Means means = means_of(sums);
  // Scaled by the standard errors, the covariance becomes a correlation: rank is then a matter of
  // eigenvalues against 1.
  Eigen::MatrixXd scaled(n, quantities);
  Eigen::VectorXd difference(quantities);
  Eigen::MatrixXd given = Eigen::MatrixXd::Zero(quantities, quantities);
  for (int k = 0; k < quantities; ++k) {
    const double error = std::hypot(means.standard_error[k], uncertainty[k]);
    const double scale = error > 0 ? 1 / error : 0;
    given(k, k) = scale * uncertainty[k] * scale * uncertainty[k];
    for (int b = 0; b < n; ++b)
      scaled(b, k) = scale * (sums.sums[b][k] - means.value[k] * sums.walks[b]);
    difference(k) = scale * (means.value[k] - expected[k]);
  }
  const Eigen::MatrixXd covariance =
      scaled.transpose() * scaled * (n / (n - 1.0) / (walks * walks)) + given;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  double t2 = 0;
  int rank = 0;
  for (int k = 0; k < quantities; ++k) {
    const double lambda = eigen.eigenvalues()(k);
    if (lambda < 1e-9 * quantities) continue;
    const double component = eigen.eigenvectors().col(k).dot(difference);
    t2 += component * component / lambda;
    ++rank;
  }
  if (rank == 0 || rank >= n - 1) return 1;
  const double f = t2 * (n - rank) / (rank * (n - 1.0));
  return boost::math::cdf(complement(boost::math::fisher_f(rank, n - rank), f));
}

double largest_deviation_p_value(const Means& means, const std::vector<double>& expected,
                                 const std::vector<double>& uncertainty, int batches,
                                 const std::vector<double>& missing) {
  double largest = 0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    const double too_low = expected[k] - means.value[k];
    const double difference =
        too_low > 0 ? std::max(0.0, too_low - (missing.empty() ? 0 : missing[k])) : -too_low;
    const double error = std::hypot(means.standard_error[k], uncertainty[k]);
    if (error > 0)
      largest = std::max(largest, difference / error);
    else if (difference > 1e-12 * std::abs(expected[k]))
      return 0;
  }
  const boost::math::students_t t(batches - 1.0);
  return std::min(
      1.0, 2 * boost::math::cdf(complement(t, largest)) * static_cast<double>(expected.size()));
}

double sidak_level(double false_alarm, std::size_t tests) {
  return -std::expm1(std::log1p(-false_alarm) / static_cast<double>(tests));
}

double chi_square_p_value(const std::vector<double>& observed, const std::vector<double>& expected,
                          const std::vector<double>& uncertainty) {
  constexpr double kEnough = 10;
  double statistic = 0, o = 0, e = 0, u = 0;
  int cells = 0;
  for (std::size_t k = 0; k < observed.size(); ++k) {
    if (!std::isfinite(expected[k])) return 0;
    o += observed[k];
    e += expected[k];
    u += uncertainty[k];
    if (e < kEnough) continue;
    const double off = std::max(0.0, std::abs(o - e) - u);
    statistic += off * off / e;
    ++cells;
    o = e = u = 0;
  }
  // Poisson counts above their mean by eight deviations and eight more do not occur.
  if (o > e + u + 8 * std::sqrt(std::max(e, 0.0)) + 8) return 0;
  if (cells == 0) return 1;
  return boost::math::cdf(complement(boost::math::chi_squared(cells), statistic));
}

}  // namespace lamella
