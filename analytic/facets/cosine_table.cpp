#include "analytic/facets/cosine_table.h"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "phase/math/direction.h"

namespace lamella {

CosineTable::CosineTable(const std::function<double(double mu)>& f, double finest, int terms)
    : terms_(terms) {
  while (std::ldexp(1.0, -last_) > finest && last_ < 60) ++last_;
  for (int panel = 0; panel <= last_; ++panel) {
    const double high = std::ldexp(1.0, -panel), low = panel == last_ ? 0 : high / 2;
    std::vector<double> values(terms);
    for (int k = 0; k < terms; ++k)
      values[k] = f(low + (high - low) * (1 + std::cos(kPi * (k + 0.5) / terms)) / 2);
    for (int n = 0; n < terms; ++n) {
      double sum = 0;
      for (int k = 0; k < terms; ++k) sum += values[k] * std::cos(kPi * n * (k + 0.5) / terms);
      coefficients_.push_back((n == 0 ? 1.0 : 2.0) / terms * sum);
    }
    mean_ += boost::math::quadrature::gauss<double, 7>::integrate(
        [&](double mu) { return 2 * mu * (*this)(mu); }, low, high);
  }
}

double CosineTable::operator()(double mu) const {
  const int panel = mu > 0 ? std::clamp(-1 - std::ilogb(mu), 0, last_) : last_;
  const double high = std::ldexp(1.0, -panel), low = panel == last_ ? 0 : high / 2;
  const double x = 2 * (mu - low) / (high - low) - 1;
  // Clenshaw's recurrence.
  const double* c = &coefficients_[static_cast<std::size_t>(terms_ * panel)];
  double b1 = 0, b2 = 0;
  for (int n = terms_ - 1; n > 0; --n) {
    const double b = 2 * x * b1 - b2 + c[n];
    b2 = b1;
    b1 = b;
  }
  return x * b1 - b2 + c[0];
}

}  // namespace lamella
