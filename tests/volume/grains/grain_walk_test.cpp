#include "volume/grains/grain_walk.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "tests/volume/run/stacks.h"

namespace lamella::testing {
namespace {

const CellGrid kGrid{4, 8, false};

Stack bed(double packing, const std::string& keys = "", const std::string& below = "") {
  return stack_from(layer("medium = 'sphere_bed'\nradius = 0.02\npacking = " +
                          std::to_string(packing) + "\nthickness = 0.4\ntile = 0.5\n" + keys) +
                    below);
}
Stack micrograins(const std::string& keys, const std::string& below = "") {
  return stack_from(layer("medium = 'micrograins'\ntau0 = 0.7\nbeta = 0.6\ntile = 16\n" + keys) +
                    below);
}

RunResult simulate(const Stack& stack, Direction wi, Estimator estimator, std::uint64_t walks,
                   Sampling sampling = Sampling::random) {
  Simulation simulation(stack, make_plan(stack, {.sampling = sampling}), wi, estimator, kGrid, 3);
  simulation.advance(walks);
  return reduce(simulation);
}

TEST(GrainWalk, WhiteGrainsLoseNothingAndEveryLedgerSumsToOne) {
  const std::string white_plane = "[substrate]\nalbedo = 1\n";
  for (const Stack& stack :
       {bed(0.3), bed(0.3, "", white_plane), bed(2), bed(0.3, "surface = 'mirror'\n"),
        stack_from(layer("medium = 'packed_sphere_bed'\nradius = 0.02\npacking = 0.3\n"
                         "thickness = 0.2\ntile = 0.3")),
        micrograins("", white_plane), micrograins("surface = 'dielectric'\n", white_plane),
        micrograins("surface = 'conductor'\n", white_plane)})
    for (const double theta : {0.0, 80.0}) {
      const Direction wi = direction_from_degrees(theta, 0);
      const RunResult run = simulate(stack, wi, Estimator::next_event, 2048);
      EXPECT_NEAR(ledger_sum(run, 0), 1, 1e-12);
      EXPECT_NEAR(run.absorbed[0].value, 0, 1e-12) << to_toml(stack);
      // Deep in a dense white bed some light goes on beyond the limit of orders.
      EXPECT_LT(run.unresolved[0].value, 0.01);
      EXPECT_EQ(run.holes, 0U);
      // The estimators' lobes hold the energy that the ledger counted.
      for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
        const RunResult other =
            estimator == Estimator::analog ? simulate(stack, wi, estimator, 2048) : run;
        for (const bool reflected : {true, false}) {
          const SideResult& side = reflected ? other.reflected : other.transmitted;
          if (side.lobes[0].value.empty()) continue;
          Estimate lobe;
          for (std::size_t k = 0; k < side.lobes[Order::all].value.size(); ++k) {
            lobe.value += other.grid.projected_solid_angle() * side.lobes[Order::all].value[k];
            lobe.standard_error +=  // errors of cells are correlated: their sum bounds it
                other.grid.projected_solid_angle() * side.lobes[Order::all].standard_error[k];
          }
          EXPECT_LT(
              std::abs(lobe.value - side.total[0].value),
              estimator == Estimator::analog ? 1e-9 : allowed_z() * lobe.standard_error + 1e-12)
              << to_toml(stack) << theta << reflected;
        }
      }
    }
}

TEST(GrainWalk, AnalogAndNextEventAgreeOrderByOrderWithAndWithoutLattices) {
  for (const Stack& stack :
       {bed(0.5, "albedo = 0.8\n", "[substrate]\nalbedo = 0.6\n"),
        micrograins("albedo = 0.8\nsurface = 'dielectric'\n", "[substrate]\nalbedo = 0.3\n")}) {
    const Direction wi = direction_from_degrees(50, 20);
    const RunResult analog = simulate(stack, wi, Estimator::analog, 65536);
    for (const Sampling sampling : {Sampling::random, Sampling::rqmc}) {
      const RunResult next_event = simulate(stack, wi, Estimator::next_event, 8192, sampling);
      EXPECT_EQ(next_event.sampling, sampling);
      for (int o = 0; o <= kTallyOrders; ++o) {
        const LobeEstimate &a = analog.reflected.lobes[o], &b = next_event.reflected.lobes[o];
        for (std::size_t k = 0; k < a.value.size(); ++k)
          EXPECT_LT(std::abs(a.value[k] - b.value[k]),
                    allowed_z() * std::hypot(a.standard_error[k], b.standard_error[k]))
              << to_toml(stack) << to_text(sampling) << o << " " << k;
      }
    }
  }
}

TEST(GrainWalk, ADiluteBedPassesLightByBeersLaw) {
  // Poisson spheres: exp(-n pi r^2 T / mu), n pi r^2 = 3 packing / (4 r), whatever their overlap.
  for (const double packing : {0.02, 0.3})
    for (const double theta : {0.0, 60.0}) {
      const Direction wi = direction_from_degrees(theta, 0);
      const RunResult run = simulate(bed(packing), wi, Estimator::analog, 32768);
      const double tau = 3 * packing / (4 * 0.02) * 0.4 / wi.z;
      EXPECT_NEAR(run.uncollided[0].value, std::exp(-tau),
                  allowed_z() * run.uncollided[0].standard_error)
          << packing << " " << theta;
    }
}

TEST(GrainWalk, ADiluteBedIsTheLambertSphereMedium) {
  // At a volume fraction of 0.5 % what the medium leaves out is below the noise of this test.
  const double packing = 0.005, radius = 0.02, thickness = 4;
  const Stack grains = stack_from(
      layer("medium = 'sphere_bed'\nradius = 0.02\npacking = 0.005\nthickness = 4\nalbedo = 0.9\n"
            "tile = 2"));
  const Stack medium =
      stack_from(layer("medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = 4\n"
                       "density = " +
                       std::to_string(3 * packing / (4 * radius))));
  ASSERT_EQ(medium.layers[0].thickness, thickness);
  const Direction wi = direction_from_degrees(60, 0);
  const RunResult a = simulate(grains, wi, Estimator::analog, 65536);
  const RunResult b = simulate(medium, wi, Estimator::analog, 1 << 20);
  for (int o = 0; o < kTallyOrders; ++o) {
    EXPECT_LT(std::abs(z_between(a.reflected.orders[o][0], b.reflected.orders[o][0])), allowed_z())
        << "order " << o + 1;
    EXPECT_LT(std::abs(z_between(a.transmitted.orders[o][0], b.transmitted.orders[o][0])),
              allowed_z())
        << "order " << o + 1;
  }
}

TEST(GrainWalk, IsReciprocal) {
  for (const Stack& stack : {bed(1, "albedo = 0.8\n", "[substrate]\nalbedo = 0.6\n"),
                             micrograins("albedo = 0.8\n", "[substrate]\nalbedo = 0.3\n")}) {
    const Direction a = direction_from_degrees(70, 0), b = direction_from_degrees(20, 100);
    Simulation forth(stack, make_plan(stack), a, {b}, 1), back(stack, make_plan(stack), b, {a}, 2);
    forth.advance(32768);
    back.advance(32768);
    for (int o = 0; o <= kTallyOrders; ++o)
      EXPECT_LT(std::abs(z_between(point_estimate(forth, o, 0, 1), point_estimate(back, o, 0, 1))),
                allowed_z())
          << o;
  }
}

TEST(GrainWalk, ColouredWeightsCarryTheGreyAnswersOfTheirChannels) {
  const Stack color =
      micrograins("albedo = [0.9, 0.5, 0]\n", "[substrate]\nalbedo = [0.2, 0.4, 1]\n");
  const RunResult rgb = simulate(color, direction_from_degrees(40, 0), Estimator::analog, 32768);
  const RunResult grey = simulate(micrograins("albedo = 0.5\n", "[substrate]\nalbedo = 0.4\n"),
                                  direction_from_degrees(40, 0), Estimator::analog, 32768);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(ledger_sum(rgb, c), 1, 1e-12);
  for (int o = 0; o < kTallyOrders; ++o) {
    Estimate mine = rgb.reflected.orders[o][1];
    EXPECT_LT(std::abs(z_between(mine, grey.reflected.orders[o][0])), allowed_z()) << o;
  }
}

// f = s (mu_i mu_o)^k / pi, sampled uniformly: as little like the cosine law as a sampler may be.
struct PowerLaw : SurfaceLaw {
  PowerLaw(double s, double k) : scale(s), power(k) {}
  [[nodiscard]] Rgb eval(Direction wi, Direction wo, RandomStream&) const override {
    return value(wi, wo);
  }
  [[nodiscard]] Rgb value(Direction wi, Direction wo) const {
    return Rgb(scale * std::pow(wi.z * wo.z, power) / kPi);
  }
  [[nodiscard]] std::optional<Sample> sample(Direction wi, RandomStream& stream) const override {
    const double u1 = stream.uniform(), u2 = stream.uniform();
    const Direction wo = direction_from_mu_phi(u1, 2 * kPi * u2);
    return Sample{wo, (2 * kPi * wo.z) * value(wi, wo)};
  }
  double scale, power;
};

Stack over_law(const Stack& grains, double scale, double power) {
  Stack stack = grains;
  stack.substrate = Substrate{.model = "power", .law = std::make_shared<PowerLaw>(scale, power)};
  return stack;
}

TEST(GrainWalk, ALambertianLawGivesWhatTheLambertianPlaneGives) {
  const Stack plane = micrograins("", "[substrate]\nalbedo = 0.7\n");
  const Direction wi = direction_from_degrees(50, 0);
  const RunResult one = simulate(plane, wi, Estimator::next_event, 40960);
  const RunResult other = simulate(over_law(plane, 0.7, 0), wi, Estimator::next_event, 40960);
  for (int order = 0; order < kTallyOrders; ++order)
    EXPECT_LT(std::abs(z_between(one.reflected.orders[order][0], other.reflected.orders[order][0])),
              allowed_z())
        << order;
}

TEST(GrainWalk, ASurfaceWithoutGrainsIsItsLaw) {
  const double scale = 1.2, power = 0.5;
  const Stack bare =
      over_law(stack_from(layer("medium = 'micrograins'\ntau0 = 0\nbeta = 0.6\n")), scale, power);
  const double mu = 0.6;
  const Direction wi = direction_from_mu_phi(mu, 0);
  const double albedo = 2 * scale * std::pow(mu, power) / (power + 2);
  for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
    const RunResult run = simulate(bare, wi, estimator, 40960);
    const Estimate energy = run.reflected.orders[0][0];
    EXPECT_LT(std::abs(energy.value - albedo), allowed_z() * energy.standard_error);
    EXPECT_GT(energy.standard_error, 0);
    // The cells hold the same light.
    double cells = 0, error = 0;
    for (std::size_t k = 0; k < run.reflected.lobes[0].value.size(); ++k) {
      cells += run.grid.projected_solid_angle() * run.reflected.lobes[0].value[k];
      error += run.grid.projected_solid_angle() * run.reflected.lobes[0].standard_error[k];
    }
    EXPECT_LT(std::abs(cells - albedo), allowed_z() * error) << to_text(estimator);
  }
}

TEST(GrainWalk, BothEstimatorsAgreeOnGrainsOverALaw) {
  const Stack stack = over_law(micrograins(""), 1.2, 0.5);
  const Direction wi = direction_from_degrees(40, 0);
  const RunResult analog = simulate(stack, wi, Estimator::analog, 81920);
  const RunResult next_event = simulate(stack, wi, Estimator::next_event, 20480);
  const LobeEstimate &a = analog.reflected.lobes[Order::all],
                     &b = next_event.reflected.lobes[Order::all];
  for (std::size_t k = 0; k < a.value.size(); ++k)
    EXPECT_LT(
        std::abs(z_between({a.value[k], a.standard_error[k]}, {b.value[k], b.standard_error[k]})),
        allowed_z())
        << k;
}

TEST(GrainWalk, AModelWithoutItsLawIsADefect) {
  Stack stack = micrograins("");
  stack.substrate = Substrate{.model = "eon"};
  EXPECT_THROW(simulate(stack, {0, 0, 1}, Estimator::analog, 128), std::logic_error);
}

std::vector<double> sums_with_threads(int threads, const std::vector<std::uint64_t>& checkpoints,
                                      Sampling sampling) {
  const Stack stack = bed(0.5, "albedo = 0.8\n");
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
  tbb::task_arena arena(threads);
  return arena.execute([&] {
    Simulation simulation(stack, make_plan(stack, {.sampling = sampling}),
                          direction_from_degrees(60, 30), Estimator::analog, kGrid, 7);
    for (const std::uint64_t walks : checkpoints) simulation.advance(walks);
    std::vector<double> sums;
    for (const BatchTally& b : simulation.batches()) {
      sums.insert(sums.end(), b.f.begin(), b.f.end());
      sums.insert(sums.end(), b.energy.absorbed.begin(), b.energy.absorbed.end());
    }
    return sums;
  });
}

TEST(GrainWalk, IsBitIdenticalForAnyNumberOfThreadsAndAnyCheckpoints) {
  for (const Sampling sampling : {Sampling::random, Sampling::rqmc}) {
    const auto one = sums_with_threads(1, {20000}, sampling);
    EXPECT_EQ(one, sums_with_threads(3, {20000}, sampling));
    EXPECT_EQ(one, sums_with_threads(2, {1, 130, 9000, 20000}, sampling));
  }
}

TEST(GrainWalk, RefusesWhatItCannotDo) {
  const Stack stack = bed(0.5);
  const auto make = [&](const Stack& s, Direction wi) {
    return Simulation(s, make_plan(s), wi, Estimator::analog, kGrid, 1).walks();
  };
  EXPECT_THROW(make(stack, direction_from_degrees(90, 0)), std::invalid_argument);
  EXPECT_THROW(make(micrograins(""), direction_from_degrees(120, 0)), std::invalid_argument);
  EXPECT_EQ(make(stack, direction_from_degrees(120, 0)), 0U);
  const Stack mirrors = bed(0.5, "surface = 'mirror'\n");
  EXPECT_THROW(Simulation(mirrors, make_plan(mirrors), {0, 0, 1}, {{0, 0, 1}}, 1),
               std::invalid_argument);
}

}  // namespace
}  // namespace lamella::testing
