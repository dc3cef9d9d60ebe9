#include "volume/harmonics/wigner.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace lamella {
namespace {

// d^j_jn, of which every first value is one up to signs.
double top_row(int j, int n, double angle) {
  const double c = std::cos(angle / 2), s = -std::sin(angle / 2);
  double value = 1;
  // sqrt(binomial(2 j, j + n)) c^(j + n) s^(j - n), factor by factor so that nothing overflows.
  int cosines = j + n, sines = j - n;
  const int fewer = std::min(cosines, sines);
  for (int k = 1; k <= fewer; ++k) value *= std::sqrt((2.0 * j - fewer + k) / k) * c * s;
  cosines -= fewer;
  sines -= fewer;
  for (; cosines > 0; --cosines) value *= c;
  for (; sines > 0; --sines) value *= s;
  return value;
}

double first_value(int m, int n, double angle) {
  const int l = std::max(std::abs(m), std::abs(n));
  // d_mn = (-1)^(m - n) d_nm = d_(-n)(-m).
  if (m == l) return top_row(l, n, angle);
  if (-n == l) return top_row(l, -m, angle);
  const double sign = (m - n) % 2 == 0 ? 1 : -1;
  if (n == l) return sign * top_row(l, m, angle);
  return sign * top_row(l, -n, angle);
}

}  // namespace

void wigner_d(int m, int n, double angle, Eigen::Ref<Eigen::VectorXd> values) {
  const int degree = static_cast<int>(values.size()) - 1;
  const int start = std::max(std::abs(m), std::abs(n));
  values.setZero();
  if (start > degree) return;
  const double cosine = std::cos(angle), mm = m, nn = n;
  double before = 0, now = first_value(m, n, angle);
  values[start] = now;
  for (int l = start; l < degree; ++l) {
    const double ll = l, next_l = l + 1;
    const double up = std::sqrt((next_l * next_l - mm * mm) * (next_l * next_l - nn * nn));
    const double down = std::sqrt((ll * ll - mm * mm) * (ll * ll - nn * nn));
    // At l = 0 the recurrence divides nothing by nothing: d^1_00 is the cosine.
    const double next =
        l == 0 ? cosine * now
               : ((2 * ll + 1) * (ll * next_l * cosine - mm * nn) * now - next_l * down * before) /
                     (ll * up);
    before = now;
    now = next;
    values[l + 1] = now;
  }
}

}  // namespace lamella
