// Random stacks with boundaries and without symmetry about the normal against walks: energies and
// cells, order by order, within the bounds of both.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "tests/statistics/statistics.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/harmonics/harmonic_pairs.h"
#include "volume/harmonics/harmonic_run.h"
#include "volume/quadrature/quadrature.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

class RandomStack {
 public:
  explicit RandomStack(int n) : random_(11, n, StreamPurpose::test) {
    const bool is_rough = n % 2 == 1;
    const double outer = between(1.2, 1.8);
    if (n % 4 == 3) toml_ += layer(henyey_greenstein(0.3), between(0.5, 1), between(0.1, 0.5));
    toml_ += face(is_rough, outer) + tilted(n);
    if (n % 3 == 1) toml_ += face(random_.uniform() < 0.5, between(1.1, 2)) + tilted(n + 1);
    if (n % 3 == 2) toml_ += face(false, between(1.1, 1.6));
    switch (n % 5) {
      case 0:
        toml_ += lambert_ground(between(0, 1));
        break;
      case 1:
        toml_ +=
            "[substrate]\nbsdf = \"conductor\"\neta = 0.3\nk = 3\ndistribution = \"ggx\"\n"
            "roughness = 0.4\n";
        break;
      case 3:
        toml_ += "[substrate]\nbsdf = \"conductor\"\neta = 0.3\nk = 3\ndistribution = \"smooth\"\n";
        break;
      default:
        break;
    }
  }

  [[nodiscard]] const std::string& toml() const { return toml_; }
  double between(double a, double b) { return a + (b - a) * random_.uniform(); }

 private:
  std::string face(bool is_rough, double ior) {
    return is_rough
               ? fmt::format("[[layer]]\ninterface = \"{}\"\nior = {}\nroughness = {}\n",
                             random_.uniform() < 0.5 ? "ggx" : "beckmann", ior, between(0.3, 0.7))
               : fmt::format("[[layer]]\ninterface = \"smooth\"\nior = {}\n", ior);
  }
  std::string tilted(int n) {
    const double roughness = between(0.5, 1);
    const std::string flake = n % 3 == 0 ? "mirror" : "lambert";
    std::string medium = n % 4 == 1 ? vmf(roughness, flake) : sggx(roughness, flake);
    if (n % 4 == 2) medium += "\nshape = \"fiber\"";
    medium += fmt::format("\naxis = [{}, {}, {}]", between(-1, 1), between(-1, 1), between(-1, 1));
    return layer(medium, random_.uniform() < 0.3 ? 1 : between(0.3, 1), between(0.2, 2));
  }

  RandomStream random_;
  std::string toml_;
};

// Of differences over their errors.
class MeanSquare {
 public:
  void add(double z) {
    sum_ += z * z;
    ++count_;
  }
  void add(const MeanSquare& other) {
    sum_ += other.sum_;
    count_ += other.count_;
  }
  [[nodiscard]] double root() const { return std::sqrt(sum_ / std::max(count_, 1)); }
  [[nodiscard]] int count() const { return count_; }

 private:
  double sum_ = 0;
  int count_ = 0;
};

// In soak one line tells of each stack, so that progress is seen.
TEST(BoundedRun, AgreesWithWalksOnRandomStacks) {
  const int stacks = is_soak() ? 30 : 10;
  const double limit = testing::normal_quantile(testing::test_level() / 100 / stacks);
  MeanSquare all;
  for (int n = 0; n < stacks; ++n) {
    RandomStack random(n);
    const Stack stack = stack_of(random.toml());
    ASSERT_FALSE(why_not_harmonic(stack)) << *why_not_harmonic(stack) << '\n' << random.toml();
    MeanSquare z;
    const bool from_below = stack.is_open_below() && n % 2 == 0;
    const double mu = random.between(0.1, 1) * (from_below ? -1 : 1);
    const Direction wi[] = {direction_from_mu_phi(mu, random.between(0, 6.28))};
    Plan plan = make_plan(stack);
    if (is_soak()) plan.isa = isa_from_text("auto");
    const CellGrid grid{3, 6};
    const RunResult solved = harmonic_runs(stack, plan, wi, grid,
                                           {.tolerance = is_soak() ? 1e-3 : 1e-2,
                                            .max_seconds = kInfinity,
                                            .max_degree = is_soak() ? 34 : 24})[0];
    EXPECT_LT(solved.accuracy->error, 0.05) << random.toml();
    EXPECT_NEAR(ledger_sum(solved, 0), 1, 1e-4) << random.toml();
    const auto begin = std::chrono::steady_clock::now();
    Simulation walks(stack, plan, wi[0], Estimator::analog, grid, 5);
    // Walks without a kernel on lanes take twenty times as long.
    const std::uint64_t in_soak = walks.isa() == Isa::scalar ? 10000000 : 100000000;
    walks.advance(is_soak() ? in_soak : 200000);
    const std::chrono::duration<double> walked = std::chrono::steady_clock::now() - begin;
    const RunResult found = reduce(walks);
    const auto agree = [&](const Estimate& a, const Estimate& b, const std::string& what) {
      EXPECT_LT(std::abs(a.value - b.value), limit * b.standard_error + a.standard_error + 1e-6)
          << what << ' ' << a.value << ' ' << b.value << " mu " << mu << '\n'
          << random.toml();
      if (b.standard_error > 0)
        z.add((a.value - b.value) / std::hypot(a.standard_error, b.standard_error));
    };
    agree(solved.absorbed[0], found.absorbed[0], "absorbed");
    agree(solved.lost[0], found.lost[0], "lost");
    agree(solved.uncollided[0], found.uncollided[0], "uncollided");
    for (const auto side : {&RunResult::reflected, &RunResult::transmitted}) {
      const SideResult &a = solved.*side, &b = found.*side;
      agree(a.total[0], b.total[0], "total");
      agree(a.zero[0], b.zero[0], "zero");
      agree(a.specular[0], b.specular[0], "specular");
      for (int o = 0; o < kTallyOrders; ++o) agree(a.orders[o][0], b.orders[o][0], "order");
      for (const Order order : {Order::all, Order::zero, Order::one, Order::multiple}) {
        const LobeEstimate &x = a.lobes[order], &y = b.lobes[order];
        ASSERT_EQ(x.value.size(), y.value.size()) << to_text(order) << '\n' << random.toml();
        for (std::size_t k = 0; k < x.value.size(); ++k)
          if (y.standard_error[k] > 0)
            agree({x.value[k], x.standard_error[k]}, {y.value[k], y.standard_error[k]},
                  "cell of order " + to_text(order));
      }
    }
    all.add(z);
    if (is_soak()) {
      fmt::print(
          "stack {}: bound {:.1e} at degree {} after {:.0f} s, {:.0e} walks {:.0f} s, rms z "
          "{:.2f}\n",
          n, solved.accuracy->error, solved.accuracy->harmonics, solved.accuracy->seconds,
          static_cast<double>(in_soak), walked.count(), z.root());
      std::fflush(stdout);
    }
  }
  if (is_soak()) fmt::print("all: rms z {:.2f} of {} values\n", all.root(), all.count());
}

// Facets and grounds that tell x from y, over and under layers that do and that do not: energies
// and cells of walks, whose z have a root mean square near 1; and what memory the operators may
// take.
TEST(BoundedRun, TakesBoundariesThatDifferAlongXAndY) {
  const std::string ground =
      "[substrate]\nbsdf = \"conductor\"\neta = 0.2\nk = 3\ndistribution = \"ggx\"\n"
      "roughness = [0.6, 0.45]\n";
  const std::string face = "[[layer]]\ninterface = \"ggx\"\nior = 1.5\nroughness = [0.6, 0.45]\n";
  const std::string tilted = layer(sggx(0.7, "lambert") + "\naxis = [1, 0.2, 0.3]", 0.9, 0.7);
  for (const std::string& toml : {layer(kIsotropic, 0.9, 0.7) + ground, face + tilted}) {
    const Stack stack = stack_of(toml);
    const Direction wi[] = {direction_from_mu_phi(0.7, 0.5)};
    const Plan plan = make_plan(stack);
    const CellGrid grid{2, 4};
    const RunResult solved = harmonic_runs(
        stack, plan, wi, grid, {.tolerance = 2e-3, .max_seconds = kInfinity, .max_degree = 17})[0];
    EXPECT_LT(solved.accuracy->error, 0.01) << toml;
    EXPECT_GT(solved.accuracy->bytes, 1000000U) << toml;
    EXPECT_NEAR(ledger_sum(solved, 0), 1, 1e-7) << toml;
    Simulation walks(stack, plan, wi[0], Estimator::analog, grid, 5);
    walks.advance(is_soak() ? 100000000 : 500000);
    const RunResult found = reduce(walks);
    const double limit = testing::normal_quantile(testing::test_level() / 200);
    double squares = 0;
    int count = 0;
    const auto agree = [&](const Estimate& a, const Estimate& b, const std::string& what) {
      EXPECT_LT(std::abs(a.value - b.value), limit * b.standard_error + a.standard_error + 1e-6)
          << what << ' ' << a.value << ' ' << b.value << '\n'
          << toml;
    };
    agree(solved.absorbed[0], found.absorbed[0], "absorbed");
    agree(solved.lost[0], found.lost[0], "lost");
    for (const auto side : {&RunResult::reflected, &RunResult::transmitted}) {
      const SideResult &a = solved.*side, &b = found.*side;
      agree(a.total[0], b.total[0], "total");
      agree(a.zero[0], b.zero[0], "zero");
      for (int o = 0; o < kTallyOrders; ++o) agree(a.orders[o][0], b.orders[o][0], "order");
      for (const Order order : {Order::zero, Order::one, Order::two, Order::multiple}) {
        const LobeEstimate &x = a.lobes[order], &y = b.lobes[order];
        for (std::size_t k = 0; k < x.value.size(); ++k)
          if (y.standard_error[k] > 0) {
            agree({x.value[k], x.standard_error[k]}, {y.value[k], y.standard_error[k]},
                  "cell of order " + to_text(order));
            const double z = (x.value[k] - y.value[k]) / y.standard_error[k];
            squares += z * z;
            ++count;
          }
      }
    }
    EXPECT_NEAR(std::sqrt(squares / count), 1, 0.5) << toml;
  }
  // Degree 17 would take more than that.
  const Stack stack = stack_of(layer(kIsotropic, 0.9, 0.7) + ground);
  const Direction wi[] = {direction_from_mu_phi(0.7, 0.5)};
  const RunResult small =
      harmonic_runs(stack, make_plan(stack), wi, {2, 4},
                    {.tolerance = 1e-6, .max_seconds = kInfinity, .max_bytes = 5000000})[0];
  EXPECT_EQ(small.accuracy->harmonics, 12);
  EXPECT_EQ(small.accuracy->limit, DeterministicLimit::memory);
}

// Cells are means of values at pairs: their sums over a fine rule agree within both bounds. In
// batches, too. A smooth conductor mirrors what a rough face has spread, so that order 1 is a lobe
// narrower than its cells, which take more points for it.
TEST(BoundedRun, HasTheValuesAtPairsThatItsCellsAreMeansOf) {
  const std::string face = "[[layer]]\ninterface = \"ggx\"\nior = 1.5\nroughness = ";
  const std::string tilted = layer(sggx(0.6, "lambert") + "\naxis = [1, 0, 0.4]", 0.9, 1);
  const std::string thin = layer(sggx(0.7, "lambert") + "\naxis = [1, 0.2, 0.4]", 0.9, 0.05);
  const std::string mirror =
      "[substrate]\nbsdf = \"conductor\"\neta = 0.3\nk = 3\ndistribution = \"smooth\"\n";
  struct Case {
    std::string toml;
    double tolerance;
  };
  for (const auto& [toml, tolerance] : {Case{face + "0.5\n" + tilted + lambert_ground(0.5), 1e-3},
                                        Case{face + "0.35\n" + thin + mirror, 1e-4}}) {
    const Stack stack = stack_of(toml);
    const Direction wi = direction_from_mu_phi(0.6, 0.3);
    const Direction incident[] = {wi};
    const Plan plan = make_plan(stack);
    const CellGrid grid{2, 4};
    const HarmonicOptions options{.tolerance = tolerance, .max_seconds = kInfinity};
    const RunResult cells = harmonic_runs(stack, plan, incident, grid, options)[0];
    EXPECT_LT(cells.accuracy->error, tolerance) << toml;
    // Cell 1 of the first row.
    constexpr int kRule = 20;
    const Quadrature& rule = cached_gauss_legendre(kRule);
    std::vector<std::pair<Direction, Direction>> pairs;
    std::vector<double> weight;
    const double high = grid.edge_mu(0), low = grid.edge_mu(1), width = grid.edge_phi(1);
    for (int j = 0; j < kRule; ++j)
      for (int k = 0; k < kRule; ++k) {
        const double mu = low + (high - low) * rule.points[j];
        pairs.emplace_back(wi,
                           direction_from_mu_phi(mu, azimuth(wi) + width * (1 + rule.points[k])));
        weight.push_back(2 * mu / (high + low) * rule.weights[j] * rule.weights[k]);
      }
    DeterministicAccuracy accuracy;
    const auto values = harmonic_pairs(stack, pairs, options, accuracy);
    ASSERT_EQ(values.size(), pairs.size());
    EXPECT_TRUE(accuracy.reached);
    double mean = 0, bound = 0;
    for (std::size_t k = 0; k < values.size(); ++k) {
      mean += weight[k] * values[k].f.r;
      bound += weight[k] * values[k].error[0];
    }
    const LobeEstimate& lobe = cells.reflected.lobes[Order::all];
    EXPECT_NEAR(lobe.value[1], mean, lobe.standard_error[1] + bound) << toml;
  }
}

}  // namespace
}  // namespace lamella
