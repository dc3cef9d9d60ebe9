// Visible normals of narrow vMF flakes without tables: the inversions against the distributions,
// the normals against their density, walks on lanes against scalar walks and against double.
#include "volume/lanes/lane_narrow_normals.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "phase/medium/vmf.h"
#include "tests/volume/lanes/lane_agreement.h"
#include "volume/lanes/lane_media.h"
#include "volume/lanes/lane_replay.h"
#include "volume/lanes/lane_run.h"
#include "volume/lanes/lane_setting.h"

namespace lamella {
namespace {

using testing::lane_isas;
using testing::layer;
using testing::stack_from;

// Words in equal steps, their middles.
std::uint32_t word_at(int k, int count) {
  return static_cast<std::uint32_t>((k + 0.5) / count * 0x1p32);
}

TEST(NarrowNormals, TheTiltInvertsItsDistribution) {
  for (const double kappa : {kLeastNarrow, 100.0, 800.0, 8e4, 2e6}) {
    const TiltSeries<double> tilt = tilt_series(kappa);
    constexpr int kSteps = 100000;
    for (int k = 0; k < kSteps; ++k) {
      const std::uint32_t word = word_at(k, kSteps);
      const Direction m = narrow_normal<double>(tilt, {0, 0, 1}, word, 0u);
      const double t = (m.x * m.x + m.y * m.y) / (1 + m.z);
      EXPECT_NEAR(std::exp(-kappa * t) * (1 - kappa * t / (kappa - 1)), fine_uniform_of(word),
                  kNarrowError)
          << kappa;
    }
  }
}

// The largest error of phi's cumulative probability is that of the mean over all tilts, as the
// density of both numbers has it.
TEST(NarrowNormals, TheAzimuthInvertsItsDistribution) {
  for (const double kappa : {kLeastNarrow, 100.0, 800.0, 8e4, 2e6})
    for (const double beyond : {0.0, 0.1, 0.5, 1.0}) {
      const double least = facing_cosine(kappa), u = least + beyond * (1 - least);
      const double s = std::sqrt((1 - u) * (1 + u)), plane = 0.7;
      const Direction w{s * std::cos(plane), s * std::sin(plane), u};
      constexpr int kTilts = 4000, kAzimuths = 64;
      for (int j = 0; j < kAzimuths; ++j) {
        const std::uint32_t azimuth = word_at(j, kAzimuths);
        double error = 0;
        for (int k = 0; k < kTilts; ++k) {
          const Direction m =
              narrow_normal<double>(tilt_series(kappa), w, word_at(k, kTilts), azimuth);
          const double sine = std::hypot(m.x, m.y), e = sine / m.z * s / u;
          const double phi = std::atan2(m.y, m.x) - plane;
          const double turns =
              (phi + e * std::sin(phi) + plane) / (2 * kPi) - signed_uniform_of(azimuth) / 2;
          error += std::abs(turns - std::round(turns)) / kTilts;
          EXPECT_NEAR(dot(m, m), 1, 1e-6);
        }
        EXPECT_LT(error, kNarrowError) << kappa << ' ' << u;
      }
    }
}

TEST(NarrowNormals, AllThatAreDrawnFaceTheLight) {
  for (const double kappa : {kLeastNarrow, 100.0, 800.0, 8e4, 2e6}) {
    const double u = facing_cosine(kappa), s = std::sqrt((1 - u) * (1 + u));
    const Direction m = narrow_normal<double>(tilt_series(kappa), {s, 0, u}, 0u, 0u);
    EXPECT_LT(std::hypot(m.x, m.y) / m.z * s / u, 0.9) << kappa;
    // What the density ignores: normals that turn their backs.
    EXPECT_LT(vmf_sigma(-u, std::sqrt(2 / kappa)), 1e-12) << kappa;
  }
}

constexpr double kAlphas[] = {0.001, 0.005, 0.05, 0.2};

std::string narrow_flakes_of(double alpha, Direction axis) {
  return fmt::format("medium = 'vmf_flake'\nalpha = {}\naxis = [{}, {}, {}]\nthickness = 1\n",
                     alpha, axis.x, axis.y, axis.z);
}
// Light whose cosine with the axis is u, in an oblique plane.
Direction light_at(Direction axis, double u) {
  const double s = std::sqrt(std::max(0.0, (1 - u) * (1 + u)));
  return frame_around(axis).to_world({s * std::cos(0.4), s * std::sin(0.4), u});
}

TEST(NarrowNormals, FollowTheVisibleNormalsDensityOnBothSidesOfTheirDomain) {
  const Direction axis = normalized(Direction{0.5, -0.3, 0.8});
  for (const double alpha : kAlphas) {
    const double kappa = vmf_concentration(alpha), least = facing_cosine(kappa);
    const Stack stack = stack_from(layer(narrow_flakes_of(alpha, axis)));
    const LaneSetting<double> setting(stack, make_plan(stack), axis, 1);
    ASSERT_TRUE(setting.walk.narrow);
    const NarrowVmfLambertOnLanes<double> flakes(OneLayer<double>{setting.layers, 0});
    for (const double u : {1.0, (1 + least) / 2, least * 1.001, least * 0.999, least / 4}) {
      const Direction w = light_at(axis, u);
      const double sigma = vmf_sigma(u, alpha);
      EXPECT_NEAR(flakes.sigma(w) / sigma, 1, 1e-5) << alpha << ' ' << u;
      const double p_value = testing::sampler_p_value(
          fmt::format("alpha {} from {}", alpha, u), {.axis = axis, .width = alpha},
          [&](RandomStream& stream) {
            const std::uint32_t words[] = {stream.bits(), stream.bits()};
            return flakes.normal(w, u, flakes.row_from_behind(u), words);
          },
          [&](Direction m) {
            return std::max(dot(w, m), 0.0) * vmf_density(kappa, std::min(dot(m, axis), 1.0)) /
                   sigma;
          },
          50000);
      EXPECT_GE(p_value, testing::test_level());
    }
  }
}

TEST(NarrowNormals, SigmaGoesOnWhereTheTablesEnd) {
  const Direction axis{0, 0.6, 0.8};
  for (const double alpha : kAlphas) {
    const Stack stack = stack_from(layer(narrow_flakes_of(alpha, axis)));
    const LaneSetting<double> setting(stack, make_plan(stack), axis, 1);
    const NarrowVmfOnLanes<double> narrow(OneLayer<double>{setting.layers, 0});
    const VmfOnLanes<double> tables(OneLayer<double>{setting.layers, 0});
    for (int k = -1000; k <= 1000; ++k) {
      const Direction w = light_at(axis, k / 1000.0);
      EXPECT_NEAR(narrow.inverse_area(w) / tables.inverse_area(w), 1, 1e-9) << alpha << ' ' << k;
    }
  }
}

class NarrowFlakes : public ::testing::TestWithParam<Isa> {};

Plan plan_for(const Stack& stack, Isa isa, WalkLimits limits = {}) {
  Plan plan = make_plan(stack, limits);
  plan.isa = isa;
  return plan;
}

// Tilted flakes, light from within the domain and from both sides of its edge.
TEST_P(NarrowFlakes, WalkAsScalarWalksDo) {
  const Direction axis = normalized(Direction{0.3, 0.2, 0.9});
  for (const double alpha : kAlphas)
    for (const char* kind : {"mirror", "lambert"}) {
      const Stack stack =
          stack_from(layer(narrow_flakes_of(alpha, axis) + "albedo = 0.9\nflake = '" + kind + "'"));
      const double least = facing_cosine(vmf_concentration(alpha));
      for (const double u : {0.95, least * 1.01, least * 0.99}) {
        const Direction wi = light_at(axis, u);
        const auto walked = [&](Isa isa, std::uint64_t seed) {
          Simulation s(stack, plan_for(stack, isa), wi, Estimator::analog, CellGrid{3, 4, false},
                       seed);
          s.advance(testing::soaked(40000));
          EXPECT_EQ(s.isa(), isa);
          return reduce(s);
        };
        testing::expect_same_lobes(walked(GetParam(), 1), walked(Isa::scalar, 2),
                                   fmt::format("alpha {} {} u {}", alpha, kind, u));
      }
    }
}

// Layers of both widths and kinds, by turns and each lane in its own; under interfaces, too.
TEST_P(NarrowFlakes, WalkThroughLayersAsScalarWalksDo) {
  const Direction axis = normalized(Direction{0.3, 0.2, 0.9});
  const auto flakes = [&](double alpha, const char* kind) {
    return layer(narrow_flakes_of(alpha, axis) + "albedo = 0.9\nflake = '" + kind + "'");
  };
  const std::string coat = layer("interface = 'ggx'\nroughness = 0.2\nior = 1.4");
  for (const std::string& toml :
       {flakes(0.01, "mirror") + flakes(0.5, "lambert") + "[substrate]\nalbedo = 0.7\n",
        flakes(0.2, "lambert") + layer("medium = 'sggx'\nroughness = 0.3\nthickness = 1"),
        coat + flakes(0.05, "lambert"), coat + flakes(0.01, "mirror")})
    for (const LayerTurns turns : {LayerTurns::always, LayerTurns::never}) {
      const Stack stack = stack_from(toml);
      const auto walked = [&](Isa isa, std::uint64_t seed) {
        Plan plan = plan_for(stack, isa);
        plan.layer_turns = turns;
        Simulation s(stack, plan, direction_from_degrees(30, 50), Estimator::analog,
                     CellGrid{3, 4, false}, seed);
        s.advance(testing::soaked(40000));
        EXPECT_EQ(s.isa(), isa);
        return reduce(s);
      };
      testing::expect_same_lobes(walked(GetParam(), 1), walked(Isa::scalar, 2), toml);
    }
}

TEST_P(NarrowFlakes, SendLightAsScalarWalksDo) {
  const Direction axis = normalized(Direction{0.3, 0.2, 0.9});
  for (const double alpha : {0.05, 0.2})
    for (const char* kind : {"mirror", "lambert"}) {
      const Stack stack =
          stack_from(layer(narrow_flakes_of(alpha, axis) + "albedo = 0.9\nflake = '" + kind + "'"));
      const Direction wi = light_at(axis, 0.97);
      // Near the mirror's image, in the lobe of both kinds.
      const Direction image = 2 * dot(wi, axis) * axis - wi;
      const std::vector<Direction> points{image, normalized(image + Direction{0.05, 0.02, 0})};
      const auto estimates = [&](Isa isa, std::uint64_t seed) {
        Simulation s(stack, plan_for(stack, isa), wi, points, seed);
        s.advance(testing::soaked(20000));
        return std::array{testing::point_estimate(s, kTallyOrders, 0, 2),
                          testing::point_estimate(s, kTallyOrders, 1, 2)};
      };
      const auto lanes = estimates(GetParam(), 1), scalar = estimates(Isa::scalar, 2);
      for (int j = 0; j < 2; ++j)
        EXPECT_LT(std::abs(testing::z_between(lanes[j], scalar[j])), testing::allowed_z())
            << alpha << ' ' << kind << ' ' << lanes[j].value << ' ' << scalar[j].value;
    }
}

// The same numbers in double, in the domain and at its edge, where lanes of a set differ.
TEST_P(NarrowFlakes, WalkInFloatAsInDouble) {
  const Direction axis = normalized(Direction{0.3, 0.2, 0.9});
  for (const double alpha : kAlphas) {
    const Stack stack = stack_from(layer(narrow_flakes_of(alpha, axis) + "albedo = 0.9"));
    const double least = facing_cosine(vmf_concentration(alpha));
    for (const double u : {0.99, least * 1.01, least * 0.99, 0.0}) {
      const Plan plan = plan_for(stack, GetParam(), {.max_order = 300});
      constexpr std::uint64_t kWalks = 20000;
      Simulation lanes(stack, plan, light_at(axis, u), Estimator::analog, CellGrid{2, 4, false}, 3);
      lanes.advance(kWalks);
      const auto exact =
          replay_in_double(stack, plan, lanes.incident(), 3, kBatches, kWalks, lanes.targets());
      double sum = 0, difference = 0;
      for (int k = 0; k < kBatches; ++k)
        for (std::size_t j = 0; j < exact[k].f.size(); ++j) {
          sum += exact[k].f[j];
          difference += std::abs(exact[k].f[j] - lanes.batches()[k].f[j]);
        }
      // A walk near the edge of a cell takes another turn now and then, two terms of the sum: of
      // these cases one does, and three more may.
      EXPECT_LT(difference, 4e-4 * sum) << alpha << ' ' << u;
    }
  }
}

// Sums are those of walks one by one, whatever walks share a set: Lambertian flakes send light
// along the flakes, where some lanes take tables and others do not.
TEST_P(NarrowFlakes, WalksDoNotDependOnTheirNeighbours) {
  const std::string flakes = narrow_flakes_of(0.1, normalized(Direction{0.3, 0.2, 0.9}));
  for (const std::string& toml : {layer(flakes + "albedo = 1"),
                                  layer(flakes + "albedo = 1") + layer(flakes + "albedo = 1")}) {
    const Stack stack = stack_from(toml);
    const auto sums = [&](std::uint64_t step) {
      Simulation s(stack, plan_for(stack, GetParam()), direction_from_degrees(50, 20),
                   Estimator::analog, CellGrid{4, 8, false}, 5);
      while (s.walks() < 5120) s.advance(s.walks() + step);
      std::vector<double> all;
      for (const BatchTally& b : s.batches()) all.insert(all.end(), b.f.begin(), b.f.end());
      return all;
    };
    EXPECT_EQ(sums(5120), sums(1280));
  }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, NarrowFlakes, ::testing::ValuesIn(lane_isas()),
                         [](const auto& isa) { return to_text(isa.param); });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(NarrowFlakes);

}  // namespace
}  // namespace lamella
