#include "volume/adding/layer_eigenmodes.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct SingularValues {
  MatrixXd u, v;
  VectorXd s;
};

// g = u s v'. Eigenvectors of g' g lose the small singular values; sweeps of Jacobi's rotations
// (Hestenes 1958) from there orthogonalise the columns of g v to the last digit.
std::optional<SingularValues> singular_values(const MatrixXd& g) {
  constexpr int kSweeps = 30;
  constexpr double kOrthogonal = 4e-16;
  const Index n = g.rows();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(g.transpose() * g);
  if (solver.info() != Eigen::Success) return std::nullopt;
  SingularValues result{g * solver.eigenvectors(), solver.eigenvectors(), VectorXd(n)};
  MatrixXd& u = result.u;
  MatrixXd& v = result.v;
  VectorXd squares = u.colwise().squaredNorm();
  const double enough = kOrthogonal * std::sqrt(static_cast<double>(n));
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool turned = false;
    for (Index j = 1; j < n; ++j)
      for (Index i = 0; i < j; ++i) {
        const double product = u.col(i).dot(u.col(j));
        if (!(std::abs(product) > enough * std::sqrt(squares[i] * squares[j]))) continue;
        turned = true;
        const double zeta = (squares[j] - squares[i]) / (2 * product);
        const double tangent = (zeta < 0 ? -1 : 1) / (std::abs(zeta) + std::hypot(1.0, zeta));
        const double cosine = 1 / std::hypot(1.0, tangent), sine = cosine * tangent;
        for (MatrixXd* m : {&u, &v})
          for (Index k = 0; k < n; ++k) {
            const double x = (*m)(k, i), y = (*m)(k, j);
            (*m)(k, i) = cosine * x - sine * y;
            (*m)(k, j) = sine * x + cosine * y;
          }
        squares[i] = u.col(i).squaredNorm();
        squares[j] = u.col(j).squaredNorm();
      }
    if (!turned) break;
  }
  for (Index k = 0; k < n; ++k) {
    result.s[k] = std::sqrt(squares[k]);
    if (!(result.s[k] > 0)) return std::nullopt;
    u.col(k) /= result.s[k];
  }
  return result;
}

VectorXd root_of_solid_angle(const DirectionSets& sets) {
  return (2 * kPi * sets.weight).cwiseSqrt();
}

}  // namespace

std::optional<LayerEigenmodes> layer_eigenmodes(const LayerScattering& scattering, int mode,
                                                const DirectionSets& sets) {
  if (!scattering.two_sided) return std::nullopt;
  const Index n = sets.nodes();
  const Parts& kernel = scattering.modes[mode];
  const VectorXd d = root_of_solid_angle(sets);
  const auto root = d.asDiagonal();
  const MatrixXd on = root * kernel[kAboveToDown].topLeftCorner(n, n) * root;
  const MatrixXd back = root * kernel[kAboveToUp].topLeftCorner(n, n) * root;
  const VectorXd sigma = scattering.sigma_in[0].head(n);
  if (!on.allFinite() || !back.allFinite() || !(sigma.minCoeff() > 0)) return std::nullopt;
  const auto factor = [&](const MatrixXd& scattered) {
    MatrixXd m = -scattered;
    m.diagonal() += sigma;
    return Eigen::LLT<MatrixXd>(m);
  };
  const Eigen::LLT<MatrixXd> sum = factor(on + back), difference = factor(on - back);
  if (sum.info() != Eigen::Success || difference.info() != Eigen::Success) return std::nullopt;
  const MatrixXd half = sum.matrixL().solve(MatrixXd(sets.in.head(n).asDiagonal()));
  const std::optional<SingularValues> values =
      singular_values(difference.matrixL().solve(half.transpose()).transpose());
  if (!values) return std::nullopt;
  const MatrixXd p = sum.matrixU().solve(values->u), q = difference.matrixU().solve(values->v);
  LayerEigenmodes modes{values->s, (p + q) / 2, (p - q) / 2};
  if (!modes.forward.allFinite() || !modes.backward.allFinite()) return std::nullopt;
  return modes;
}

FreeFlights::FreeFlights(const LayerScattering& scattering, const DirectionSets& sets) {
  const VectorXd sigma = scattering.sigma_in[0].head(sets.nodes());
  nu = sets.in.head(sets.nodes()).cwiseQuotient(sigma);
  excited = root_of_solid_angle(sets).cwiseQuotient(sigma.cwiseSqrt());
}

}  // namespace lamella
