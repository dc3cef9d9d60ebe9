#include "analytic/layered/single_scattering_model.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>

#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "tests/statistics/statistics.h"

namespace lamella::testing {
namespace {

using boost::math::quadrature::gauss;

std::string layer(const std::string& medium, const std::string& depth) {
  return fmt::format("[[layer]]\nmedium = {}\nthickness = {}\n", medium, depth);
}

Stack stack_of(const std::string& text) { return parse_stack(text, "test", "test"); }

const std::string kMirror = "\"sggx\"\nroughness = 0.4\nalbedo = [0.9, 0.5, 0.2]";
const std::string kFiber = "\"sggx\"\nshape = \"fiber\"\nroughness = 0.3\naxis = [1, 0.2, 0.3]";
const std::string kOneSided = "\"vmf_flake\"\nroughness = 0.5\nflake = \"mirror\"\nf0 = 0.2";
const std::string kForward = "\"henyey_greenstein\"\ng = 0.7\nalbedo = 0.8";
const std::string kSpheres = "\"lambert_sphere\"\nalbedo = 0.6";
const std::string kSubstrate = "[substrate]\nalbedo = [0.3, 0.2, 0.1]\n";

std::vector<Stack> slabs() {
  return {stack_of(layer(kMirror, "1.3")), stack_of(layer(kOneSided, "0.8")),
          stack_of(layer(kForward, "5")),
          stack_of(layer(kOneSided, "0.7") + layer(kFiber, "0.4") + layer(kForward, "1.1")),
          stack_of(layer(kSpheres, "0.3") + layer(kMirror, "2") + layer(kOneSided, "0.2"))};
}

std::vector<Stack> all_stacks() {
  std::vector<Stack> list = slabs();
  list.push_back(stack_of(layer(kFiber, "inf")));
  list.push_back(stack_of(layer(kOneSided, "0.5") + layer(kForward, "inf")));
  list.push_back(stack_of(layer(kOneSided, "0.5") + layer(kMirror, "0.5") + kSubstrate));
  return list;
}

const std::vector<Direction>& upper() {
  static const std::vector<Direction> list{
      direction_from_mu_phi(1, 0), direction_from_mu_phi(0.6, 0.4), direction_from_mu_phi(0.3, 2.8),
      direction_from_mu_phi(0.02, 4)};
  return list;
}

/// The definition, integrated: light along w_i reaches the depth z in [-T, 0], is scattered there,
/// and leaves along w_o. Optical depths are summed over the layers crossed.
class ByQuadrature {
 public:
  explicit ByQuadrature(const Stack& stack) : stack_(stack) {
    double top = 0;
    for (const Layer& l : stack.layers) {
      tops_.push_back(top);
      top -= std::isinf(l.depth()) ? 1e3 : l.depth();
    }
    tops_.push_back(top);
  }

  [[nodiscard]] Rgb operator()(Direction wi, Direction wo) const {
    Rgb f;
    const double bottom = tops_.back();
    for (std::size_t k = 0; k < stack_.layers.size(); ++k) {
      const Layer& l = stack_.layers[k];
      const auto integrand = [&](double z) {
        return std::exp(-optical_depth(wi, wi, z) - optical_depth(-wo, wo, z));
      };
      // Panels that grow away from both faces, as fast as the integrand may fall.
      const double middle = (tops_[k] + tops_[k + 1]) / 2, half = tops_[k] - middle;
      double depth = 0, inner = half;
      for (int panel = 0; panel < 24; ++panel) {
        const double outer = panel == 23 ? 0 : inner / 2;
        depth += gauss<double, 20>::integrate(integrand, tops_[k] - inner, tops_[k] - outer);
        depth +=
            gauss<double, 20>::integrate(integrand, tops_[k + 1] + outer, tops_[k + 1] + inner);
        inner = outer;
      }
      const PhaseValue p = phase(l.medium, wi, wo);
      f += depth * sigma(l.medium, wi) * p.density / std::abs(wi.z * wo.z) *
           (l.albedo * schlick(l.f0, p.schlick));
    }
    if (stack_.substrate && wi.z > 0 && wo.z > 0)
      f += std::exp(-optical_depth(wi, wi, bottom) - optical_depth(-wo, wo, bottom)) / kPi *
           stack_.substrate->albedo;
    return f;
  }

 private:
  /// From z to the outside along `way`, through the area that faces `facing`.
  [[nodiscard]] double optical_depth(Direction facing, Direction way, double z) const {
    double sum = 0;
    for (std::size_t k = 0; k < stack_.layers.size(); ++k) {
      const double crossed = way.z > 0 ? std::max(0.0, tops_[k] - std::max(z, tops_[k + 1]))
                                       : std::max(0.0, std::min(z, tops_[k]) - tops_[k + 1]);
      sum += crossed * sigma(stack_.layers[k].medium, facing) / std::abs(way.z);
    }
    return sum;
  }

  const Stack& stack_;
  std::vector<double> tops_;
};

Rgb total(const Stack& stack, Direction wi, Direction wo) {
  const SingleScattering f = single_scattering(stack, wi, wo);
  return f.layers + f.substrate;
}

void expect_equal(Rgb a, Rgb b, double tolerance, const std::string& where) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance * std::abs(b[c])) << where << c;
}

TEST(SingleScattering, MatchesQuadratureOverDepthFromBothSidesInReflectionAndTransmission) {
  for (const Stack& stack : all_stacks()) {
    const ByQuadrature reference(stack);
    for (const Direction& wi : upper())
      for (const Direction& wo : upper()) {
        expect_equal(total(stack, wi, wo), reference(wi, wo), 1e-11, "R from above ");
        if (!stack.is_open_below()) {
          EXPECT_EQ(total(stack, wi, -wo), Rgb());
          continue;
        }
        expect_equal(total(stack, wi, -wo), reference(wi, -wo), 1e-11, "T from above ");
        expect_equal(total(stack, -wi, wo), reference(-wi, wo), 1e-11, "T from below ");
        expect_equal(total(stack, -wi, -wo), reference(-wi, -wo), 1e-11, "R from below ");
      }
  }
}

TEST(SingleScattering, ReflectionIsReciprocal) {
  for (const Stack& stack : all_stacks())
    for (const Direction& wi : upper())
      for (const Direction& wo : upper()) {
        expect_equal(total(stack, wi, wo), total(stack, wo, wi), 1e-12, "above ");
        if (stack.is_open_below())
          expect_equal(total(stack, -wi, -wo), total(stack, -wo, -wi), 1e-12, "below ");
      }
}

TEST(SingleScattering, TransmissionObeysTheLawOfOneSidedLayers) {
  for (const Stack& stack : slabs())
    for (const Direction& wi : upper())
      for (const Direction& wo : upper())
        expect_equal(total(stack, wi, -wo),
                     std::exp(-stack.one_sidedness()) * total(stack, -wo, wi), 1e-12, "T ");
}

TEST(SingleScattering, AThinLayerScattersByItsDepth) {
  for (const std::string& medium : {kMirror, kOneSided, kForward})
    for (const double side : {1.0, -1.0}) {
      const Stack thin = stack_of(layer(medium, "1e-9"));
      const Direction wi = upper()[1], wo = side * upper()[2];
      const Layer& l = thin.layers[0];
      const PhaseValue p = phase(l.medium, wi, wo);
      const Rgb expected = 1e-9 * sigma(l.medium, wi) * p.density / std::abs(wi.z * wo.z) *
                           (l.albedo * schlick(l.f0, p.schlick));
      // First order in the optical depth, which is below 1e-8.
      expect_equal(total(thin, wi, wo), expected, 1e-8, "thin ");
      EXPECT_EQ(total(stack_of(layer(medium, "0")), wi, wo), Rgb());
      EXPECT_EQ(total(stack_of(layer(medium, "1\ndensity = 0")), wi, wo), Rgb());
    }
}

TEST(SingleScattering, AThickLayerReflectsLikeAHalfSpaceAndPassesNothing) {
  for (const std::string& medium : {kMirror, kOneSided, kForward}) {
    const Stack thick = stack_of(layer(medium, "1e9")), half = stack_of(layer(medium, "inf"));
    for (const Direction& wi : upper())
      for (const Direction& wo : upper()) {
        expect_equal(total(thick, wi, wo), total(half, wi, wo), 1e-14, "R ");
        EXPECT_EQ(total(thick, wi, -wo), Rgb());
      }
  }
}

TEST(SingleScattering, EqualRatesInTransmissionAreTheirOwnLimit) {
  const Stack slab = stack_of(layer("\"henyey_greenstein\"", "2"));
  const Direction wi = direction_from_mu_phi(0.5, 0), wo = direction_from_mu_phi(-0.5, 1);
  // T exp(-T / mu) p / mu^2
  EXPECT_NEAR(total(slab, wi, wo).r, 2 * std::exp(-4.0) / (4 * kPi) / 0.25, 1e-16);
  for (const double step : {1e-15, 1e-12, 1e-9, 1e-6}) {
    const Direction near = direction_from_mu_phi(-0.5 - step, 1);
    // Derivative of the logarithm in mu_o: below 10 here.
    EXPECT_NEAR(total(slab, wi, near).r / total(slab, wi, wo).r, 1, 10 * step + 1e-15) << step;
  }
}

TEST(SingleScattering, OppositeDirectionsAreTheForwardLimit) {
  for (const Stack& stack : slabs())
    for (const Direction& wi : upper()) {
      const Rgb f = total(stack, wi, -wi);
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(f[c]) && f[c] > 0);
    }
}

TEST(SingleScattering, GrazingLimitIsReachedFromAbove) {
  for (const Stack& stack : all_stacks())
    for (const double side : {1.0, -1.0}) {
      if (side < 0 && !stack.is_open_below()) continue;
      const Direction w{0.6, 0, side * 0.8};
      for (const double mu : {1e-7, 1e-12}) {
        const Direction grazing{std::cos(0.3), std::sin(0.3), 0};
        const Direction near = direction_from_mu_phi(mu, 0.3);
        // The next order in mu: its optical depth's inverse, below 100 here.
        expect_equal(total(stack, grazing, w), total(stack, near, w), 1e3 * mu + 1e-13, "light ");
        expect_equal(total(stack, w, grazing), total(stack, w, near), 1e3 * mu + 1e-13, "view ");
      }
    }
}

Stack repeated(const Layer& one, double depth, int times) {
  Stack stack;
  stack.layers.assign(times, one);
  for (Layer& l : stack.layers) l.thickness = depth / times;
  return stack;
}

TEST(SingleScattering, ALayerEqualsItsPartsInTwoTenOrAThousandPieces) {
  for (const std::string& medium : {kMirror, kOneSided, kForward}) {
    const Layer one = stack_of(layer(medium, "1")).layers[0];
    for (const double depth : {1e-6, 0.7, 30.0}) {
      const Stack whole = repeated(one, depth, 1);
      for (const int pieces : {2, 10, 1000}) {
        const Stack split = repeated(one, depth, pieces);
        for (const Direction& wi : {upper()[1], upper()[3], Direction{1, 0, 0}})
          for (const Direction& wo : {upper()[0], upper()[2]}) {
            // Rounding of the sums of optical depths up to 1500, where the light is not yet gone
            const std::string where = fmt::format("{} {} {} ", medium, depth, pieces);
            if (total(whole, wi, wo).max() > 1e-250)
              expect_equal(total(split, wi, wo), total(whole, wi, wo), 1e-11, where + "R ");
            if (total(whole, wi, -wo).max() > 1e-250)
              expect_equal(total(split, wi, -wo), total(whole, wi, -wo), 1e-11, where + "T ");
            if (total(whole, -wi, wo).max() > 1e-250)
              expect_equal(total(split, -wi, wo), total(whole, -wi, wo), 1e-11, where + "TB ");
          }
      }
    }
  }
}

// Layers that are thick for one of the two directions only must not swallow the precision of the
// optical depth of the others: one-sided flakes pass light from behind.
TEST(SingleScattering, TransmissionThroughGrazingThickLayersKeepsTheLastLayer) {
  const Stack stack = stack_of(layer(kMirror, "0.3") + layer(kForward, "0.7") +
                               layer(kMirror, "1.1") + layer(kOneSided, "0.9"));
  for (const Direction& wi : {upper()[0], upper()[1]})
    for (const double mu : {0.0, 1e-7, 1e-14}) {
      const Direction wo = direction_from_mu_phi(mu, 0.3);
      // Only the last layer is seen; before it the light crosses the others.
      const Stack last = stack_of(layer(kMirror, "0.3"));
      Stack before = stack;
      before.layers.erase(before.layers.begin());
      expect_equal(total(stack, -wi, wo), before.uncollided(-wi) * total(last, -wi, wo), 1e-12,
                   fmt::format("mu = {} ", mu));
    }
}

TEST(SingleScattering, BuiltInStacksAreFiniteAndNotNegative) {
  for (const BuiltinStack& builtin : builtin_stacks()) {
    const Stack stack = load_stack(builtin.name);
    if (stack.has_grid() || stack.grains()) {
      EXPECT_THROW((void)total(stack, upper()[0], upper()[1]), std::invalid_argument);
      continue;
    }
    for (const Direction& wi : upper()) {
      const Rgb f = total(stack, wi, upper()[1]);
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(f[c]) && f[c] >= 0) << builtin.name;
    }
  }
}

TEST(SingleScattering, SamplesFollowThePdfWhichIntegratesToOne) {
  for (const Stack& stack : all_stacks()) {
    const SingleScatteringModel model(stack);
    std::vector<Direction> views = upper();
    if (stack.is_open_below()) views.push_back(-upper()[1]);
    for (const Direction& wo : views) {
      const auto density = [&](Direction wi) { return model.pdf(wi, wo); };
      const auto sample = [&](RandomStream& stream) {
        const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
        return model.sample(wo, u1, u2, u3).value();
      };
      EXPECT_GE(
          sampler_p_value(stack.layers[0].medium_name, Direction{0, 0, 1}, sample, density, 100000),
          test_level());
      // Kinks of the one-sided and the fiber's lobe bound the rule's own error.
      EXPECT_NEAR(integrate_sphere(density, Direction{0, 0, 1}, 1e-6), 1, 1e-4);
    }
  }
}

}  // namespace
}  // namespace lamella::testing
