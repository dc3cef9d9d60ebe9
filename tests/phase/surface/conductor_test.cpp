#include "phase/surface/conductor.h"

#include <gtest/gtest.h>

#include "phase/math/direction.h"
#include "tests/statistics/statistics.h"

namespace lamella::testing {
namespace {

Conductor copper(FacetShape shape, double x, double y, Masking masking, bool multiple = false) {
  return Conductor({.facets = {shape, x, y},
                    .masking = masking,
                    .multiple = multiple,
                    .eta = {0.2, 0.92, 1.1},
                    .k = {3.91, 2.45, 2.14}});
}

SphereCells upward() { return {.axis = {0, 0, 1}, .width = 0.3}; }

TEST(Conductor, SamplesAverageToItsReflectedEnergy) {
  for (const FacetShape shape : {FacetShape::ggx, FacetShape::beckmann})
    for (const Masking masking : {Masking::beta, Masking::separable})
      for (const double mu : {0.9, 0.2}) {
        const Conductor c = copper(shape, 0.3, 0.5, masking);
        const Direction wi = direction_from_mu_phi(mu, 0.3);
        RandomStream stream(3, 0, StreamPurpose::test);
        std::vector<double> all(40000), side(all.size());
        for (std::size_t n = 0; n < all.size(); ++n) {
          const auto s = c.sample(wi, stream);
          all[n] = s->weight.g;
          side[n] = s->wo.x > 0 ? s->weight.g : 0;
          EXPECT_LE(s->weight.g + s->lost.g, 1);
        }
        const auto f = [&](Direction wo) { return wo.z > 0 ? c.single(wi, wo).g * wo.z : 0.0; };
        EXPECT_GE(mean_p_value(all, integrate_sphere(f, upward(), 1e-6)), test_level());
        const auto half = [&](Direction wo) { return wo.x > 0 ? f(wo) : 0; };
        EXPECT_GE(mean_p_value(side, integrate_sphere(half, upward(), 1e-4)), test_level());
      }
}

TEST(Conductor, FirstOrderOfAllReflectionsIsSingleScattering) {
  // In a channel that reflects next to nothing, only the first reflection is left.
  Conductor::Setting dark{.facets = {FacetShape::ggx, 0.6, 0.6}, .multiple = true};
  dark.eta = Rgb(1 + 1e-6);
  const Conductor all(dark), single({.facets = dark.facets, .eta = dark.eta});
  const Direction wi = direction_from_mu_phi(0.4, 0), wo = direction_from_mu_phi(0.5, 2.5);
  RandomStream stream(4, 0, StreamPurpose::test);
  std::vector<double> values(40000);
  const double expected = single.single(wi, wo).r;
  for (double& v : values) v = all.eval(wi, wo, stream).r / expected;
  EXPECT_GE(mean_p_value(values, 1), test_level());
}

TEST(Conductor, AllReflectionsOfWhiteFacetsLoseNothing) {
  for (const FacetShape shape : {FacetShape::ggx, FacetShape::beckmann})
    for (const double alpha : {1e-4, 0.1, 1.0})
      for (const double mu : {1.0, 0.3, 0.01}) {
        const Conductor c({.facets = {shape, alpha, alpha}, .multiple = true, .white = true});
        RandomStream stream(5, 0, StreamPurpose::test);
        for (int n = 0; n < 2000; ++n) {
          const auto s = c.sample(direction_from_mu_phi(mu, 0), stream);
          EXPECT_GT(s->wo.z, 0);
          EXPECT_EQ(s->weight.r, 1);
        }
      }
}

TEST(Conductor, EstimatesOfAllReflectionsAreWhatIsSampled) {
  const Conductor c = copper(FacetShape::ggx, 0.8, 0.8, Masking::beta, true);
  const Direction wi = direction_from_mu_phi(0.3, 0);
  RandomStream stream(6, 0, StreamPurpose::test);
  std::vector<double> sampled(60000), estimated(sampled.size());
  for (double& v : sampled) {
    const auto s = c.sample(wi, stream);
    v = s->wo.z > 0.5 ? s->weight.b : 0;
  }
  for (double& v : estimated) {  // uniform in mu over the same directions
    const double mu = 0.5 + 0.5 * stream.uniform(), phi = 2 * kPi * stream.uniform();
    v = c.eval(wi, direction_from_mu_phi(mu, phi), stream).b * mu * kPi;
  }
  double a = 0, b = 0, va = 0, vb = 0;
  const double n = static_cast<double>(sampled.size());
  for (const double v : sampled) a += v / n, va += v * v / n;
  for (const double v : estimated) b += v / n, vb += v * v / n;
  const double se = std::sqrt((va - a * a + vb - b * b) / n);
  EXPECT_LT(std::abs(a - b) / se, normal_quantile(test_level()));
}

}  // namespace
}  // namespace lamella::testing
