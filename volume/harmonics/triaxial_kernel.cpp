#include "volume/harmonics/triaxial_kernel.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "volume/harmonics/flake_events.h"
#include "volume/harmonics/wigner.h"

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The axes of S and their eigenvalues; z is the one that differs most from the next.
struct Axes {
  Direction x, y, z;
  double sx, sy, sz;
};

Axes axes_about(const Sggx& normals) {
  const SggxMatrix<double>& a = normals.matrix();
  Eigen::Matrix3d lower;
  lower << a.a00, 0, 0, a.a10, a.a11, 0, a.a20, a.a21, a.a22;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(lower * lower.transpose());
  const Eigen::Vector3d& s = solver.eigenvalues();
  const auto column = [&](int k) {
    const Eigen::Vector3d v = solver.eigenvectors().col(k);
    return Direction{v[0], v[1], v[2]};
  };
  const int z = s[1] / s[0] > s[2] / s[1] ? 0 : 2, x = z == 0 ? 1 : 0;
  const Direction axis = column(z), side = column(x);
  return {side, cross(axis, side), axis, s[x], s[3 - x - z], s[z]};
}

// The turn about z that is left once z is there.
double spin_of(const Axes& axes) {
  const double theta = std::atan2(std::hypot(axes.z.x, axes.z.y), axes.z.z);
  const double phi = std::atan2(axes.z.y, axes.z.x);
  const Direction x{std::cos(theta) * std::cos(phi), std::cos(theta) * std::sin(phi),
                    -std::sin(theta)};
  const Direction y{-std::sin(phi), std::cos(phi), 0};
  return std::atan2(dot(axes.x, y), dot(axes.x, x));
}

// Means of D exp(-i q phi) over the azimuth of normals, rows q = 0, 1, ..., columns polar angles.
MatrixXd azimuthal_means(const Axes& axes, const VectorXd& angles, int count) {
  MatrixXd means(count, angles.size());
  const double scale = 1 / (kPi * std::sqrt(axes.sx * axes.sy * axes.sz));
  tbb::parallel_for(Eigen::Index{0}, angles.size(), [&](Eigen::Index k) {
    const double c = std::cos(angles[k]), s = std::sin(angles[k]);
    // h^T S^-1 h = a + b cos 2 phi
    const double a = c * c / axes.sz + s * s * (1 / axes.sx + 1 / axes.sy) / 2;
    const double b = s * s * (1 / axes.sx - 1 / axes.sy) / 2;
    const double decay = std::acosh(std::max(1 + 1e-9, a / std::max(std::abs(b), 1e-300)));
    const int points = 16 + 2 * count + static_cast<int>(std::min(4e4, 80 / decay));
    means.col(k).setZero();
    for (int p = 0; p < points; ++p) {
      const double phi = kPi * p / points, x = a + b * std::cos(2 * phi);
      const double value = scale / (x * x) / points;
      for (int q = 0; q < count; q += 2) means(q, k) += value * std::cos(q * phi);
    }
  });
  return means;
}

struct Place {
  int l, m, place;
};

// The harmonics of one class.
std::vector<Place> places_of(const HarmonicBasis& basis, bool sine, int parity_m, int parity_l) {
  std::vector<Place> places;
  for (int m = parity_m; m <= basis.degree(); m += 2)
    for (int l = m; l <= basis.degree(); ++l)
      if (l % 2 == parity_l && !(sine && m == 0)) places.push_back({l, m, basis.place(l, m, sine)});
  return places;
}

// By m and m' of the same parity, in the plane of complex harmonics: K_mm' and K_m(-m').
struct Pair {
  MatrixXd plus, minus;
};

// Mirrors, as mirror_blocks of harmonic_kernel.cpp, with the azimuth's means between m and m'.
void add_mirrors(const HarmonicBasis& basis, const MatrixProduct& product,
                 const std::vector<MatrixXd>& one, const Quadrature& rule, const MatrixXd& means,
                 std::vector<std::vector<Pair>>& pairs) {
  const int degree = basis.degree();
  const VectorXd sines = rule.points.array().sin() * rule.weights.array() * 2 * kPi;
  for (int n = -degree; n <= degree; ++n) {
    // Of m from -degree to degree: rows l from max(|m|, |n|) on.
    std::vector<MatrixXd> turns(2 * degree + 1);
    tbb::parallel_for(-degree, degree + 1, [&](int m) {
      turns[m + degree] = wigner_rows(m, n, rule.points, degree).transpose();
    });
    tbb::parallel_for(0, degree + 1, [&](int m) {
      for (int other = m % 2; other <= m; other += 2)
        for (const int sign : {1, -1}) {
          const MatrixXd &a = turns[m + degree], &b = turns[sign * other + degree];
          const VectorXd weights =
              sines.array() * means.row(std::abs(m - sign * other)).transpose().array();
          const MatrixXd mean = product(a, weights.asDiagonal() * b.transpose());
          MatrixXd& sum = sign > 0 ? pairs[m][other].plus : pairs[m][other].minus;
          const MatrixXd& flake = one[std::abs(n)];
          sum.bottomRightCorner(a.rows(), b.rows()) +=
              mean.cwiseProduct(flake.bottomRightCorner(a.rows(), b.rows()));
        }
    });
  }
}

// Lambertian flakes: the mean over normals of a product of two harmonics of them.
void add_lambert(const HarmonicBasis& basis, const MatrixProduct& product, const VectorXd& clamped,
                 const Quadrature& rule, const MatrixXd& means,
                 std::vector<std::vector<Pair>>& pairs) {
  const int degree = basis.degree();
  const Eigen::Index points = rule.points.size();
  const VectorXd sines = rule.points.array().sin() * rule.weights.array() * 2;
  std::vector<MatrixXd> legendre(degree + 1);
  for (int m = 0; m <= degree; ++m) legendre[m].resize(basis.count(m), points);
  VectorXd values(basis.size());
  for (Eigen::Index k = 0; k < points; ++k) {
    basis.legendre(std::cos(rule.points[k]), values);
    for (int m = 0; m <= degree; ++m)
      legendre[m].col(k) = clamped.tail(basis.count(m))
                               .cwiseProduct(values.segment(basis.first(m, false), basis.count(m)));
  }
  tbb::parallel_for(0, degree + 1, [&](int m) {
    for (int other = m % 2; other <= m; other += 2)
      for (const int sign : {1, -1}) {
        const VectorXd weights =
            sines.array() * means.row(std::abs(m - sign * other)).transpose().array();
        MatrixXd& sum = sign > 0 ? pairs[m][other].plus : pairs[m][other].minus;
        // Phases of complex harmonics: (-1)^m for positive m alone.
        sum = (sign < 0 && other % 2 ? -1 : 1) *
              product(legendre[m], weights.asDiagonal() * legendre[other].transpose());
      }
  });
}

}  // namespace

TriaxialKernel::TriaxialKernel(const Sggx& normals, bool mirrors, double f0,
                               const HarmonicBasis& basis, MatrixProduct product)
    : product_(product),
      turn_(basis, axes_about(normals).z, product, spin_of(axes_about(normals))) {
  const Axes axes = axes_about(normals);
  const int degree = basis.degree();
  const auto [least, largest] = std::minmax({axes.sx, axes.sy, axes.sz});
  const double width = std::sqrt(least / largest);
  // z has the smallest eigenvalue, and D its ridge across it, or the largest.
  const bool is_fiber = axes.sz == least;
  const Quadrature rule = flake_angles(
      is_fiber ? std::vector<double>{kPi / 2} : std::vector<double>{0, kPi}, width, degree);
  const MatrixXd means = azimuthal_means(axes, rule.points, 2 * degree + 1);
  std::vector<std::vector<Pair>> pairs(degree + 1);
  for (int m = 0; m <= degree; ++m) {
    pairs[m].resize(m + 1);
    for (int other = m % 2; other <= m; other += 2) {
      const MatrixXd zero = MatrixXd::Zero(basis.count(m), basis.count(other));
      pairs[m][other] = {zero, zero};
    }
  }
  if (mirrors)
    add_mirrors(basis, product, one_mirror(f0, basis), rule, means, pairs);
  else
    add_lambert(basis, product, clamped_cosine_factors(basis), rule, means, pairs);
  for (const bool sine : {false, true})
    for (const int parity_m : {0, 1})
      for (const int parity_l : {0, 1}) {
        const std::vector<Place> places = places_of(basis, sine, parity_m, parity_l);
        if (places.empty()) continue;
        const auto size = static_cast<Eigen::Index>(places.size());
        Block block{{}, MatrixXd(size, size)};
        for (const Place& place : places) block.places.push_back(place.place);
        for (Eigen::Index row = 0; row < size; ++row)
          for (Eigen::Index column = 0; column < size; ++column) {
            const Place &a = places[row], &b = places[column];
            const Place &high = a.m >= b.m ? a : b, &low = a.m >= b.m ? b : a;
            const Pair& pair = pairs[high.m][low.m];
            const double plus = pair.plus(high.l - high.m, low.l - low.m);
            const double minus = pair.minus(high.l - high.m, low.l - low.m);
            double value = plus;
            if (low.m > 0)
              value += (sine ? -1 : 1) * (low.m % 2 ? -1 : 1) * minus;
            else if (high.m > 0)
              value *= std::sqrt(2.0);
            // Light comes along the opposite of the direction that the kernel knows.
            block.matrix(row, column) = (b.l % 2 ? -1 : 1) * value;
          }
        blocks_.push_back(std::move(block));
      }
}

MatrixXd TriaxialKernel::apply(const MatrixXd& radiance) const {
  const MatrixXd turned = turn_.to_axis(radiance);
  MatrixXd source(radiance.rows(), radiance.cols());
  tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t b) {
    const Block& block = blocks_[b];
    const auto size = static_cast<Eigen::Index>(block.places.size());
    MatrixXd rows(size, radiance.cols());
    for (Eigen::Index k = 0; k < size; ++k) rows.row(k) = turned.row(block.places[k]);
    const MatrixXd sent = product_(block.matrix, rows);
    for (Eigen::Index k = 0; k < size; ++k) source.row(block.places[k]) = sent.row(k);
  });
  return turn_.from_axis(source);
}

}  // namespace lamella
