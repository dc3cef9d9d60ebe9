#include "analytic/half_space/h_function.h"

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "phase/math/direction.h"

namespace lamella {
namespace {

constexpr double kStep = 0.25;
constexpr double kRange = 38;  // exp(-38) = 3e-17

}  // namespace

HFunction::HFunction(std::vector<double> psi, double k0) : psi_(std::move(psi)), k0_(k0) {
  const int n = static_cast<int>(kRange / kStep);
  for (int j = -n; j <= n; ++j) {
    t_.push_back(std::exp(j * kStep));
    log_k_.push_back(log_k(t_.back()));
  }
  std::array<double, kTerms> values{};
  for (int j = 0; j < kTerms; ++j) {
    const double v = (1 + std::cos(kPi * (j + 0.5) / kTerms)) / 2;
    values[j] = by_quadrature(v * v * v * v);
  }
  for (int k = 0; k < kTerms; ++k) {
    double sum = 0;
    for (int j = 0; j < kTerms; ++j) sum += values[j] * std::cos(kPi * k * (j + 0.5) / kTerms);
    series_[k] = (k == 0 ? 1.0 : 2.0) / kTerms * sum;
  }
}

double HFunction::characteristic(double x) const {
  double sum = 0;
  for (std::size_t k = psi_.size(); k-- > 0;) sum = sum * x * x + psi_[k];
  return sum;
}

// With I_k the integral of x^(2k) / (1 + x^2 t^2): 1 / (2k + 1) - I_k = t^2 I_(k+1), so
// K = K(0) + 2 sum psi_k t^2 I_(k+1), in which nothing cancels as t -> 0.
double HFunction::log_k(double t) const {
  const int n = static_cast<int>(psi_.size());
  double sum = 0;
  if (t < 0.5) {
    // Downward, errors shrink by t^2 <= 1/4 per step.
    constexpr int kExtra = 30;
    double next = 1.0 / (2 * (n + kExtra) + 1);
    for (int k = n + kExtra; k-- > 1;) {
      next = 1.0 / (2 * k + 1) - t * t * next;
      if (k <= n) sum += psi_[k - 1] * next;
    }
    sum *= t * t;
  } else {
    double integral = std::atan(t) / t;
    for (int k = 0; k < n; ++k) {
      const double rest = 1.0 / (2 * k + 1) - integral;
      sum += psi_[k] * rest;
      integral = rest / (t * t);
    }
  }
  const double k = k0_ + 2 * sum;
  return std::log(k);
}

double HFunction::by_quadrature(double mu) const {
  double sum = 0;
  for (std::size_t j = 0; j < t_.size(); ++j) {
    const double x = mu * t_[j];
    sum += log_k_[j] * x / (1 + x * x);
  }
  return std::exp(-kStep / kPi * sum);
}

double HFunction::operator()(double mu) const {
  const double x = 4 * std::sqrt(std::sqrt(mu)) - 2;  // twice the argument in [-1, 1]
  double b1 = 0, b2 = 0;                              // Clenshaw
  for (int k = kTerms - 1; k > 0; --k) {
    const double b = series_[k] + x * b1 - b2;
    b2 = b1;
    b1 = b;
  }
  return series_[0] + x / 2 * b1 - b2;
}

double HFunction::moment(int k) const {
  const auto integrand = [&](double v) {
    const double v2 = v * v;
    return 4 * v * v2 * std::pow(v2 * v2, k) * by_quadrature(v2 * v2);
  };
  return boost::math::quadrature::gauss<double, 40>::integrate(integrand, 0.0, 1.0);
}

HFunction isotropic_h(double albedo) { return {{albedo / 2}, 1 - albedo}; }

double isotropic_h_hapke_1981(double mu, double albedo) {
  return 1 + hapke_1981_rise(mu, std::sqrt(1 - albedo));
}

double isotropic_h_hapke_2002(double mu, double albedo) {
  if (mu == 0) return 1;
  const double s = std::sqrt(1 - albedo);
  const double r = (1 - s) / (1 + s);
  return 1 / (1 - albedo * mu * (r + (0.5 - r * mu) * std::log1p(1 / mu)));
}

}  // namespace lamella
