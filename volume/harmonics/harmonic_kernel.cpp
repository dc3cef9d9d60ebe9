#include "volume/harmonics/harmonic_kernel.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "phase/math/color.h"
#include "volume/harmonics/axial_normals.h"
#include "volume/harmonics/flake_events.h"
#include "volume/harmonics/wigner.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double sign_of(int l) { return l % 2 ? -1 : 1; }

// Funk and Hecke's factors of a phase function, by the deflection's cosine.
VectorXd particle_factors(const Medium& medium, const HarmonicBasis& basis) {
  const int degree = basis.degree();
  const double peak = 1 - std::abs(traits(medium).mean_cosine);
  const Quadrature rule = flake_angles({0, kPi}, std::max(peak, 1e-8), degree);
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
  const VectorXd clamped = clamped_cosine_factors(basis);
  VectorXd values(basis.size());
  const Quadrature rule = flake_angles(normals.peaks, normals.width, degree);
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

// Columns of one parity.
MatrixXd every_other(const MatrixXd& columns, Eigen::Index first) {
  const Eigen::Index count = (columns.cols() - first + 1) / 2;
  return Eigen::Map<const MatrixXd, 0, Eigen::OuterStride<>>(
      columns.data() + first * columns.rows(), columns.rows(), count,
      Eigen::OuterStride<>(2 * columns.rows()));
}

// Adds the mean over normals of two turns' products, times what one mirror does to them.
void add_mean(const MatrixXd& turns, const VectorXd& weights, const MatrixXd& one, bool is_even,
              double factor, const MatrixProduct& product, Eigen::Ref<MatrixXd> block) {
  const int step = is_even ? 2 : 1;
  for (int first = 0; first < std::min<int>(step, static_cast<int>(turns.cols())); ++first) {
    const MatrixXd some = is_even ? every_other(turns, first) : turns;
    const MatrixXd mean = product(some.transpose(), weights.asDiagonal() * some);
    for (Eigen::Index k = 0; k < some.cols(); ++k)
      for (Eigen::Index j = 0; j < some.cols(); ++j)
        block(first + step * j, first + step * k) +=
            factor * mean(j, k) * one(first + step * j, first + step * k);
  }
}

// Mirrors: about its own normal a flake turns each harmonic by half a turn and weights it with the
// clamped cosine; then the mean over the normals, whose azimuth keeps each m apart. Where normals
// point along n as often as along -n, terms of n and of -n are the same for degrees of one parity,
// and cancel between parities.
std::vector<MatrixXd> mirror_blocks(const AxialNormals& normals, double f0,
                                    const HarmonicBasis& basis, const MatrixProduct& product) {
  const int degree = basis.degree();
  const std::vector<MatrixXd> one = one_mirror(f0, basis);
  const Quadrature rule = flake_angles(normals.peaks, normals.width, degree);
  VectorXd weights(rule.points.size());
  for (Eigen::Index k = 0; k < rule.points.size(); ++k)
    weights[k] =
        2 * kPi * normals.density(rule.points[k]) * std::sin(rule.points[k]) * rule.weights[k];
  std::vector<MatrixXd> blocks(degree + 1);
  tbb::parallel_for(0, degree + 1, [&](int m) {
    MatrixXd& block = blocks[m];
    block = MatrixXd::Zero(basis.count(m), basis.count(m));
    for (int n = normals.is_even ? 0 : -degree; n <= degree; ++n) {
      const MatrixXd turns = wigner_rows(m, n, rule.points, degree);
      const Eigen::Index rows = turns.cols();
      add_mean(turns, weights, one[std::abs(n)].bottomRightCorner(rows, rows), normals.is_even,
               normals.is_even && n > 0 ? 2 : 1, product, block.bottomRightCorner(rows, rows));
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
  if (!normals && has_normals(medium)) {
    const auto* mirrors = std::get_if<MirrorFlakes<Sggx>>(&medium);
    const Sggx& ndf = mirrors ? mirrors->ndf : std::get<LambertFlakes<Sggx>>(medium).ndf;
    triaxial_.emplace(ndf, mirrors != nullptr, f0, basis, product);
    return;
  }
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

std::size_t HarmonicKernel::bytes(const Medium& medium, const HarmonicBasis& basis) {
  if (!has_normals(medium)) return sizeof(double) * static_cast<std::size_t>(basis.degree() + 1);
  const auto normals = axial_normals(medium);
  const std::size_t degrees = basis.degree() + 1, size = basis.size();
  // Turns there and back, of cosines and sines; one block per m, or eight of all.
  const std::size_t parities = basis.is_even() ? 1 : 2;
  const std::size_t turns = normals && normals->axis.z == 1
                                ? 0
                                : 2 * parities * degrees * (degrees + 1) * (2 * degrees + 1) / 6;
  const std::size_t blocks =
      normals ? degrees * (degrees + 1) * (2 * degrees + 1) / 6 : size * size / 8;
  return sizeof(double) * (turns + blocks);
}

MatrixXd HarmonicKernel::apply(const MatrixXd& radiance) const {
  if (triaxial_) return triaxial_->apply(radiance);
  MatrixXd source(radiance.rows(), radiance.cols());
  if (by_m_.empty()) {
    for (int m = 0; m <= basis_.degree(); ++m)
      for (const bool sine : {false, true}) {
        if (!basis_.has(m, sine)) continue;
        const int first = basis_.first(m, sine), count = basis_.count(m);
        source.middleRows(first, count) =
            by_degree_.tail(count).asDiagonal() * radiance.middleRows(first, count);
      }
    return source;
  }
  const MatrixXd turned = turn_ ? turn_->to_axis(radiance) : radiance;
  tbb::parallel_for(0, basis_.degree() + 1, [&](int m) {
    for (const bool sine : {false, true}) {
      if (!basis_.has(m, sine)) continue;
      const int first = basis_.first(m, sine), count = basis_.count(m);
      source.middleRows(first, count) = product_(by_m_[m], turned.middleRows(first, count));
    }
  });
  return turn_ ? turn_->from_axis(source) : source;
}

std::optional<std::string> why_no_harmonics(const Medium& medium) {
  if (is_delta(medium)) return "mirror flakes at roughness 0 scatter into a delta";
  return std::nullopt;
}

}  // namespace lamella
