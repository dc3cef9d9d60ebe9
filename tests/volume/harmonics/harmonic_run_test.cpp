// Stacks without symmetry about the normal in spherical harmonics: against the solver of symmetric
// stacks, conservation, reciprocity, rotations, and walks.
#include "volume/harmonics/harmonic_run.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "tests/statistics/statistics.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/harmonics/harmonic_pairs.h"
#include "volume/harmonics/harmonic_scope.h"
#include "volume/harmonics/harmonic_solution.h"
#include "volume/run/simulation.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

std::string leaning(const std::string& medium, double x, double y, double z) {
  return fmt::format("{}\naxis = [{}, {}, {}]", medium, x, y, z);
}

// One direction at one resolution.
struct Solved {
  Stack stack;
  HarmonicTransport transport;
  HarmonicSolution solution;

  Solved(const std::string& toml, Direction wi, int degree, bool is_even = false)
      : stack(stack_of(toml)),
        transport(stack, 0,
                  {.degree = degree,
                   .depth_nodes = 8,
                   .finest = 1e-5,
                   .residual = 1e-12,
                   .is_even = is_even,
                   .isa = supported_isas().back()}),
        solution(transport, wi) {}
  [[nodiscard]] double all(Direction wo) const {
    const auto f = solution.f(wo);
    return f[0] + f[1] + f[2];
  }
};

// Where a plane mirrors stack and light, the cosines of the azimuth are enough: the rest is
// rounding of other sums, and of rays about the beam that lie elsewhere.
TEST(HarmonicSolution, OfEvenLightHasNoSines) {
  const std::string tilted = layer(leaning(vmf(0.6, "mirror"), 0.6, 0, -0.8), 0.9, 1);
  for (const std::string& toml :
       {layer(leaning(sggx(0.5, "mirror"), 1, 0, 0), 0.9, 1) + tilted,
        layer(henyey_greenstein(0.5), 0.8, 1) + tilted + lambert_ground(0.5)})
    for (const Direction wi : {direction_from_mu_phi(0.6, 0), direction_from_mu_phi(0.7, kPi),
                               direction_from_mu_phi(0.05, 0), Direction{0, 0, 1}}) {
      ASSERT_TRUE(is_even(stack_of(toml), std::span(&wi, 1)));
      constexpr int kDegree = 14;
      const Solved full(toml, wi, kDegree), even(toml, wi, kDegree, true);
      EXPECT_NEAR(even.solution.energies().absorbed, full.solution.energies().absorbed, 1e-8);
      for (int order = 0; order < 4; ++order)
        EXPECT_NEAR(even.solution.energies().up[order], full.solution.energies().up[order], 1e-8);
      for (const double mu : {0.9, 0.2, -0.6})
        for (const double phi : {0.3, 2.0, -1.0}) {
          const Direction wo = direction_from_mu_phi(mu, phi);
          EXPECT_NEAR(even.all(wo), full.all(wo), 1e-8) << toml << wi.z << " " << mu << " " << phi;
        }
    }
}

TEST(HarmonicSolution, IsEvenOnlyWhereAPlaneMirrorsStackAndLight) {
  const auto is_even_of = [](const std::string& toml, Direction wi) {
    return is_even(stack_of(toml), std::span(&wi, 1));
  };
  const std::string fibers = layer(leaning(sggx(0.5, "mirror"), 1, 0, 0), 0.9, 1);
  EXPECT_TRUE(is_even_of(fibers, direction_from_mu_phi(0.6, kPi)));
  EXPECT_FALSE(is_even_of(fibers, direction_from_mu_phi(0.6, 0.1)));
  const Direction in_plane = direction_from_mu_phi(0.6, 0);
  EXPECT_TRUE(is_even_of(layer(kIsotropic, 0.9, 1), in_plane));
  EXPECT_FALSE(is_even_of(layer(leaning(sggx(0.5, "mirror"), 0.6, 0.1, 0.8), 0.9, 1), in_plane));
  EXPECT_FALSE(is_even_of("[[layer]]\ninterface = \"smooth\"\nior = 1.5\n" + fibers, in_plane));
}

// Both methods solve what is symmetric; one-sided flakes, a ground, light from below and a half
// space are among it. The degrees leave less than the tolerance.
TEST(HarmonicSolution, IsThatOfTheSymmetricSolver) {
  struct Case {
    std::string toml;
    int degree;
    double tolerance;
  };
  for (const Case& c :
       {Case{layer(henyey_greenstein(0.5), 0.9, 1), 24, 1e-7},
        Case{layer(sggx(0.5, "lambert"), 1, 1) + layer(kSphere, 0.8, 0.5), 24, 1e-7},
        Case{layer(vmf(0.6, "lambert"), 1, 1) + lambert_ground(0.5), 24, 1e-7},
        Case{layer(sggx(0.6, "mirror"), 0.9, 0.7), 26, 3e-4},
        Case{layer(kIsotropic, 0.8, kInfinity), 16, 1e-7},
        Case{layer(vmf(0.6, "lambert"), 0.9, kInfinity), 24, 1e-7},
        Case{layer(vmf(0.6, "lambert") + "\naxis = [0, 0, -1]", 1, kInfinity), 20, 1e-7},
        Case{layer(kSphere, 1, kInfinity), 20, 1e-6}}) {
    const Stack stack = stack_of(c.toml);
    const DeterministicSolution exact = solve_deterministic(stack, {.tolerance = 1e-7});
    for (const double mu : {0.7, 0.01, -0.5}) {
      if (mu < 0 && !stack.is_open_below()) continue;
      const Direction wi = direction_from_mu_phi(mu, 0.4);
      const Solved solved(c.toml, wi, c.degree);
      const HarmonicEnergies& e = solved.solution.energies();
      const double list[] = {mu};
      const DeterministicEnergies expected = exact.energies(list).front();
      // The symmetric solver has an error of its own.
      const double bound = 2e-8 + 0.01 * c.tolerance + exact.accuracy().node_error;
      for (int order = 0; order < 4; ++order)
        EXPECT_NEAR((mu > 0 ? e.up : e.down)[order], expected.reflected[order].r, bound)
            << c.toml << " mu " << mu << " order " << order + 1;
      // What is lost to the depth.
      if (stack.is_half_space()) {
        EXPECT_NEAR(e.down[0] + e.down[1] + e.down[2] + e.down[3], expected.escaped[Order::all].r,
                    4 * bound)
            << c.toml << " mu " << mu;
      }
      EXPECT_NEAR(e.absorbed, expected.absorbed.r, 4 * bound) << c.toml << " mu " << mu;
      EXPECT_NEAR(e.sum(), 1, 4 * bound) << c.toml << " mu " << mu;
      for (const Direction wo : {direction_from_mu_phi(0.6, 2), direction_from_mu_phi(0.3, 5)}) {
        const DeterministicValue f = exact.f(wi, wo);
        const auto found = solved.solution.f(wo);
        for (int k = 0; k < kHarmonicOrders; ++k)
          EXPECT_NEAR(found[k], f.order[k + 1].r,
                      c.tolerance * f.order[Order::all].r + 2 * f.error.r)
              << c.toml << " mu " << mu << " order " << k + 2;
      }
    }
  }
}

TEST(HarmonicSolution, KeepsAllLightWhereNothingAbsorbs) {
  for (const std::string& toml :
       {layer(leaning(sggx(0.5, "mirror"), 1, 0, 0.5), 1, 1),
        layer(leaning(sggx(0.6, "mirror") + "\nshape = \"fiber\"", 1, 1, 0), 1, 4) +
            layer(leaning(vmf(0.7, "lambert"), 0.3, 0, 1), 1, 0.5),
        layer("medium = \"sggx\"\nmatrix = [0.5, 0.7, 1, 0.1, 0.05, 0]", 1, 1)}) {
    for (const double mu : {0.9, 0.2, -0.6}) {
      const Solved solved(toml, direction_from_mu_phi(mu, 1), 26);
      EXPECT_NEAR(solved.solution.energies().sum(), 1, 1e-8) << toml << " mu " << mu;
    }
  }
}

TEST(HarmonicSolution, IsReciprocalWhereFlakesHaveTwoSides) {
  const std::string toml =
      layer(leaning(sggx(0.6, "lambert"), 1, 0.3, 0.5), 0.9, 1) +
      layer(leaning(sggx(0.7, "lambert") + "\nshape = \"fiber\"", 0, 1, 0), 0.8, 2);
  const Direction a = direction_from_mu_phi(0.8, 0.3), b = direction_from_mu_phi(0.35, 2),
                  c = direction_from_mu_phi(-0.6, 4);
  // The degree leaves this much: what is not reciprocal falls with it, 1e-8 at 24.
  constexpr int kDegree = 40;
  const Solved from_a(toml, a, kDegree), from_b(toml, b, kDegree), from_c(toml, c, kDegree);
  EXPECT_NEAR(from_a.all(b) / from_b.all(a), 1, 1e-10);
  EXPECT_NEAR(from_a.all(c) / from_c.all(a), 1, 1e-10);
  EXPECT_NEAR(from_b.all(c) / from_c.all(b), 1, 1e-10);
}

TEST(HarmonicSolution, TurnsWithTheStackAndTheLight) {
  const auto at = [](double turn) {
    const auto axis = [&](double x, double y, double z) {
      return std::array<double, 3>{std::cos(turn) * x - std::sin(turn) * y,
                                   std::sin(turn) * x + std::cos(turn) * y, z};
    };
    const auto a = axis(1, 0.2, 0.3), b = axis(0, 1, 0);
    return Solved(layer(leaning(sggx(0.5, "lambert"), a[0], a[1], a[2]), 0.9, 1) +
                      layer(leaning(vmf(0.6, "lambert"), b[0], b[1], b[2]), 0.9, 1),
                  direction_from_mu_phi(0.5, turn), 20);
  };
  const Solved still = at(0), turned = at(1.234);
  EXPECT_NEAR(still.solution.energies().up[3], turned.solution.energies().up[3], 1e-9);
  EXPECT_NEAR(
      still.all(direction_from_mu_phi(0.4, 2)) / turned.all(direction_from_mu_phi(0.4, 2 + 1.234)),
      1, 1e-7);
}

TEST(HarmonicSolution, OfRoundFlakesIsIsotropicWhateverTheirAxis) {
  const Direction wi = direction_from_mu_phi(0.6, 0), wo = direction_from_mu_phi(0.4, 1);
  const Solved isotropic(layer(kIsotropic, 0.9, 1), wi, 16);
  for (const std::string shape : {"", "\nshape = \"fiber\""}) {
    const Solved round(layer(leaning(sggx(1, "mirror") + shape, 0.3, 0.5, 0.2), 0.9, 1), wi, 16);
    EXPECT_NEAR(round.all(wo) / isotropic.all(wo), 1, 1e-9);
  }
}

// Lobes by cells add up to the energies, which are integrals of their own; hard angles are finite.
TEST(HarmonicRun, CellsAddUpToTheEnergiesWithinTheirBounds) {
  const Stack stack =
      stack_of(layer(leaning(sggx(0.5, "mirror"), 0.5, 0, 1) + "\nf0 = [0.9, 0.5, 0.5]", 0.9, 1) +
               layer(leaning(vmf(0.6, "lambert"), 0, 0.5, 1), 0.7, 0.5));
  const Plan plan = make_plan(stack);
  const std::vector<Direction> incident{direction_from_degrees(45, 20),
                                        direction_from_degrees(89.99, 0), Direction{1, 0, 0},
                                        direction_from_degrees(130, 250)};
  const std::vector<RunResult> runs =
      harmonic_runs(stack, plan, incident, CellGrid{8, 16},
                    {.tolerance = 1e-2, .max_seconds = kInfinity, .max_degree = 24});
  ASSERT_EQ(runs.size(), incident.size());
  for (const RunResult& run : runs) {
    // Light that grazes mirrors takes more than this degree.
    EXPECT_LT(run.accuracy->error, 0.1);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(ledger_sum(run, c), 1, 5e-5);
      for (const SideResult* side : {&run.reflected, &run.transmitted})
        for (int lobe = 0; lobe <= kTallyOrders; ++lobe) {
          const int cells = run.grid.cells();
          double sum = 0, bound = 1e-6;
          for (int k = 0; k < cells; ++k) {
            EXPECT_TRUE(std::isfinite(side->lobes[lobe].value[c * cells + k]));
            sum += run.grid.projected_solid_angle() * side->lobes[lobe].value[c * cells + k];
            bound +=
                run.grid.projected_solid_angle() * side->lobes[lobe].standard_error[c * cells + k];
          }
          const Estimate& energy = lobe == kTallyOrders ? side->total[c] : side->orders[lobe][c];
          EXPECT_NEAR(sum, energy.value, bound + energy.standard_error) << lobe;
        }
    }
  }
}

TEST(HarmonicRun, SaysWhatItLeavesToWalks) {
  const auto reason = [](const std::string& toml) {
    return why_not_harmonic(stack_of(toml)).value_or("none");
  };
  EXPECT_EQ(reason(layer(leaning(sggx(0.5, "mirror"), 1, 0, 0), 1, 1)), "none");
  EXPECT_EQ(reason(layer(leaning(vmf(0.5, "lambert"), 1, 0, 1), 1, kInfinity)), "none");
  const std::string tilted = layer(leaning(sggx(0.5, "mirror"), 1, 0, 0), 1, 1);
  const auto face = [](const std::string& keys) { return "[[layer]]\ninterface = " + keys; };
  EXPECT_EQ(reason(face("\"smooth\"\nior = 1.5\n") + tilted + lambert_ground(0.5)), "none");
  EXPECT_EQ(reason(face("\"ggx\"\nior = 1.5\nroughness = 0.2\n") + tilted), "none");
  EXPECT_EQ(reason(face("\"ggx\"\nior = 1.5\nroughness = [0.2, 0.4]\n") + tilted), "none");
  EXPECT_NE(
      reason(face("\"ggx\"\nior = 1.5\nroughness = 0.2\nscattering = \"multiple\"\n") + tilted)
          .find("multiple"),
      std::string::npos);
  EXPECT_EQ(reason(tilted + "[substrate]\nbsdf = \"conductor\"\neta = 1\nk = 4\n"
                            "distribution = \"smooth\"\n"),
            "none");
  EXPECT_EQ(reason(layer("medium = \"sggx\"\nmatrix = [0.3, 0.5, 1, 0, 0, 0.1]", 1, 1)), "none");
}

// Random stacks of every medium against walks: energies and cells, within the bounds of both.
TEST(HarmonicRun, AgreesWithWalksOnRandomStacks) {
  constexpr int kStacks = 30;
  const double limit = testing::normal_quantile(testing::test_level() / 40);
  for (int n = 0; n < kStacks; ++n) {
    RandomStream random(7, n, StreamPurpose::test);
    const auto between = [&](double a, double b) { return a + (b - a) * random.uniform(); };
    std::string toml;
    const int layers = random.uniform() < 0.5 ? 1 : 2;
    for (int k = 0; k < layers; ++k) {
      const double roughness = between(0.45, 1);
      std::string medium;
      switch (k == 0 ? n % 6 : static_cast<int>(between(0, 7.99))) {
        case 5:
          medium = fmt::format("medium = \"sggx\"\nflake = \"{}\"\nmatrix = [{}, {}, 1, {}, 0, {}]",
                               n % 4 ? "mirror" : "lambert", between(0.3, 0.6), between(0.7, 1),
                               between(-0.1, 0.1), between(-0.1, 0.1));
          break;
        case 0:
          medium = sggx(roughness, "mirror");
          break;
        case 1:
          medium = sggx(roughness, "mirror") + "\nshape = \"fiber\"";
          break;
        case 2:
          medium = sggx(roughness, "lambert");
          break;
        case 3:
          medium = vmf(roughness, "lambert");
          break;
        case 4:
          medium = vmf(roughness, "mirror");
          break;
        case 6:
          medium = henyey_greenstein(0.5);
          break;
        default:
          medium = kSphere;
          break;
      }
      if (medium.find("flake") != std::string::npos && medium.find("matrix") == std::string::npos)
        medium = leaning(medium, between(-1, 1), between(-1, 1), between(-1, 1));
      toml += layer(medium, random.uniform() < 0.3 ? 1 : between(0.3, 1), between(0.2, 3));
    }
    const bool open = random.uniform() < 0.6;
    if (!open) toml += lambert_ground(between(0, 1));
    const Stack stack = stack_of(toml);
    ASSERT_FALSE(why_not_harmonic(stack)) << toml;
    const double mu = between(0.05, 1) * (open && random.uniform() < 0.4 ? -1 : 1);
    const Direction wi[] = {direction_from_mu_phi(mu, between(0, 6.28))};
    const Plan plan = make_plan(stack);
    const CellGrid grid{3, 6};
    const RunResult solved = harmonic_runs(
        stack, plan, wi, grid, {.tolerance = 1e-2, .max_seconds = kInfinity, .max_degree = 24})[0];
    Simulation walks(stack, plan, wi[0], Estimator::analog, grid, 5);
    walks.advance(is_soak() ? 100000000 : 400000);
    const RunResult found = reduce(walks);
    const auto agree = [&](const Estimate& a, const Estimate& b, const std::string& what) {
      EXPECT_LT(std::abs(a.value - b.value), limit * b.standard_error + a.standard_error + 1e-6)
          << what << ' ' << a.value << ' ' << b.value << " mu " << mu << '\n'
          << toml;
    };
    agree(solved.absorbed[0], found.absorbed[0], "absorbed");
    agree(solved.uncollided[0], found.uncollided[0], "uncollided");
    for (const auto side : {&RunResult::reflected, &RunResult::transmitted}) {
      const SideResult &a = solved.*side, &b = found.*side;
      agree(a.total[0], b.total[0], "total");
      for (int o = 0; o < kTallyOrders; ++o) agree(a.orders[o][0], b.orders[o][0], "order");
      const LobeEstimate &x = a.lobes[Order::all], &y = b.lobes[Order::all];
      ASSERT_EQ(x.value.size(), y.value.size());
      for (std::size_t k = 0; k < x.value.size(); ++k)
        if (y.standard_error[k] > 0)
          agree({x.value[k], x.standard_error[k]}, {y.value[k], y.standard_error[k]}, "cell");
    }
  }
}

// Values at pairs, those of mirrors among them, within both bounds of the symmetric solver's; and
// nothing below an opaque ground.
TEST(HarmonicPairs, AreWithinTheirBounds) {
  const Stack stack =
      stack_of(layer(sggx(0.5, "mirror") + "\nf0 = [0.9, 0.5, 0.5]", 0.9, 1) + lambert_ground(0.4));
  const DeterministicSolution expected = solve_deterministic(stack, {.tolerance = 1e-5});
  const std::vector<std::pair<Direction, Direction>> pairs{
      {direction_from_mu_phi(0.6, 0), direction_from_mu_phi(0.5, 2)},
      {direction_from_mu_phi(0.9, 0), direction_from_mu_phi(0.2, 0.5)},
      {direction_from_mu_phi(0.6, 0), direction_from_mu_phi(0, 3)},
      {direction_from_mu_phi(0.6, 0), direction_from_mu_phi(-0.5, 3)}};
  DeterministicAccuracy accuracy;
  const auto found =
      harmonic_pairs(stack, pairs, {.tolerance = 1e-3, .max_seconds = kInfinity}, accuracy);
  ASSERT_EQ(found.size(), pairs.size());
  EXPECT_TRUE(accuracy.reached);
  EXPECT_LE(accuracy.error, 1e-3);
  for (std::size_t k = 0; k + 1 < pairs.size(); ++k) {
    const DeterministicValue f = expected.f(pairs[k].first, with_grazing_limit(pairs[k].second));
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(found[k].f[c], f.order[Order::all][c], found[k].error[c] + f.error[c]) << k;
  }
  EXPECT_EQ(found[3].f, Rgb());
}

// Kernels of three eigenvalues take the fourth power of the degree. What is refused is told: the
// degree before is the answer, of cells and of values at pairs.
TEST(HarmonicRun, KeepsWithinItsMemory) {
  const Direction wi[] = {direction_from_mu_phi(0.7, 0.2)};
  const std::pair<Direction, Direction> pairs[] = {{wi[0], direction_from_mu_phi(0.5, 1)}};
  for (const std::string& medium :
       {leaning(sggx(0.3, "mirror"), 1, 0, 1),
        std::string("medium = \"sggx\"\nmatrix = [0.5, 0.7, 1, 0.1, 0.05, 0]")}) {
    const Stack stack = stack_of(layer(medium, 0.9, 0.5));
    const auto options = [](std::size_t bytes) {
      return HarmonicOptions{.tolerance = 1e-6,
                             .max_seconds = kInfinity,
                             .max_degree = 24,
                             .max_bytes = bytes,
                             .integrate_from = 0};
    };
    const Plan plan = make_plan(stack);
    const RunResult all = harmonic_runs(stack, plan, wi, {3, 6}, options(std::size_t{1} << 30))[0];
    EXPECT_EQ(all.accuracy->limit, DeterministicLimit::modes);
    EXPECT_GT(all.accuracy->bytes, 1000000U);
    const RunResult small =
        harmonic_runs(stack, plan, wi, {3, 6}, options(all.accuracy->bytes - 1))[0];
    EXPECT_EQ(small.accuracy->limit, DeterministicLimit::memory);
    EXPECT_LT(small.accuracy->harmonics, all.accuracy->harmonics);
    EXPECT_LT(small.accuracy->bytes, all.accuracy->bytes);
    DeterministicAccuracy accuracy;
    static_cast<void>(harmonic_pairs(stack, pairs, options(all.accuracy->bytes - 1), accuracy));
    EXPECT_EQ(accuracy.limit, DeterministicLimit::memory);
    EXPECT_EQ(accuracy.harmonics, small.accuracy->harmonics);
    EXPECT_EQ(accuracy.bytes, small.accuracy->bytes);
  }
}

// Ctrl-C in the middle of a degree leaves what the degree before it gave.
TEST(HarmonicRun, EndsWithinADegreeOnceItIsStopped) {
  const Stack stack = stack_of(layer(leaning(sggx(0.5, "lambert"), 1, 0, 1), 0.9, 0.5));
  const Direction wi[] = {direction_from_mu_phi(0.7, 0.2)};
  const Plan plan = make_plan(stack);
  std::atomic<bool> stop{false};
  std::vector<int> degrees;
  const RunResult stopped = harmonic_runs(stack, plan, wi, CellGrid{3, 6},
                                          {.tolerance = 1e-9,
                                           .max_seconds = kInfinity,
                                           .stop = &stop,
                                           .report = [&](const auto& progress) {
                                             degrees.push_back(progress.nodes);
                                             stop = degrees.size() == 2;
                                           }})[0];
  ASSERT_EQ(degrees.size(), 2);
  EXPECT_GT(degrees[1], degrees[0]);
  ASSERT_TRUE(stopped.accuracy);
  EXPECT_EQ(stopped.accuracy->limit, DeterministicLimit::interrupted);
  EXPECT_EQ(stopped.accuracy->harmonics, degrees[0]);
  const RunResult first = harmonic_runs(stack, plan, wi, CellGrid{3, 6},
                                        {.tolerance = 1e-9, .max_degree = degrees[0]})[0];
  EXPECT_EQ(stopped.reflected.lobes[Order::all].value, first.reflected.lobes[Order::all].value);
}

}  // namespace
}  // namespace lamella
