#include "tests/analytic/model/successive_orders.h"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "phase/medium/lambert_sphere.h"

namespace lamella::testing {

FourierKernel three_term_kernel(const ThreeTermPhase& w) {
  return [w](int m, double x, double y) { return three_term_fourier(w, m, x, y); };
}

FourierKernel lambert_sphere_kernel(double albedo) {
  return [albedo](int m, double x, double y) {
    constexpr int kPoints = 128;
    const double s = std::sqrt((1 - x) * (1 + x) * (1 - y) * (1 + y));
    double sum = 0;
    for (int k = 0; k < kPoints; ++k) {
      const double phi = (k + 0.5) * kPi / kPoints;
      const double cosine = std::clamp(x * y + s * std::cos(phi), -1.0, 1.0);
      sum += lambert_sphere_phase(cosine) * std::cos(m * phi);
    }
    return albedo * (m == 0 ? 1 : 2) * sum / kPoints;
  };
}

SuccessiveOrders::SuccessiveOrders(const FourierKernel& kernel, int m, int orders)
    : scale_((m % 2 ? -1 : 1) * (m == 0 ? 1 : 2) / (4 * kPi)) {
  using Rule = boost::math::quadrature::gauss<double, 24>;
  std::vector<double> weight;
  for (std::size_t k = 0; k < Rule::abscissa().size(); ++k)
    for (const double side : {-1.0, 1.0}) {
      const double v = (1 + side * Rule::abscissa()[k]) / 2;
      z_.push_back(v * v * v);
      weight.push_back(Rule::weights()[k] / 2 * 3 * v * v);
    }
  const int n = static_cast<int>(z_.size());
  // The mode of p that convolves: half of the cosine coefficient for m > 0, times 4 pi.
  const double fold = 4 * kPi / (m == 0 ? 1 : 2);
  Eigen::MatrixXd forward(n, n), back(n, n), denominator(n, n);
  Eigen::VectorXd z(n), q(n);
  for (int i = 0; i < n; ++i) {
    z[i] = z_[i];
    q[i] = weight[i];
    for (int j = 0; j < n; ++j) {
      forward(i, j) = fold * kernel(m, z_[i], z_[j]);
      back(i, j) = fold * kernel(m, z_[i], -z_[j]);
      denominator(i, j) = z_[i] + z_[j];
    }
  }
  const Eigen::MatrixXd weighted_forward = q.asDiagonal() * forward;
  const Eigen::MatrixXd weighted_back = q.asDiagonal() * back * q.asDiagonal();
  t_.push_back(back.cwiseQuotient(denominator));
  for (int order = 2; order <= orders; ++order) {
    const Eigen::MatrixXd& last = t_.back();
    Eigen::MatrixXd sum = 0.5 * (z.asDiagonal() * last * weighted_forward +
                                 (z.asDiagonal() * last * weighted_forward).transpose());
    Eigen::MatrixXd pairs = Eigen::MatrixXd::Zero(n, n);
    for (int j = 1; j + 2 <= order; ++j) pairs += t_[j - 1] * weighted_back * t_[order - j - 2];
    sum += 0.25 * (z.asDiagonal() * pairs * z.asDiagonal());
    t_.push_back(sum.cwiseQuotient(denominator));
  }
}

double SuccessiveOrders::sum(int i, int j, int first) const {
  double total = 0;
  for (std::size_t n = first - 1; n < t_.size(); ++n) total += t_[n](i, j);
  return scale_ * total;
}

}  // namespace lamella::testing
