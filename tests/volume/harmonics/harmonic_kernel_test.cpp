// Harmonics, their turns, and media's kernels in them: against quadrature of their definitions.
#include "volume/harmonics/harmonic_kernel.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "volume/harmonics/beam_quadrature.h"
#include "volume/harmonics/depth_panels.h"
#include "volume/harmonics/gmres.h"
#include "volume/harmonics/sphere_grid.h"
#include "volume/harmonics/wigner.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(HarmonicBasis, IsOrthonormal) {
  for (const int degree : {0, 1, 7, 24}) {
    const HarmonicBasis basis(degree);
    const SphereGrid grid = SphereGrid::quadrature(basis, 2 * degree + 2, 2 * degree + 2);
    MatrixXd gram = MatrixXd::Zero(basis.size(), basis.size());
    VectorXd values(basis.size());
    for (int k = 0; k < grid.size(); ++k) {
      basis.values(grid.direction(k), values);
      gram += grid.weight(k) * values * values.transpose();
    }
    EXPECT_LT((gram - MatrixXd::Identity(basis.size(), basis.size())).cwiseAbs().maxCoeff(), 1e-12)
        << degree;
  }
}

// At the highest degree that is used, m by m: Gauss-Legendre is exact for products of two.
TEST(HarmonicBasis, IsOrthonormalAtTheHighestDegree) {
  constexpr int kDegree = 192;
  const HarmonicBasis basis(kDegree);
  const Quadrature& rule = cached_gauss_legendre(kDegree + 2);
  VectorXd values(basis.size());
  for (const int m : {0, 1, 40, 96}) {
    MatrixXd gram = MatrixXd::Zero(basis.count(m), basis.count(m));
    for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
      basis.legendre(2 * rule.points[k] - 1, values);
      const VectorXd of_m = values.segment(basis.first(m, false), basis.count(m));
      gram += 2 * kPi * 2 * rule.weights[k] * of_m * of_m.transpose();
    }
    EXPECT_LT((gram - MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff(), 1e-12)
        << m;
  }
}

TEST(BeamQuadrature, IntegratesHarmonicsAndWhatJumpsAtTheHorizon) {
  const HarmonicBasis basis(12);
  VectorXd values(basis.size());
  for (const double mu : {-1.0, -0.7, -0.31, -0.29, 0.05, -1e-3, 1e-6}) {
    const Direction along = direction_from_mu_phi(mu, 4);
    const BeamQuadrature rule(along, 40, 96);
    VectorXd sums = VectorXd::Zero(basis.size());
    double flux_up = 0, near = 0;
    for (std::size_t k = 0; k < rule.directions.size(); ++k) {
      const Direction v = rule.directions[k];
      basis.values(v, values);
      sums += rule.weights[k] * values;
      flux_up += rule.weights[k] * std::fmax(0, v.z);
      near += rule.weights[k] * std::exp(20 * (dot(v, along) - 1));
    }
    EXPECT_NEAR(sums[0], std::sqrt(4 * kPi), 1e-9) << mu;
    EXPECT_LT(sums.tail(basis.size() - 1).cwiseAbs().maxCoeff(), 1e-9) << mu;
    EXPECT_NEAR(flux_up, kPi, 1e-9) << mu;
    EXPECT_NEAR(near, 2 * kPi / 20 * -std::expm1(-40), 1e-9) << mu;
  }
}

TEST(Gmres, SolvesWhatEliminationSolves) {
  constexpr int kSize = 40;
  const MatrixXd a = 0.9 / kSize * MatrixXd::Random(kSize, kSize);
  const VectorXd b = VectorXd::Random(kSize);
  const GmresResult found =
      solve_gmres([&](const VectorXd& x) { return VectorXd(a * x); }, b, 1e-12, 60);
  const VectorXd expected = (MatrixXd::Identity(kSize, kSize) - a).partialPivLu().solve(b);
  EXPECT_LT((found.solution - expected).norm(), 1e-11 * expected.norm());
  EXPECT_LE(found.residual, 1e-12);
  // Stopped short it says so, and nothing comes of nothing.
  EXPECT_GT(solve_gmres([&](const VectorXd& x) { return VectorXd(a * x); }, b, 1e-12, 2).residual,
            1e-12);
  EXPECT_EQ(
      solve_gmres([](const VectorXd& x) { return x; }, VectorXd::Zero(3), 1e-12, 5).solution.norm(),
      0);
}

TEST(SphereGrid, CarriesCoefficientsThereAndBack) {
  const HarmonicBasis basis(20);
  const SphereGrid grid = SphereGrid::quadrature(basis, 42, 42);
  const MatrixXd coefficients = MatrixXd::Random(basis.size(), 3);
  const MatrixXd values = grid.values(coefficients);
  VectorXd harmonics(basis.size());
  for (int k = 0; k < grid.size(); k += 37) {
    basis.values(grid.direction(k), harmonics);
    EXPECT_NEAR(values(1, k), harmonics.dot(coefficients.col(1)), 1e-12);
  }
  EXPECT_LT((grid.coefficients(values) - coefficients).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Wigner, IsTheKnownPolynomialAtLowDegreesAndOrthogonalAtHighOnes) {
  VectorXd d(3);
  for (const double angle : {0.0, 0.3, 1.2, kPi / 2, 3.0}) {
    const double c = std::cos(angle), s = std::sin(angle);
    wigner_d(1, 0, angle, d);
    EXPECT_NEAR(d[1], -s / std::sqrt(2), 1e-14);
    EXPECT_NEAR(d[2], -std::sqrt(1.5) * s * c, 1e-14);
    wigner_d(-1, 1, angle, d);
    EXPECT_NEAR(d[1], (1 - c) / 2, 1e-14);
    wigner_d(0, 0, angle, d);
    EXPECT_NEAR(d[2], (3 * c * c - 1) / 2, 1e-14);
    wigner_d(2, -2, angle, d);
    EXPECT_NEAR(d[2], std::pow((1 - c) / 2, 2), 1e-14);
  }
  // Rows of a turn have length 1.
  constexpr int kDegree = 192;
  VectorXd values(kDegree + 1);
  for (const double angle : {0.01, 0.9, 3.1})
    for (const int m : {0, 3, -50, 192}) {
      double square = 0;
      for (int n = -kDegree; n <= kDegree; ++n) {
        wigner_d(m, n, angle, values);
        square += values[kDegree] * values[kDegree];
      }
      EXPECT_NEAR(square, 1, 1e-11) << m << " angle " << angle;
    }
}

TEST(HarmonicTurn, ShowsAFunctionFromTheAxis) {
  const HarmonicBasis basis(15);
  const VectorXd coefficients = VectorXd::Random(basis.size());
  VectorXd here(basis.size()), there(basis.size());
  for (const Direction axis : {direction_from_mu_phi(0.3, 2.1), direction_from_mu_phi(-0.8, -1),
                               Direction{0, 0, -1}, Direction{1, 0, 0}}) {
    const HarmonicTurn turn(basis, axis);
    const MatrixXd turned = turn.to_axis(coefficients);
    EXPECT_LT((turn.from_axis(turned) - coefficients).cwiseAbs().maxCoeff(), 1e-13);
    const double theta = std::acos(axis.z), phi = std::atan2(axis.y, axis.x);
    for (int k = 0; k < 10; ++k) {
      const Direction v = direction_from_mu_phi(-0.95 + 0.2 * k, 0.7 * k);
      const Direction about_y{std::cos(theta) * v.x + std::sin(theta) * v.z, v.y,
                              std::cos(theta) * v.z - std::sin(theta) * v.x};
      const Direction w{std::cos(phi) * about_y.x - std::sin(phi) * about_y.y,
                        std::sin(phi) * about_y.x + std::cos(phi) * about_y.y, about_y.z};
      basis.values(w, here);
      basis.values(v, there);
      EXPECT_NEAR(there.dot(turned.col(0)), here.dot(coefficients), 1e-12);
    }
  }
}

// What a medium makes of smooth radiance, against the integral of its phase function about the
// direction where it may jump. The tolerance is the degree's: kernels of that roughness leave less.
TEST(HarmonicKernel, ScattersSmoothLightAsThePhaseFunctionDoes) {
  const Direction axis = normalized(Direction{0.6, -0.3, 0.5});
  struct Case {
    Medium medium;
    int degree;
    double tolerance;
  };
  for (const auto& [medium, degree, tolerance] :
       {Case{MirrorFlakes<Sggx>{Sggx(Sggx::surface_matrix(0.5, axis))}, 32, 1e-8},
        Case{MirrorFlakes<Sggx>{Sggx(Sggx::fiber_matrix(0.3, axis))}, 48, 1e-7},
        Case{MirrorFlakes<Sggx>{Sggx({0.5, 0.7, 1, 0.2, -0.1, 0.15})}, 32, 1e-8},
        Case{MirrorFlakes<Sggx>{Sggx({0.15, 0.4, 1, 0.02, 0, 0})}, 48, 1e-6},
        Case{LambertFlakes<Sggx>{Sggx(Sggx::fiber_matrix(0.5, axis))}, 32, 1e-8},
        Case{MirrorFlakes<Vmf>{Vmf(0.5, axis)}, 32, 1e-8},
        Case{LambertFlakes<Vmf>{Vmf(0.7, axis)}, 24, 1e-6}, Case{LambertSphere{}, 24, 1e-8},
        Case{HenyeyGreenstein{0.6}, 24, 1e-8}, Case{Rayleigh{}, 4, 1e-8}}) {
    const HarmonicBasis basis(degree);
    const HarmonicKernel kernel(medium, 1, basis);
    const Direction d = normalized(Direction{0.2, -0.5, -0.7});
    const auto radiance = [&](Direction v) { return std::exp(2 * dot(v, d)); };
    const SphereGrid grid = SphereGrid::quadrature(basis, 60, 120);
    MatrixXd values(1, grid.size());
    for (int k = 0; k < grid.size(); ++k) values(0, k) = radiance(grid.direction(k));
    const MatrixXd source = kernel.apply(grid.coefficients(values));
    VectorXd harmonics(basis.size());
    for (const Direction wo : {direction_from_mu_phi(0.6, 1), direction_from_mu_phi(-0.3, 4)}) {
      double expected = 0;
      const BeamQuadrature about(wo, 80, 160);
      for (std::size_t k = 0; k < about.directions.size(); ++k) {
        const Direction v = about.directions[k];
        expected +=
            about.weights[k] * radiance(v) * sigma(medium, -v) * phase(medium, -v, wo).density;
      }
      basis.values(wo, harmonics);
      EXPECT_NEAR(harmonics.dot(source.col(0)) / expected, 1, tolerance)
          << medium.index() << " degree " << degree;
    }
  }
}

// Three distinct eigenvalues, by the definition of Lambertian flakes: radiance 1 + v . d irradiates
// the side of a flake with the normal m by pi (1 - 2/3 m . d).
TEST(HarmonicKernel, OfLambertianFlakesWithoutAxisIsTheirMean) {
  const Direction d = normalized(Direction{0.2, -0.5, -0.7});
  for (const std::array<double, 6>& s :
       {std::array{0.5, 0.7, 1.0, 0.2, -0.1, 0.15}, std::array{1.0, 0.35, 0.6, 0.1, 0.1, 0.0}}) {
    const Sggx ndf(s);
    const HarmonicBasis basis(32);
    const HarmonicKernel kernel(LambertFlakes<Sggx>{ndf}, 1, basis);
    const SphereGrid grid = SphereGrid::quadrature(basis, 60, 120);
    MatrixXd values(1, grid.size());
    for (int k = 0; k < grid.size(); ++k) values(0, k) = 1 + dot(grid.direction(k), d);
    const MatrixXd source = kernel.apply(grid.coefficients(values));
    VectorXd harmonics(basis.size());
    for (const Direction wo : {direction_from_mu_phi(0.6, 1), direction_from_mu_phi(-0.3, 4)}) {
      // D is even: half of the sphere is half of the integral.
      double expected = ndf.sigma(wo);
      for (int k = 0; k < grid.size(); ++k) {
        const Direction m = grid.direction(k);
        expected -= grid.weight(k) * ndf.density_of(m) / 3 * dot(m, d) * dot(wo, m);
      }
      basis.values(wo, harmonics);
      EXPECT_NEAR(harmonics.dot(source.col(0)) / expected, 1, 1e-6);
    }
  }
}

TEST(HarmonicKernel, OfMirrorsHasSchlicksFactor) {
  for (const Medium& medium :
       {Medium(MirrorFlakes<Sggx>{Sggx(Sggx::surface_matrix(0.6, Direction{0, 0.6, 0.8}))}),
        Medium(MirrorFlakes<Sggx>{Sggx({0.6, 0.8, 1, 0.1, 0, 0.1})})}) {
    const HarmonicBasis basis(28);
    const HarmonicKernel kernel(medium, 0.1, basis);
    VectorXd uniform = VectorXd::Zero(basis.size());
    uniform[0] = std::sqrt(4 * kPi);
    const Direction wo = direction_from_mu_phi(0.7, 2);
    const BeamQuadrature about(wo, 80, 160);
    double expected = 0;
    for (std::size_t k = 0; k < about.directions.size(); ++k) {
      const Direction v = about.directions[k];
      const PhaseValue p = phase(medium, -v, wo);
      expected += about.weights[k] * sigma(medium, -v) * p.density * (0.1 + 0.9 * p.schlick);
    }
    VectorXd harmonics(basis.size());
    basis.values(wo, harmonics);
    EXPECT_NEAR(harmonics.dot(kernel.apply(uniform).col(0)) / expected, 1, 1e-8);
  }
}

// Attenuation and gathering within a panel, against quadrature fine enough for each depth.
TEST(PanelIntegrals, AreThoseOfPolynomialsUnderAnExponential) {
  constexpr int kNodes = 7;
  const PanelIntegrals integrals(kNodes);
  const Quadrature& nodes = cached_gauss_legendre(kNodes);
  const Quadrature& fine = cached_gauss_legendre(200);
  const auto polynomial = [](double t) { return 1 + t * (2 - 3 * t + t * t * t); };
  double gather[kNodes * kNodes], leave[kNodes], pass[kNodes];
  for (const double x : {0.0, 1e-9, 0.1, 3.0, 23.9, 24.1, 100.0, 1e5}) {
    integrals.at(x, gather, leave, pass);
    for (int i = 0; i <= kNodes; ++i) {
      const double end = i < kNodes ? nodes.points[i] : 1;
      double found = 0, expected = 0;
      for (int j = 0; j < kNodes; ++j)
        found += (i < kNodes ? gather[j * kNodes + i] : leave[j]) * polynomial(nodes.points[j]);
      // In t' = x (end - t), of which only some 40 count.
      const double range = x * end > 40 ? 40 / x : end;
      for (Eigen::Index q = 0; q < fine.points.size(); ++q) {
        const double back = range * fine.points[q];
        expected += range * fine.weights[q] * std::exp(-x * back) * polynomial(end - back);
      }
      EXPECT_NEAR(found, expected, 1e-12 * (1 + expected)) << "x " << x << " node " << i;
      EXPECT_NEAR(found / expected, 1, 1e-9) << "x " << x << " node " << i;
      if (i < kNodes) {
        EXPECT_EQ(pass[i], std::exp(-x * end));
      }
    }
  }
}

}  // namespace
}  // namespace lamella
