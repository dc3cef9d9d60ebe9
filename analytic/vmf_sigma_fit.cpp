#include "analytic/vmf_sigma_fit.h"

#include <algorithm>
#include <cmath>

#include "phase/vmf.h"

namespace lamella {

double vmf_sigma_fit_smooth(double u, double alpha) {
  if (alpha == 0) return std::max(0.0, u);
  const double a2 = alpha * alpha;
  const double tanh = std::tanh(1 / a2);
  const double small = tanh * (u - a2 * std::abs(u)) - (a2 + 2) * u + u / tanh;
  const double width = alpha * std::sqrt((1 - u) * (1 + u));
  const double x = u / width;  // infinite at |u| = 1: erf and exp have their limits there
  const double gauss = width * std::exp(-x * x) / std::sqrt(kPi);
  return 0.25 * small + 0.5 * (u * (std::erf(x) + 1) + gauss);
}

double vmf_sigma_fit_middle(double u, double alpha) {
  const double u2 = u * u, u4 = u2 * u2;
  const double a = alpha - 0.1;
  const double b2 = (1 - alpha) * (1 - alpha), b4 = b2 * b2;
  const double p1 = 0.4975 - 0.273731 * std::pow(a, 1.7);
  const double p2 = 0.153918 - 0.139522 * std::pow(a, 1.2);
  const double p4 = 0.013762 + (0.013922 * alpha - 0.027553) * alpha;
  return 0.25 + p1 * u + p2 * (3 * u2 - 1) - p4 * (3 - 30 * u2 + 35 * u4) +
         0.048357 * b4 * u4 * u4 - 0.033493 * b4 * std::cos(7.7 * u);
}

double vmf_sigma_fit_rough(double u, double alpha) {
  const double kappa = vmf_concentration(alpha);
  const double mean = vmf_mean_cosine(kappa);
  // 1 - 3 mean / kappa, the second Legendre moment of D
  const double k2 = kappa * kappa;
  const double second =
      kappa < 0.05 ? k2 / 15 * (1 - 2 * k2 / 21 + k2 * k2 / 105) : 1 - 3 * mean / kappa;
  return 0.25 + u / 2 * mean + 5.0 / 32 * (3 * u * u - 1) * second;
}

double vmf_sigma_fit(double u, double alpha) {
  if (alpha < 0.25) return vmf_sigma_fit_smooth(u, alpha);
  return alpha < 0.9 ? vmf_sigma_fit_middle(u, alpha) : vmf_sigma_fit_rough(u, alpha);
}

}  // namespace lamella
