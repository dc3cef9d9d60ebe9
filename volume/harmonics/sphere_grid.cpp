#include "volume/harmonics/sphere_grid.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "volume/quadrature/quadrature.h"

namespace lamella {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SphereGrid::SphereGrid(const HarmonicBasis& basis, std::vector<double> mu, std::vector<double> phi,
                       MatrixProduct product)
    : basis_(basis), product_(product), mu_(std::move(mu)), phi_(std::move(phi)) {
  const int degree = basis.degree();
  VectorXd values(basis.size());
  for (int m = 0; m <= degree; ++m)
    legendre_.emplace_back(basis.count(m), static_cast<Index>(mu_.size()));
  for (std::size_t k = 0; k < mu_.size(); ++k) {
    basis.legendre(mu_[k], values);
    for (int m = 0; m <= degree; ++m)
      legendre_[m].col(static_cast<Index>(k)) =
          values.segment(basis.first(m, false), basis.count(m));
  }
  for (const MatrixXd& of_mu : legendre_) legendre_of_l_.emplace_back(of_mu.transpose());
  waves_.resize(static_cast<Index>(phi_.size()), waves());
  for (std::size_t p = 0; p < phi_.size(); ++p) {
    const Index row = static_cast<Index>(p);
    waves_(row, 0) = 1;
    for (int m = 1; m <= degree; ++m) {
      waves_(row, wave(m, false)) = std::sqrt(2.0) * std::cos(m * phi_[p]);
      if (basis_.has(m, true)) waves_(row, wave(m, true)) = std::sqrt(2.0) * std::sin(m * phi_[p]);
    }
  }
  waves_of_phi_ = waves_.transpose();
}

SphereGrid SphereGrid::quadrature(const HarmonicBasis& basis, int mu_per_hemisphere, int azimuths,
                                  MatrixProduct product) {
  const Quadrature& rule = cached_gauss_legendre(mu_per_hemisphere);
  VectorXd mu(rule.points.size()), weight(rule.points.size());
  for (Index k = 0; k < rule.points.size(); ++k) {
    const double t = rule.points[k];
    mu[k] = t * t;
    weight[k] = rule.weights[k] * 2 * t;
  }
  return quadrature(basis, mu, weight, azimuths, product);
}

SphereGrid SphereGrid::quadrature(const HarmonicBasis& basis, const VectorXd& of_hemisphere,
                                  const VectorXd& weights, int azimuths, MatrixProduct product) {
  std::vector<double> mu, phi, weight;
  const double step = 2 * kPi / azimuths;
  const double share = basis.is_even() ? 2 * step : step;
  for (const double sign : {1.0, -1.0})
    for (Index k = 0; k < of_hemisphere.size(); ++k) {
      mu.push_back(sign * of_hemisphere[k]);
      weight.push_back(share * weights[k]);
    }
  // Half a step off the axes, where planes of symmetry lie.
  const int kept = basis.is_even() ? azimuths / 2 : azimuths;
  for (int p = 0; p < kept; ++p) phi.push_back(step * (p + 0.5));
  SphereGrid grid(basis, std::move(mu), std::move(phi), product);
  grid.weight_ = std::move(weight);
  return grid;
}

Direction SphereGrid::direction(int k) const {
  return direction_from_mu_phi(mu_[k / azimuths()], phi_[k % azimuths()]);
}

MatrixXd SphereGrid::values(const MatrixXd& coefficients) const {
  const Index functions = coefficients.cols(), cosines = static_cast<Index>(mu_.size());
  const int degree = basis_.degree();
  // Functions down, then by wave the cosines.
  MatrixXd amplitudes(functions, cosines * waves());
  tbb::parallel_for(0, degree + 1, [&](int m) {
    for (const bool sine : {false, true}) {
      if (!basis_.has(m, sine)) continue;
      amplitudes.middleCols(wave(m, sine) * cosines, cosines) =
          product_(coefficients.middleRows(basis_.first(m, sine), basis_.count(m)).transpose(),
                   legendre_[m]);
    }
  });
  MatrixXd result(functions, size());
  tbb::parallel_for(Index{0}, cosines, [&](Index k) {
    MatrixXd of_mu(functions, waves());
    for (int wave = 0; wave < waves(); ++wave) of_mu.col(wave) = amplitudes.col(wave * cosines + k);
    result.middleCols(k * azimuths(), azimuths()) = product_(of_mu, waves_of_phi_);
  });
  return result;
}

MatrixXd SphereGrid::coefficients(const MatrixXd& values) const {
  const Index functions = values.rows(), cosines = static_cast<Index>(mu_.size());
  const int degree = basis_.degree();
  MatrixXd amplitudes(functions, cosines * waves());
  tbb::parallel_for(Index{0}, cosines, [&](Index k) {
    const MatrixXd of_mu =
        weight_[k] * product_(values.middleCols(k * azimuths(), azimuths()), waves_);
    for (int wave = 0; wave < waves(); ++wave) amplitudes.col(wave * cosines + k) = of_mu.col(wave);
  });
  MatrixXd result(basis_.size(), functions);
  tbb::parallel_for(0, degree + 1, [&](int m) {
    for (const bool sine : {false, true}) {
      if (!basis_.has(m, sine)) continue;
      result.middleRows(basis_.first(m, sine), basis_.count(m)) = product_(
          legendre_[m], amplitudes.middleCols(wave(m, sine) * cosines, cosines).transpose());
    }
  });
  return result;
}

}  // namespace lamella
