#include "analytic/facets/cosine_table.h"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "phase/math/direction.h"

namespace lamella {

CosineTable::CosineTable(const std::function<double(double mu)>& f, int terms, double near_0,
                         double near_1)
    : terms_(terms) {
  fill(lower_, false, f, near_0);
  fill(upper_, true, f, near_1);
}

void CosineTable::fill(Half& half, bool upper, const std::function<double(double mu)>& f,
                       double finest) {
  while (std::ldexp(0.5, -half.last) > finest && half.last < 60) ++half.last;
  std::vector<double> values(static_cast<std::size_t>(terms_));
  for (int panel = 0; panel <= half.last; ++panel) {
    const double high = std::ldexp(0.5, -panel), low = panel == half.last ? 0 : high / 2;
    for (int k = 0; k < terms_; ++k) {
      const double d = low + (high - low) * (1 + std::cos(kPi * (k + 0.5) / terms_)) / 2;
      values[k] = f(upper ? 1 - d : d);
    }
    for (int n = 0; n < terms_; ++n) {
      double sum = 0;
      for (int k = 0; k < terms_; ++k) sum += values[k] * std::cos(kPi * n * (k + 0.5) / terms_);
      half.coefficients.push_back((n == 0 ? 1.0 : 2.0) / terms_ * sum);
    }
    mean_ += boost::math::quadrature::gauss<double, 9>::integrate(
        [&](double d) { return 2 * (upper ? 1 - d : d) * at(half, d); }, low, high);
  }
}

double CosineTable::at(const Half& half, double distance) const {
  const int panel = distance > 0 ? std::clamp(-2 - std::ilogb(distance), 0, half.last) : half.last;
  const double high = std::ldexp(0.5, -panel), low = panel == half.last ? 0 : high / 2;
  const double x = 2 * (distance - low) / (high - low) - 1;
  // Clenshaw's recurrence.
  const double* c = &half.coefficients[static_cast<std::size_t>(terms_ * panel)];
  double b1 = 0, b2 = 0;
  for (int n = terms_ - 1; n > 0; --n) {
    const double b = 2 * x * b1 - b2 + c[n];
    b2 = b1;
    b1 = b;
  }
  return x * b1 - b2 + c[0];
}

double CosineTable::operator()(double mu) const {
  return mu < 0.5 ? at(lower_, mu) : at(upper_, 1 - mu);
}

}  // namespace lamella
