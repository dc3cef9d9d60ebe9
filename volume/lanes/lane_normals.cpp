#include "volume/lanes/lane_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "phase/medium/vmf.h"
#include "volume/lanes/lane_layers.h"

namespace lamella {
namespace {

constexpr double kPi_ = std::numbers::pi;

// Chebyshev's four nodes in [0, 1], and what takes values there to the powers of a cubic.
struct Cubic {
  std::array<double, 4> node{};
  std::array<std::array<double, 4>, 4> power{};  // power p of the value at node n
  Cubic() {
    for (int n = 0; n < 4; ++n) node[n] = (1 - std::cos(kPi_ * (n + 0.5) / 4)) / 2;
    for (int n = 0; n < 4; ++n) {
      std::array<double, 4> lagrange{1, 0, 0, 0};
      for (int k = 0; k < 4; ++k) {
        if (k == n) continue;
        const double scale = 1 / (node[n] - node[k]);
        for (int p = 3; p >= 0; --p)
          lagrange[p] = scale * ((p > 0 ? lagrange[p - 1] : 0) - node[k] * lagrange[p]);
      }
      for (int p = 0; p < 4; ++p) power[p][n] = lagrange[p];
    }
  }
};
const Cubic& cubic() {
  static const Cubic c;
  return c;
}

// F(c) exp(-max(c, 0)) by Chebyshev's interpolation in c / (|c| + 4), times what it falls by.
class CircleIntegral {
 public:
  CircleIntegral() {
    for (int side = 0; side < 2; ++side) {
      std::array<double, kTerms> values{};
      for (int j = 0; j < kTerms; ++j) {
        const double y = (1 + std::cos(kPi_ * (j + 0.5) / kTerms)) / 2, size = 4 * y / (1 - y);
        values[j] = integral(side == 0 ? size : -size) * fall(side == 0 ? size : -size);
      }
      for (int k = 0; k < kTerms; ++k) {
        double sum = 0;
        for (int j = 0; j < kTerms; ++j) sum += values[j] * std::cos(kPi_ * k * (j + 0.5) / kTerms);
        terms_[side][k] = sum * (k == 0 ? 1.0 : 2.0) / kTerms;
      }
    }
  }
  double operator()(double c) const {
    const double size = std::abs(c), x = 2 * (2 * size / (size + 4) - 1);
    const auto& a = terms_[c < 0 ? 1 : 0];
    double b1 = 0, b2 = 0;
    for (int k = kTerms - 1; k > 0; --k) {
      const double b = a[k] + x * b1 - b2;
      b2 = b1;
      b1 = b;
    }
    return (a[0] + x / 2 * b1 - b2) / fall(c);
  }

 private:
  static constexpr int kTerms = 24;
  static double fall(double c) { return c < 0 ? (2 - c) * (2 - c) * (2 - c) : std::sqrt(c + 2); }
  // Simpson's rule where the integrand is above exp(-45).
  static double integral(double c) {
    const bool back = c < 0;
    const double reach = 45 / std::max(std::abs(c), 1e-9);
    const double end = back ? (reach < 1 ? std::asin(reach) : kPi_ / 2)
                            : (reach < 1 ? std::acos(1 - reach) : kPi_ / 2);
    const auto density = [&](double x) {  // x from the largest value on
      const double cosine = back ? std::sin(x) : std::cos(x), half = std::sin(x / 2);
      return cosine * cosine * std::exp(back ? c * cosine : -2 * c * half * half);
    };
    constexpr int n = 400;
    double sum = density(0) + density(end);
    for (int k = 1; k < n; ++k) sum += (k % 2 == 1 ? 4 : 2) * density(end * k / n);
    return 2 * sum * end / (3 * n);
  }
  std::array<double, kTerms> terms_[2];
};

// Quantiles of a density on [from, to], by cubics of its integral, from both ends.
class Quantiles {
 public:
  template <class Density>
  Quantiles(const Density& density, double from, double to)
      : from_(from),
        width_((to - from) / kPanels),
        f_(kPanels + 1),
        below_(kPanels + 1),
        above_(kPanels + 1) {
    std::array<double, kPanels> part{};
    for (int k = 0; k <= kPanels; ++k) f_[k] = density(from + k * width_);
    for (int k = 0; k < kPanels; ++k)
      part[k] = width_ / 6 * (f_[k] + 4 * density(from + (k + 0.5) * width_) + f_[k + 1]);
    for (int k = 0; k < kPanels; ++k) below_[k + 1] = below_[k] + part[k];
    for (int k = kPanels; k > 0; --k) above_[k - 1] = above_[k] + part[k - 1];
  }
  // Beyond which the probability is p.
  double from_below(double p) const {
    const double goal = p * below_.back();
    const auto at = std::upper_bound(below_.begin() + 1, below_.end() - 1, goal) - below_.begin();
    const auto k = static_cast<std::size_t>(at - 1);
    return from_ + width_ * (static_cast<double>(k) +
                             place(goal - below_[k], below_[k + 1] - below_[k], f_[k], f_[k + 1]));
  }
  double from_above(double p) const {
    const double goal = p * above_.front();
    std::size_t k = kPanels - 1, low = 0;
    while (low < k) {  // the last panel whose upper part holds less than the goal
      const std::size_t middle = (low + k + 1) / 2;
      if (above_[middle] >= goal)
        low = middle;
      else
        k = middle - 1;
    }
    return from_ +
           width_ * (static_cast<double>(k + 1) -
                     place(goal - above_[k + 1], above_[k] - above_[k + 1], f_[k + 1], f_[k]));
  }

 private:
  static constexpr int kPanels = 384;
  // Where in [0, 1] the cubic with these end slopes, from 0 to `whole`, reaches the goal.
  double place(double goal, double whole, double slope0, double slope1) const {
    const double a = slope0 * width_, b = slope1 * width_;
    double low = 0, high = 1, t = whole > 0 ? std::clamp(goal / whole, 0.0, 1.0) : 0;
    for (int step = 0; step < 60; ++step) {
      const double value = t * (a + t * (3 * whole - 2 * a - b + t * (a + b - 2 * whole)));
      const double slope = a + t * (2 * (3 * whole - 2 * a - b) + t * 3 * (a + b - 2 * whole));
      (value < goal ? low : high) = t;
      double next = slope > 0 ? t - (value - goal) / slope : -1;
      if (!(next > low && next < high)) next = (low + high) / 2;
      if (std::abs(next - t) < 1e-12) return next;
      t = next;
    }
    return t;
  }
  double from_, width_;
  std::vector<double> f_, below_, above_;
};

// A sheet's patches from value(row coordinate in [0, 1])(column in [0, 1]).
template <class Rows>
void append_sheets(std::vector<NormalPatch>& to, int rows, int columns, int count,
                   const Rows& row_values) {
  const std::size_t first = to.size();
  to.resize(first + static_cast<std::size_t>(count * rows * columns));
  for (int i = 0; i < rows; ++i) {
    std::vector<std::array<std::array<double, 4>, 4>> values(
        static_cast<std::size_t>(count * columns));
    for (int n = 0; n < 4; ++n) {
      const auto of = row_values((i + cubic().node[n]) / static_cast<double>(rows));
      for (int sheet = 0; sheet < count; ++sheet)
        for (int j = 0; j < columns; ++j)
          for (int c = 0; c < 4; ++c)
            values[sheet * columns + j][n][c] = of(sheet, (j + cubic().node[c]) / columns);
    }
    for (int sheet = 0; sheet < count; ++sheet)
      for (int j = 0; j < columns; ++j) {
        NormalPatch& patch = to[first + (sheet * rows + i) * columns + j];
        const auto& v = values[sheet * columns + j];
        for (int p = 0; p < 4; ++p)
          for (int q = 0; q < 4; ++q) {
            double sum = 0;
            for (int n = 0; n < 4; ++n)
              for (int c = 0; c < 4; ++c)
                sum += cubic().power[p][n] * cubic().power[q][c] * v[n][c];
            patch.power[p][q] = static_cast<float>(sum);
          }
      }
  }
}

// E of a column's place in [0, 1].
double exponential_at(double column) {
  const double start = std::sqrt(kColumnStart);
  const double root = start + column * (std::sqrt(kLargestExponential + kColumnStart) - start);
  return root * root - kColumnStart;
}

double largest_behind(double k) { return std::min(1.0, kLargestBehind * k); }

// The quantiles of d from behind, or of b from the front, of light whose arcsin(u) is psi.
Quantiles plane_quantiles(double kappa, double psi, bool behind) {
  static const CircleIntegral circle;
  // Densities below exp(-kLargest) of the largest do not matter.
  constexpr double kLargest = 36;
  const double least = behind ? 2 * kappa * std::pow(std::sin(psi / 2), 2) : 0;
  const double far = (least + kLargest) / (2 * std::max(kappa, 1e-9));
  // b from -psi on, where exp(kappa (cos(b) - 1)) is large enough, and F beyond the quarter turn.
  const double end = least + kLargest < kappa ? 2 * std::asin(std::sqrt(far)) : kPi_ - psi;
  const double to = std::min(end, kPi_ - psi);
  const double from = behind ? -psi : std::max(-psi, -end);
  const auto density = [&](double b, double d) {
    const double half = std::sin(b / 2), c = kappa * std::cos(b);
    const double exponent = c < 0 ? -kappa : -2 * kappa * half * half;
    return std::sin(std::max(d, 0.0)) * circle(c) * std::exp(exponent + least);
  };
  if (behind) return {[&](double d) { return density(d - psi, d); }, 0, to + psi};
  return {[&](double b) { return density(b, b + psi); }, from, to};
}

}  // namespace

std::vector<NormalPatch> vmf_normal_sheets(double kappa) {
  std::vector<NormalPatch> sheets;
  const double root = std::sqrt(kappa + 1), k = 1 / root;
  for (const bool behind : {true, false})
    append_sheets(sheets, kNormalRows, kNormalColumns, 2, [&](double row) {
      const double size =
          behind ? 2 * std::atan(row * largest_behind(k)) : std::atan2(2 * k * row, 1 - row);
      const double u = std::sin(size);
      const double scale = (behind ? kappa * u + root : root) / kPi_;
      return [quantiles = plane_quantiles(kappa, behind ? -size : size, behind), scale](
                 int sheet, double column) {
        const double p = std::exp(-exponential_at(column)) / 2;
        return scale * (sheet == 0 ? quantiles.from_below(p) : quantiles.from_above(p));
      };
    });
  return sheets;
}

namespace {

// |g| by the density cos(g)^2 exp(c cos(g)) from 0 on.
Quantiles front_quantiles(double c) {
  const double reach = 40 / std::max(c, 1e-9);
  const double end = reach < 1 ? std::acos(1 - reach) : kPi_ / 2;
  return {[=](double x) {
            const double cosine = std::cos(x), half = std::sin(x / 2);
            return cosine * cosine * std::exp(-2 * c * half * half);
          },
          0, end};
}

// Powers of 2 x - 1 of the polynomial through values at `count` of Chebyshev's nodes in [0, 1].
std::vector<double> powers_through(const std::vector<double>& values) {
  const int count = static_cast<int>(values.size());
  std::vector<double> powers(values.size()), older(values.size()), old(values.size());
  for (int k = 0; k < count; ++k) {
    double sum = 0;
    for (int n = 0; n < count; ++n)
      sum -= values[n] * std::cos(kPi_ * k * (n + 0.5) / count) * (k % 2 == 1 ? 1 : -1);
    sum *= (k == 0 ? 1.0 : 2.0) / count;
    std::vector<double> now(values.size());  // Chebyshev's polynomial k
    if (k < 2) {
      now[k] = 1;
    } else {
      for (int p = 0; p < count; ++p) now[p] = (p > 0 ? 2 * old[p - 1] : 0) - older[p];
    }
    for (int p = 0; p < count; ++p) powers[p] += sum * now[p];
    older = old;
    old = now;
  }
  return powers;
}

double chebyshev_node(int n, int count) { return (1 - std::cos(kPi_ * (n + 0.5) / count)) / 2; }

}  // namespace

const std::vector<NormalPatch>& side_sheets() {
  static const std::vector<NormalPatch> sheets = [] {
    std::vector<NormalPatch> list(kSidePatch);
    std::vector<std::vector<double>> rows(kFrontColumns, std::vector<double>(kFrontRows));
    for (int i = 0; i < kFrontRows; ++i) {
      const double row = chebyshev_node(i, kFrontRows), x = kFrontPlace * row / (1 - row);
      const Quantiles quantiles = front_quantiles(x + kLeastFront);
      std::vector<double> values(kFrontColumns);
      for (int j = 0; j < kFrontColumns; ++j)
        values[j] =
            std::sqrt(x + kFrontScale) / kPi_ *
            quantiles.from_above(std::exp(-exponential_at(chebyshev_node(j, kFrontColumns))));
      const std::vector<double> powers = powers_through(values);
      for (int j = 0; j < kFrontColumns; ++j) rows[j][i] = powers[j];
    }
    for (int j = 0; j < kFrontColumns; ++j) {
      const std::vector<double> powers = powers_through(rows[j]);
      for (int i = 0; i < kFrontRows; ++i) {
        const int at = i * kFrontColumns + j;
        list[at / 16].power[at / 4 % 4][at % 4] = static_cast<float>(powers[i]);
      }
    }
    append_sheets(list, kSideRows, kSideColumns, 1, [&](double row) {
      const double size = 4 * row / (1 - row), reach = 40 / std::max(size, 1e-9);
      const Quantiles quantiles(
          [&](double x) {  // from the quarter turn on
            const double cosine = std::sin(x);
            return cosine * cosine * std::exp(-size * cosine);
          },
          0, reach < 1 ? std::asin(reach) : kPi_ / 2);
      return [=](int, double column) {
        return (size + 2) / kPi_ *
               quantiles.from_above(std::exp(-kLargestExponential * std::pow(column, 3)));
      };
    });
    return list;
  }();
  return sheets;
}

std::vector<NormalPatch> back_sigma_pieces(double kappa, double alpha) {
  std::vector<NormalPatch> pieces(kSigmaPieces / 4);
  const double k = 1 / std::sqrt(kappa + 1);
  for (int i = 0; i < kSigmaPieces; ++i) {
    std::array<double, 4> values{};
    for (int n = 0; n < 4; ++n) {
      const double q = largest_behind(k) * (i + cubic().node[n]) / kSigmaPieces;
      values[n] = std::min(100.0, -log_vmf_sigma(-2 * q / (1 + q * q), alpha));
    }
    for (int p = 0; p < 4; ++p) {
      double sum = 0;
      for (int n = 0; n < 4; ++n) sum += cubic().power[p][n] * values[n];
      pieces[i / 4].power[i % 4][p] = static_cast<float>(sum);
    }
  }
  return pieces;
}

}  // namespace lamella
