#include "phase/medium/sggx.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <boost/math/quadrature/gauss.hpp>

#include "phase/math/clamped_cosines.h"
#include "tests/phase/medium/media_cases.h"

namespace lamella::testing {
namespace {

Eigen::Matrix3d full(const std::array<double, 6>& s) {
  Eigen::Matrix3d m;
  m << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
  return m;
}

Eigen::Vector3d eigen(Direction w) { return {w.x, w.y, w.z}; }

// D(m) = 1 / (pi sqrt(det S) (m^T S^-1 m)^2), Heitz et al. 2015, eq. 7, by Eigen.
class ReferenceDensity {
 public:
  explicit ReferenceDensity(const std::array<double, 6>& s)
      : inverse_(full(s).inverse()), root_(std::sqrt(full(s).determinant())) {}

  double operator()(Direction m) const {
    const double q = eigen(m).dot(inverse_ * eigen(m));
    return 1 / (kPi * root_ * q * q);
  }

 private:
  Eigen::Matrix3d inverse_;
  double root_;
};

// With a width of the distribution about an axis in which its quadrature converges.
struct Shape {
  std::string name;
  std::array<double, 6> s;
  Direction axis;
  double width;
};

std::vector<Shape> shapes() {
  const double wide = std::numeric_limits<double>::infinity();
  const Direction z{0, 0, 1};
  return {{"surface 0.001", Sggx::surface_matrix(0.001, z), z, 0.001},
          {"tilted surface 0.05", Sggx::surface_matrix(0.05, kTilted), kTilted, 0.05},
          {"surface 1", Sggx::surface_matrix(1, z), z, wide},
          {"fiber 0.02", Sggx::fiber_matrix(0.02, kTilted), kTilted, wide},
          {"fiber 0.5", Sggx::fiber_matrix(0.5, {1, 0, 0}), {1, 0, 0}, wide},
          {"matrix", tilted_matrix(), z, wide}};
}

// Integral of D <w, m> dm. Wide distributions about w, whose horizon is then no kink; narrow ones
// about the normal that faces w (the other side adds less than the tolerance only at w = n).
double projected_area_by_quadrature(const Shape& shape, Direction w) {
  const ReferenceDensity density(shape.s);
  const auto projected = [&](Direction m) { return density(m) * std::max(0.0, dot(w, m)); };
  if (!std::isfinite(shape.width)) return integrate_sphere(projected, w, 1e-6);
  const auto half = [&](double sign) {
    return integrate_sphere(
        [&](Direction m) { return sign * dot(m, shape.axis) > 0 ? projected(m) : 0; },
        {.axis = sign * shape.axis, .width = shape.width}, 1e-5);
  };
  return half(1) + half(-1);
}

TEST(Sggx, DensityIsThatOfTheInverseMatrix) {
  for (const Shape& shape : shapes())
    for (const Direction m : incident_directions()) {
      const double expected = ReferenceDensity(shape.s)(m);
      // The condition of S, 1e6 at alpha = 0.001, times the rounding error.
      EXPECT_NEAR(Sggx(shape.s).density_of(m), expected, 1e-9 * expected) << shape.name;
      EXPECT_NEAR(Sggx(shape.s).density_of(7 * m), expected, 1e-9 * expected) << shape.name;
    }
}

TEST(Sggx, SigmaIsTheProjectedAreaOfTheNormals) {
  for (const Shape& shape : shapes()) {
    const Sggx ndf(shape.s);
    for (const Direction w : incident_directions()) {
      // The error of the rule where the horizon of w crosses a narrow peak; measured: below 1e-4.
      EXPECT_NEAR(projected_area_by_quadrature(shape, w), ndf.sigma(w), 2e-4 * ndf.sigma(w))
          << shape.name << ' ' << to_text(w);
      EXPECT_NEAR(ndf.sigma(w), std::sqrt(eigen(w).dot(full(shape.s) * eigen(w))),
                  1e-9 * ndf.sigma(w));
    }
  }
}

TEST(Sggx, DensityIntegratesToFourAtTheIdentity) {
  const Sggx ndf({1, 1, 1, 0, 0, 0});
  EXPECT_NEAR(integrate_sphere([&](Direction m) { return ndf.density_of(m); }, Direction{0, 0, 1}),
              4, 1e-12);
}

TEST(Sggx, VisibleNormalsFollowTheProjectedDensity) {
  for (const Shape& shape : shapes()) {
    const Sggx ndf(shape.s);
    const ReferenceDensity reference(shape.s);
    for (const Direction wi : incident_directions()) {
      const Direction axis = dot(wi, shape.axis) < 0 ? -shape.axis : shape.axis;
      const auto density = [&](Direction m) {
        return reference(m) * std::max(0.0, dot(wi, m)) / ndf.sigma(wi);
      };
      EXPECT_GE(
          sampler_p_value(
              shape.name + " normals from " + to_text(wi), {.axis = axis, .width = shape.width},
              [&](RandomStream& stream) { return ndf.visible_normal(wi, stream); }, density,
              100000),
          test_level());
    }
  }
}

// The narrow rings of a fiber in the coordinate u of the unit sphere, m along A u, where the
// density is the cosine law about A^T w.
TEST(Sggx, VisibleNormalsOfTheNarrowestMatricesFollowTheCosineLawOfTheSphere) {
  for (const auto& s : {Sggx::fiber_matrix(0.001, kTilted), Sggx::surface_matrix(0.001, kTilted)}) {
    const Sggx ndf(s);
    for (const Direction wi : incident_directions()) {
      const Direction v = normalized(ndf.matrix().apply_transposed(wi));
      EXPECT_GE(sampler_p_value(
                    "narrow normals from " + to_text(wi), v,
                    [&](RandomStream& stream) {
                      return normalized(ndf.matrix().solve(ndf.visible_normal(wi, stream)));
                    },
                    [&](Direction u) { return std::max(0.0, dot(u, v)) / kPi; }, 100000),
                test_level());
    }
  }
}

TEST(Sggx, IdentityWithMirrorsIsIsotropic) {
  const Medium medium = MirrorFlakes<Sggx>{Sggx({1, 1, 1, 0, 0, 0})};
  for (const Direction wi : incident_directions()) {
    EXPECT_NEAR(sigma(medium, wi), 1, 1e-15);
    for (const Direction wo : incident_directions())
      EXPECT_NEAR(phase(medium, wi, wo).density, 1 / (4 * kPi), 1e-15);
  }
}

// Integral of D <w_i, m> <w_o, m> dm / (pi sigma_i) in the frame of the axis, the azimuth in closed
// form, over m itself with D written from S: neither diffuse_phase's substitution nor its lune.
double axial_diffuse_phase(const Shape& shape, Direction wi, Direction wo) {
  const ClampedCosines pair(wi, wo, shape.axis);
  const Direction across = frame_around(shape.axis).s;
  const ReferenceDensity density(shape.s);
  const auto integrand = [&](double v) {
    const double r = std::sqrt((1 - v) * (1 + v));
    return density(r * across + v * shape.axis) * pair.overlap(v);
  };
  std::vector<double> breaks{0};
  for (const double kink : pair.kinks()) breaks.insert(breaks.end(), {kink, -kink});
  const double width = std::isfinite(shape.width) ? shape.width : 0.02;
  for (double scale = width * width / 4; scale < 1; scale *= 4) {
    breaks.insert(breaks.end(), {1 - scale, scale - 1});
    breaks.insert(breaks.end(), {scale, -scale});
  }
  return integrate_panels(integrand, -1, 1, breaks) / (kPi * Sggx(shape.s).sigma(wi));
}

TEST(Sggx, DiffusePhaseOfAxialShapesMatchesAQuadratureOverTheAxis) {
  double worst = 0;
  for (const Shape& shape : shapes()) {
    if (shape.name == "matrix") continue;
    const double tolerance = shape.name == "surface 0.001" ? 1e-6 : 1e-8;  // as documented
    const Sggx ndf(shape.s);
    for (const Direction wi : {incident_directions()[1], incident_directions()[3]})
      for (const Direction wo : {direction_from_mu_phi(0.9, 2), direction_from_mu_phi(0.2, 1),
                                 direction_from_mu_phi(-0.5, 3)}) {
        const double expected = axial_diffuse_phase(shape, wi, wo);
        EXPECT_NEAR(ndf.diffuse_phase(wi, wo), expected, tolerance * expected)
            << shape.name << ' ' << to_text(wi) << ' ' << to_text(wo);
        worst = std::max(worst, std::abs(ndf.diffuse_phase(wi, wo) / expected - 1));
        // The lune, which serves any S.
        EXPECT_NEAR(ndf.diffuse_phase_over_lune(wi, wo), expected, 1e-7 * expected) << shape.name;
      }
  }
  RecordProperty("worst_relative_error", lamella::to_text(worst));
}

TEST(Sggx, LambertFlakesOfTheIdentityAreLambertSpheres) {
  const Sggx ndf({1, 1, 1, 0, 0, 0});
  for (const Direction wi : incident_directions())
    for (const Direction wo : incident_directions())
      EXPECT_NEAR(ndf.diffuse_phase(wi, wo), lambert_sphere_phase(-dot(wi, wo)), 1e-10);
}

TEST(Sggx, RefusesMatricesThatAreNotPositiveDefinite) {
  EXPECT_TRUE(Sggx::is_positive_definite({1, 1, 1e-12, 0, 0, 0}));
  for (const std::array<double, 6>& s : {std::array<double, 6>{1, 1, 0, 0, 0, 0},
                                         {1, 1, -1, 0, 0, 0},
                                         {1, 1, 1, 1, 0, 0},
                                         {1, 1, 1, 0.9, 0.9, -0.9},
                                         {NAN, 1, 1, 0, 0, 0},
                                         {1, INFINITY, 1, 0, 0, 0}})
    EXPECT_FALSE(Sggx::is_positive_definite(s));
}

}  // namespace
}  // namespace lamella::testing
