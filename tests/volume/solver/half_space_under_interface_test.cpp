#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "phase/surface/fresnel_formulas.h"
#include "tests/volume/run/stacks.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/quadrature/quadrature.h"
#include "volume/solver/deterministic.h"

// A half space that scatters isotropically under a smooth interface, by Chandrasekhar's H function
// and Fresnel's reflectance, against the solver and against walks.
//
// Below the interface, index n, the half space of albedo a reflects light from the cosine m to the
// cosine u by f_a(m, u) = a H(m) H(u) / (4 pi (m + u)), the same at every azimuth, with
//   1 / H(u) = sqrt(1 - a) + a / 2 integral over (0, 1) of m H(m) / (u + m) dm.
// Light of unit irradiance from the cosine mu_i above arrives as the beam 1 - F(mu_i) along the
// refracted cosine m_i. I(u), the radiance that goes up to the interface, is what the half space
// makes of the beam and of what the interface sends back down, R(m) I(m) from each m, R being
// Fresnel's reflectance from within (1 below the critical cosine):
//   I(u) = (1 - F(mu_i)) f_a(m_i, u) + a / 2 H(u) integral of H(m) m R(m) I(m) / (u + m) dm.
// Above, f(mu_i, mu_o) = (1 - F(mu_o)) I(m_o) / n^2. The equation is solved on Gauss nodes in
// (0, critical) and (critical, 1), crowded so that the root of R at the critical cosine and the
// logarithm of H at 0 are smooth in the variable of the rule; I at any other cosine is the
// equation's right side (Nystroem).

namespace lamella {
namespace {

class CoatedHalfSpace {
 public:
  CoatedHalfSpace(double index, double albedo, int nodes = 160) : n_(index), a_(albedo) {
    const double critical = n_ > 1 ? std::sqrt((1 - 1 / n_) * (1 + 1 / n_)) : 0;
    const Quadrature& rule = cached_gauss_legendre(nodes);
    for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
      const double u = rule.points[k], w = rule.weights[k];
      if (critical > 0) {
        // u^3 (4 - 3 u): flat at 0, like a square root at the critical cosine.
        add(critical * u * u * u * (4 - 3 * u), critical * 12 * u * u * (1 - u) * w);
        add(critical + (1 - critical) * u * u, (1 - critical) * 2 * u * w);
      } else {
        add(u * u * u, 3 * u * u * w);
      }
    }
    solve_h();
  }

  [[nodiscard]] double f(double mu_i, double mu_o) const {
    const Refraction<double> in = refraction(mu_i, n_), out = refraction(mu_o, n_);
    if (!(in.cosine > 0) || !(out.cosine > 0)) return 0;
    const std::vector<double> upward = radiance(in);
    return (1 - out.reflectance) / (n_ * n_) * (beam(in, out.cosine) + back(upward, out.cosine));
  }

  // The share that leaves above, the interface's mirror image included.
  [[nodiscard]] double reflected(double mu_i) const {
    const Refraction<double> in = refraction(mu_i, n_);
    if (!(in.cosine > 0)) return 1;
    const std::vector<double> upward = radiance(in);
    double sum = in.reflectance;
    for (std::size_t k = 0; k < m_.size(); ++k)
      sum += 2 * kPi * (1 - r_[k]) * upward[k] * m_[k] * w_[k];
    return sum;
  }

 private:
  void add(double m, double w) {
    m_.push_back(m);
    w_.push_back(w);
    r_.push_back(refraction(m, 1 / n_).reflectance);
  }

  [[nodiscard]] double inverse_h(double u) const {
    double sum = std::sqrt(1 - a_);
    for (std::size_t k = 0; k < m_.size(); ++k) sum += a_ / 2 * w_[k] * m_[k] * h_[k] / (u + m_[k]);
    return sum;
  }

  void solve_h() {
    h_.assign(m_.size(), 1);
    for (int turn = 0; turn < 2000; ++turn) {
      std::vector<double> next(m_.size());
      double change = 0;
      for (std::size_t k = 0; k < m_.size(); ++k) {
        // Half a step: the plain iteration swings about the solution.
        next[k] = (h_[k] + 1 / inverse_h(m_[k])) / 2;
        change = std::max(change, std::abs(next[k] - h_[k]));
      }
      h_ = next;
      if (change < 1e-15) break;
    }
  }

  [[nodiscard]] double beam(const Refraction<double>& in, double u) const {
    return (1 - in.reflectance) * a_ /
           (4 * kPi * (in.cosine + u) * inverse_h(in.cosine) * inverse_h(u));
  }

  [[nodiscard]] double back(const std::vector<double>& upward, double u) const {
    double sum = 0;
    for (std::size_t k = 0; k < m_.size(); ++k)
      sum += w_[k] * h_[k] * m_[k] * r_[k] * upward[k] / (u + m_[k]);
    return a_ / 2 / inverse_h(u) * sum;
  }

  [[nodiscard]] std::vector<double> radiance(const Refraction<double>& in) const {
    const auto size = static_cast<Eigen::Index>(m_.size());
    Eigen::MatrixXd matrix(size, size);
    Eigen::VectorXd source(size);
    for (Eigen::Index j = 0; j < size; ++j) {
      const double u = m_[j];
      for (Eigen::Index k = 0; k < size; ++k)
        matrix(j, k) = (j == k) - a_ / 2 * h_[j] * h_[k] * m_[k] * r_[k] * w_[k] / (u + m_[k]);
      source[j] = beam(in, u);
    }
    const Eigen::VectorXd solved = matrix.partialPivLu().solve(source);
    return {solved.begin(), solved.end()};
  }

  double n_, a_;
  std::vector<double> m_, w_, r_, h_;
};

std::string smooth(double ior) {
  return fmt::format("[[layer]]\ninterface = \"smooth\"\nior = {}\n", ior);
}

Stack coated(double index, double albedo) {
  return stack_of(smooth(index) + layer(kIsotropic, albedo, kInfinity));
}

const double kIndices[] = {0.75, 1.1, 1.5, 3};

TEST(HalfSpaceUnderInterface, QuadratureIsConverged) {
  for (const double n : kIndices) {
    const CoatedHalfSpace coarse(n, 0.9, 80), fine(n, 0.9, 160);
    EXPECT_NEAR(coarse.f(0.9, 0.7) / fine.f(0.9, 0.7), 1, 1e-10) << n;
    EXPECT_NEAR(coarse.reflected(0.9) / fine.reflected(0.9), 1, 1e-10) << n;
  }
  // Giovanelli 1955, at normal incidence, gives 0.2600; its last digit is one too many.
  EXPECT_NEAR(CoatedHalfSpace(1.5, 0.9).reflected(1), 0.2600, 1e-4);
  // White half spaces reflect everything.
  EXPECT_NEAR(CoatedHalfSpace(1.5, 1).reflected(0.6), 1, 1e-10);
}

TEST(HalfSpaceUnderInterface, IsWhatTheSolverFinds) {
  for (const double n : kIndices)
    for (const double albedo : {0.5, 0.9, 0.999}) {
      const CoatedHalfSpace exact(n, albedo);
      const DeterministicSolution s =
          solve_deterministic(coated(n, albedo), {.tolerance = 1e-9, .max_seconds = 30});
      const std::string what = fmt::format("n {} albedo {}", n, albedo);
      for (const auto& [mu_i, mu_o] :
           {std::pair{1.0, 0.9}, {0.75, 0.95}, {0.8, 0.1}, {0.02, 0.7}}) {
        const double f =
            s.f(direction_from_mu_phi(mu_i, 0), direction_from_mu_phi(mu_o, 1)).order[Order::all].r;
        const double expected = exact.f(mu_i, mu_o);
        EXPECT_NEAR(f, expected, 1e-8 * expected + 1e-15) << what << ' ' << mu_i << ' ' << mu_o;
      }
      const double list[] = {1, 0.75, 0.1};
      const auto energies = s.energies(list);
      for (std::size_t k = 0; k < std::size(list); ++k)
        EXPECT_NEAR(energies[k].reflected[Order::all].r, exact.reflected(list[k]), 1e-8)
            << what << ' ' << list[k];
    }
}

TEST(HalfSpaceUnderInterface, IsWhatWalksFind) {
  for (const double n : kIndices) {
    const CoatedHalfSpace exact(n, 0.9);
    const std::vector<double> mu_o{0.95, 0.8, 0.3, 0.05};
    std::vector<Direction> points;
    for (const double mu : mu_o) points.push_back(direction_from_mu_phi(mu, 1 + mu));
    for (const double mu_i : {0.9, 0.72}) {
      Simulation walk(coated(n, 0.9), make_plan(coated(n, 0.9)), direction_from_mu_phi(mu_i, 0),
                      points, 3);
      walk.advance(testing::soaked(200000));
      for (std::size_t k = 0; k < points.size(); ++k) {
        const Estimate e = testing::point_estimate(walk, kTallyOrders, static_cast<int>(k),
                                                   static_cast<int>(points.size()));
        EXPECT_NEAR(e.value, exact.f(mu_i, mu_o[k]),
                    testing::allowed_z() * e.standard_error + 1e-15)
            << "n " << n << " mu_i " << mu_i << " mu_o " << mu_o[k];
      }
      const Estimate reflected = batch_estimate(walk.batches(), [](const BatchTally& b) {
        double sum = b.energy.zero_up[0];
        for (const auto& order : b.energy.up) sum += order[0];
        return sum;
      });
      EXPECT_NEAR(reflected.value, exact.reflected(mu_i),
                  testing::allowed_z() * reflected.standard_error)
          << "n " << n << " mu_i " << mu_i;
    }
  }
}

}  // namespace
}  // namespace lamella
