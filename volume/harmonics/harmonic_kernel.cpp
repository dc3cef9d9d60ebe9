#include "volume/harmonics/harmonic_kernel.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "phase/math/color.h"
#include "volume/harmonics/axial_normals.h"
#include "volume/harmonics/wigner.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Panels on [0, pi] that shrink towards places where a function is narrow, with as many points as
// products of harmonics need besides.
Quadrature angles(const std::vector<double>& places, double width, int degree) {
  std::vector<double> edges{0, kPi};
  for (const double place : places) {
    edges.push_back(place);
    for (double distance = width / 2; distance < kPi; distance *= 2) {
      edges.push_back(std::clamp(place - distance, 0.0, kPi));
      edges.push_back(std::clamp(place + distance, 0.0, kPi));
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<double> points, weights;
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    const double length = edges[k + 1] - edges[k];
    if (length < 1e-12) continue;
    // Waves of up to twice the degree: half a phase of (2 degree + 1) length / 2 per unit.
    const Quadrature& rule =
        cached_gauss_legendre(16 + static_cast<int>(0.6 * (degree + 1) * length));
    for (Eigen::Index j = 0; j < rule.points.size(); ++j) {
      points.push_back(edges[k] + length * rule.points[j]);
      weights.push_back(length * rule.weights[j]);
    }
  }
  return {Eigen::Map<VectorXd>(points.data(), static_cast<Eigen::Index>(points.size())),
          Eigen::Map<VectorXd>(weights.data(), static_cast<Eigen::Index>(weights.size()))};
}

double sign_of(int l) { return l % 2 ? -1 : 1; }

// Funk and Hecke's factors of a phase function, by the deflection's cosine.
VectorXd particle_factors(const Medium& medium, const HarmonicBasis& basis) {
  const int degree = basis.degree();
  const double peak = 1 - std::abs(traits(medium).mean_cosine);
  const Quadrature rule = angles({0, kPi}, std::max(peak, 1e-8), degree);
  VectorXd factors = VectorXd::Zero(degree + 1), values(basis.size());
  const Direction wi{0, 0, 1};
  for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
    const double angle = rule.points[k];
    // Deflected by no angle light leaves along -w_i.
    const Direction wo{std::sin(angle), 0, -std::cos(angle)};
    basis.legendre(std::cos(angle), values);
    const double f = phase(medium, wi, wo).density * std::sin(angle) * rule.weights[k];
    for (int l = 0; l <= degree; ++l)
      factors[l] += 2 * kPi * f * values[l] * std::sqrt(4 * kPi / (2 * l + 1));
  }
  return sigma(medium, wi) * factors;
}

// Lambertian flakes: Funk and Hecke's factors of the clamped cosine, once for the light that
// arrives and once for that which leaves, about each normal.
std::vector<MatrixXd> lambert_blocks(const AxialNormals& normals, const HarmonicBasis& basis) {
  const int degree = basis.degree();
  const Quadrature& half = cached_gauss_legendre(degree + 4);
  VectorXd values(basis.size()), clamped = VectorXd::Zero(degree + 1);
  for (Eigen::Index k = 0; k < half.points.size(); ++k) {
    basis.legendre(half.points[k], values);
    for (int l = 0; l <= degree; ++l)
      clamped[l] +=
          2 * kPi * half.weights[k] * half.points[k] * values[l] * std::sqrt(4 * kPi / (2 * l + 1));
  }
  const Quadrature rule = angles(normals.peaks, normals.width, degree);
  std::vector<MatrixXd> legendre(degree + 1);
  for (int m = 0; m <= degree; ++m) legendre[m].resize(basis.count(m), rule.points.size());
  VectorXd weights(rule.points.size());
  for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
    const double angle = rule.points[k];
    basis.legendre(std::cos(angle), values);
    for (int m = 0; m <= degree; ++m)
      legendre[m].col(k) = values.segment(basis.first(m, false), basis.count(m));
    // The azimuth's integral of a squared harmonic is 2 pi N^2 P^2.
    weights[k] = 2 * kPi * normals.density(angle) * std::sin(angle) * rule.weights[k] / kPi;
  }
  std::vector<MatrixXd> blocks(degree + 1);
  tbb::parallel_for(0, degree + 1, [&](int m) {
    const VectorXd c = clamped.tail(basis.count(m));
    blocks[m] = c.asDiagonal() * legendre[m] * weights.asDiagonal() * legendre[m].transpose() *
                c.asDiagonal();
  });
  return blocks;
}

// Mirrors: about its own normal a flake turns each harmonic by half a turn and weights it with the
// clamped cosine; then the mean over the normals, whose azimuth keeps each m apart.
std::vector<MatrixXd> mirror_blocks(const AxialNormals& normals, double f0,
                                    const HarmonicBasis& basis, const MatrixProduct& product) {
  const int degree = basis.degree();
  // By m: of one flake.
  const Quadrature& half = cached_gauss_legendre(degree + 6);
  std::vector<MatrixXd> one(degree + 1);
  {
    std::vector<MatrixXd> legendre(degree + 1);
    for (int m = 0; m <= degree; ++m) legendre[m].resize(basis.count(m), half.points.size());
    VectorXd values(basis.size()), weights(half.points.size());
    for (Eigen::Index k = 0; k < half.points.size(); ++k) {
      const double t = half.points[k];
      basis.legendre(t, values);
      for (int m = 0; m <= degree; ++m)
        legendre[m].col(k) = values.segment(basis.first(m, false), basis.count(m));
      weights[k] = 2 * kPi * half.weights[k] * t * (f0 + (1 - f0) * schlick_weight(t));
    }
    for (int m = 0; m <= degree; ++m)
      one[m] = sign_of(m) * legendre[m] * weights.asDiagonal() * legendre[m].transpose();
  }
  const Quadrature rule = angles(normals.peaks, normals.width, degree);
  std::vector<MatrixXd> blocks(degree + 1);
  tbb::parallel_for(0, degree + 1, [&](int m) {
    MatrixXd& block = blocks[m];
    block = MatrixXd::Zero(basis.count(m), basis.count(m));
    VectorXd turn(degree + 1);
    MatrixXd turns(degree + 1, rule.points.size());
    for (int n = -degree; n <= degree; ++n) {
      const int lowest = std::max(m, std::abs(n));
      const int rows = degree - lowest + 1;
      for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
        wigner_d(m, n, rule.points[k], turn);
        turns.col(k) = turn;
      }
      VectorXd weights(rule.points.size());
      for (Eigen::Index k = 0; k < rule.points.size(); ++k)
        weights[k] =
            2 * kPi * normals.density(rule.points[k]) * std::sin(rule.points[k]) * rule.weights[k];
      const MatrixXd part = turns.bottomRows(rows);
      const MatrixXd mean = product(part, weights.asDiagonal() * part.transpose());
      block.bottomRightCorner(rows, rows) +=
          mean.cwiseProduct(one[std::abs(n)].bottomRightCorner(rows, rows));
    }
  });
  return blocks;
}

}  // namespace

HarmonicKernel::HarmonicKernel(const Medium& medium, double f0, const HarmonicBasis& basis,
                               MatrixProduct product)
    : basis_(basis), product_(product) {
  if (const auto reason = why_no_harmonics(medium)) throw std::invalid_argument(*reason);
  const auto normals = axial_normals(medium);
  if (!normals) {
    by_degree_ = particle_factors(medium, basis);
    return;
  }
  by_m_ = normals->mirrors ? mirror_blocks(*normals, f0, basis, product)
                           : lambert_blocks(*normals, basis);
  // The kernel is symmetric in the directions that point away from the event; light comes along
  // the opposite of one of them.
  for (int m = 0; m <= basis.degree(); ++m)
    for (int l = m; l <= basis.degree(); ++l) by_m_[m].col(l - m) *= sign_of(l);
  const Direction axis = normals->axis;
  if (axis.x != 0 || axis.y != 0 || axis.z < 0) turn_.emplace(basis, axis, product);
}

MatrixXd HarmonicKernel::apply(const MatrixXd& radiance) const {
  MatrixXd source(radiance.rows(), radiance.cols());
  if (by_m_.empty()) {
    for (int m = 0; m <= basis_.degree(); ++m)
      for (const bool sine : {false, true}) {
        if (sine && m == 0) continue;
        const int first = basis_.first(m, sine), count = basis_.count(m);
        source.middleRows(first, count) =
            by_degree_.tail(count).asDiagonal() * radiance.middleRows(first, count);
      }
    return source;
  }
  const MatrixXd turned = turn_ ? turn_->to_axis(radiance) : radiance;
  tbb::parallel_for(0, basis_.degree() + 1, [&](int m) {
    for (const bool sine : {false, true}) {
      if (sine && m == 0) continue;
      const int first = basis_.first(m, sine), count = basis_.count(m);
      source.middleRows(first, count) = product_(by_m_[m], turned.middleRows(first, count));
    }
  });
  return turn_ ? turn_->from_axis(source) : source;
}

std::optional<std::string> why_no_harmonics(const Medium& medium) {
  if (is_delta(medium)) return "mirror flakes at roughness 0 scatter into a delta";
  if (has_normals(medium) && !axial_normals(medium))
    return "the flakes' normals have no axis of symmetry";
  return std::nullopt;
}

}  // namespace lamella
