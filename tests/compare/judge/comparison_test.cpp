#include "compare/judge/comparison.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "phase/random/random.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "tests/statistics/statistics.h"
#include "tests/volume/voxels/grids.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

constexpr CellGrid kGrid{4, 8, false};

Stack spheres(const std::string& albedo, const std::string& thickness) {
  std::string text = "[[layer]]\nmedium = \"lambert_sphere\"\nalbedo = ";
  text += albedo;
  text += "\nthickness = ";
  text += thickness;
  return parse_stack(text, "test", "test");
}

std::unique_ptr<Model> model_of(const std::string& name, const Stack& stack,
                                const Parameters& parameters = {}) {
  return find_model(name)->make(parameters, &stack);
}

ProjectedLobes single_scattering(const Stack& stack, Direction wi, const CellGrid& grid,
                                 bool reflected) {
  return project(*model_of("single_scattering", stack), *find_model("single_scattering"), wi, grid,
                 (wi.z > 0) == reflected, stack.is_grey() ? 1 : 3);
}

// Walks cut after one event: single scattering is then the truth in order 1, and what the cut took
// is missing in all.
struct Setting {
  Setting(Stack s, double theta)
      : stack(std::move(s)),
        plan(make_plan(stack, {.max_order = 1})),
        wi(direction_from_degrees(theta, 20)) {
    CellGrid grid = kGrid;
    grid.folded = plan.folded;
    for (const bool reflected : {true, false})
      if (reflected || plan.transmits)
        exact.push_back(single_scattering(stack, wi, grid, reflected));
  }

  // A judged report of a run against the exact lobes times `factor`.
  [[nodiscard]] std::vector<LobeComparison> report(Estimator estimator, std::uint64_t walks,
                                                   std::uint64_t seed, double factor = 1) const {
    Simulation simulation(stack, plan, wi, estimator, kGrid, seed);
    simulation.advance(walks);
    const RunResult run = reduce(simulation);
    std::vector<LobeComparison> lobes;
    for (std::size_t side = 0; side < exact.size(); ++side) {
      ProjectedLobes model = exact[side];
      for (auto& lobe : model.lobes)
        for (double& f : lobe) f *= factor;
      for (LobeComparison& l : compare(run, &simulation, model, side == 0))
        lobes.push_back(std::move(l));
    }
    std::vector<LobeComparison*> all;
    for (LobeComparison& l : lobes) all.push_back(&l);
    decide(all);
    return lobes;
  }

  Stack stack;
  Plan plan;
  Direction wi;
  std::vector<ProjectedLobes> exact;  // reflected, transmitted
};

double most_refusals(int trials, double level) {
  return boost::math::quantile(
      complement(boost::math::binomial(trials, level), testing::test_level()));
}

TEST(Projection, OfLambertIsAlbedoOverPiInEveryCell) {
  Parameters parameters;
  parameters.set("albedo", Rgb{0.9, 0.5, 0.2});
  const Stack stack = load_stack("lambert_sphere_halfspace");
  const auto model = model_of("lambert", stack, parameters);
  for (const double theta : {0.0, 60.0, 90.0}) {
    const ProjectedLobes lobes =
        project(*model, *find_model("lambert"), direction_from_degrees(theta, 0), kGrid, true, 3);
    EXPECT_TRUE(lobes.has[Order::all]);
    EXPECT_FALSE(lobes.has[0]);
    ASSERT_EQ(lobes.lobes[Order::all].size(), 3u * kGrid.cells());
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < kGrid.cells(); ++k)
        EXPECT_NEAR(lobes.lobes[Order::all][c * kGrid.cells() + k],
                    parameters.color("albedo")[c] / kPi, 1e-15);
  }
}

TEST(Projection, OfSingleScatteringAddsUpToItsDirectionalAlbedo) {
  for (const char* name : {"sggx_slab", "hg_slab", "spongecake_sheen", "lambert_sphere_kd"}) {
    const Stack stack = load_stack(name);
    const int channels = stack.is_grey() ? 1 : 3;
    const auto model = model_of("single_scattering", stack);
    for (const double theta : {0.0, 60.0, 85.0}) {
      const Direction wi = direction_from_degrees(theta, 0);
      const Rgb albedo = model->albedo(wi);
      for (int c = 0; c < channels; ++c) {
        double sum = 0;
        for (const bool reflected : {true, false}) {
          const auto lobes = single_scattering(stack, wi, kGrid, reflected);
          for (int k = 0; k < kGrid.cells(); ++k)
            sum += kGrid.projected_solid_angle() * lobes.lobes[Order::all][c * kGrid.cells() + k];
        }
        // The projection is refined until a cell changes by less than 1e-4.
        EXPECT_NEAR(sum / albedo[c], 1, 1e-4) << name << ' ' << theta << ' ' << c;
      }
    }
  }
}

TEST(Comparison, CallsATrueModelDifferentNoMoreOftenThanItSays) {
  for (const auto& [name, theta] :
       {std::pair("sggx_slab", 40.0), {"spongecake_window_shade", 80.0}})
    for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
      const Setting setting(load_stack(name), theta);
      constexpr int kReports = 300;
      int different = 0, below_5 = 0, below_1 = 0, lobes = 0;
      for (int seed = 1; seed <= kReports; ++seed) {
        bool any = false;
        for (const LobeComparison& l : setting.report(estimator, 2000, seed)) {
          any = any || l.verdict == Verdict::differs;
          if (l.order != Order::one) continue;  // the others are cut
          below_5 += l.p_value < 0.05;
          below_1 += l.p_value < 0.01;
          ++lobes;
        }
        different += any;
      }
      EXPECT_LE(different, most_refusals(kReports, kReportFalseAlarm))
          << name << to_text(estimator);
      EXPECT_LE(below_5, most_refusals(lobes, 0.05)) << name << to_text(estimator);
      EXPECT_LE(below_1, most_refusals(lobes, 0.01)) << name << to_text(estimator);
    }
}

// Reports of walks, whose batches are shifted lattices, against the solver's lobes as the model:
// what batches scatter by must still say how far the mean is off.
void expect_few_false_alarms(const std::string& name, const Stack& stack, const Plan& plan,
                             Direction incident, Estimator estimator, const CellGrid& grid,
                             const RunResult& solved) {
  const int reports = std::getenv("LAMELLA_SOAK") ? 200 : 10;
  constexpr std::uint64_t kWalks = kBatches * 256;
  int different = 0;
  OrderMap<int> below_5{}, below_1{};
  int sides = 0;
  for (int seed = 1; seed <= reports; ++seed) {
    Simulation simulation(stack, plan, incident, estimator, grid, seed);
    ASSERT_TRUE((plan.isa == Isa::scalar && !plan.has_grids()) ||
                simulation.sampling() == Sampling::rqmc);
    simulation.advance(kWalks);
    const RunResult run = reduce(simulation);
    ASSERT_EQ(run.order_one, plan.order_one);
    std::vector<LobeComparison> lobes;
    sides = 0;
    for (const bool reflected : {true, false}) {
      const SideResult& side = reflected ? solved.reflected : solved.transmitted;
      if (side.lobes[Order::all].value.empty()) continue;
      ++sides;
      ProjectedLobes model;
      for (const Order order :
           {Order::one, Order::two, Order::three, Order::four_plus, Order::all, Order::multiple}) {
        model.lobes[order] = side.lobes[order].value;
        model.has[order] = true;
      }
      for (LobeComparison& l : compare(run, &simulation, model, reflected))
        lobes.push_back(std::move(l));
    }
    std::vector<LobeComparison*> all;
    for (LobeComparison& l : lobes) all.push_back(&l);
    decide(all);
    bool any = false;
    for (const LobeComparison& l : lobes) {
      any = any || l.verdict == Verdict::differs;
      below_5[l.order] += l.p_value < 0.05;
      below_1[l.order] += l.p_value < 0.01;
    }
    different += any;
  }
  std::printf("%s, order 1 %s: %d of %d reports call the truth different\n", name.c_str(),
              to_text(plan.order_one).c_str(), different, reports);
  EXPECT_LE(different, most_refusals(reports, kReportFalseAlarm)) << name;
  for (const Order order :
       {Order::one, Order::two, Order::three, Order::four_plus, Order::all, Order::multiple}) {
    EXPECT_LE(below_5[order], most_refusals(sides * reports, 0.05)) << name << to_text(order);
    EXPECT_LE(below_1[order], most_refusals(sides * reports, 0.01)) << name << to_text(order);
  }
}

// Order 1 exact or not.
TEST(Comparison, CallsATrueModelDifferentNoMoreOftenThanItSaysWithLattices) {
  struct Truth {
    const char* name;
    Estimator estimator;
    OrderOne order_one;
  };
  for (const auto& [name, estimator, order_one] :
       {Truth{"lambert_sphere_halfspace", Estimator::next_event, OrderOne::exact},
        {"sggx_slab", Estimator::analog, OrderOne::exact},
        {"sggx_slab", Estimator::analog, OrderOne::walked}}) {
    const Stack stack = load_stack(name);
    Plan plan = make_plan(stack, {.sampling = Sampling::rqmc, .order_one = order_one});
    plan.isa = supported_isas().back();
    const Direction incident[] = {direction_from_degrees(60, 0)};
    CellGrid grid = kGrid;
    grid.folded = true;
    const RunResult solved = deterministic_runs(solve_deterministic(stack, {.tolerance = 1e-6}),
                                                plan, incident, grid, 1e-6)[0];
    expect_few_false_alarms(name, stack, plan, incident[0], estimator, grid, solved);
  }
}

// A constant grid is the homogeneous layer, which the solver knows: walks on lanes and in double,
// counted and by next-event estimation.
TEST(Comparison, CallsATrueModelDifferentNoMoreOftenThanItSaysWithLatticesInGrids) {
  const std::string keys =
      "medium = 'henyey_greenstein'\ng = 0.4\nalbedo = 0.9\nthickness = 0.5\ndensity = ";
  const Stack homogeneous = testing::stack_from(testing::layer(keys + "3"));
  const Stack stack = testing::stack_from(testing::grid_layer(keys + "4"));
  const auto voxels = testing::shared_voxels_of({9, 16, 5}, [](VoxelIndex) { return 0.75; });
  const Direction incident[] = {direction_from_degrees(60, 0)};
  Plan whole_circle = make_plan(homogeneous);
  whole_circle.folded = false;
  const RunResult solved = deterministic_runs(solve_deterministic(homogeneous, {.tolerance = 1e-6}),
                                              whole_circle, incident, kGrid, 1e-6)[0];
  Plan plan = testing::plan_with(stack, {voxels});
  plan.sampling = Sampling::rqmc;
  plan.order_one = OrderOne::walked;
  for (const Isa isa : {Isa::scalar, supported_isas().back()})
    for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
      plan.isa = isa;
      expect_few_false_alarms("a constant grid, " + to_text(isa) + ", " + to_text(estimator), stack,
                              plan, incident[0], estimator, kGrid, solved);
    }
}

TEST(Comparison, FindsAModelThatIsThreePercentOff) {
  const Setting setting(load_stack("sggx_slab"), 40);
  for (int seed = 1; seed <= 10; ++seed) {
    const auto lobes = setting.report(Estimator::analog, 1000000, seed, 1.03);
    // Reflected energy 0.3: its standard error is 0.15 %, so 3 % stands out by 20 of them.
    EXPECT_EQ(lobes[0].verdict, Verdict::differs);
    EXPECT_NEAR(lobes[0].energy_model[0] / lobes[0].energy_truth[0], 1.03, 0.01);
    EXPECT_NEAR(lobes[0].relative_rmse_without_noise, 0.03, 0.015);
    EXPECT_LT(lobes[0].rmse_without_noise, lobes[0].rmse);
  }
}

TEST(Comparison, AgreesWithATrueModelOnceTheNoiseIsSmall) {
  const Setting setting(load_stack("sggx_slab"), 40);
  for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
    const std::uint64_t walks = estimator == Estimator::analog ? 1000000 : 100000;
    for (const LobeComparison& l : setting.report(estimator, walks, 3)) {
      if (l.order != Order::one) {
        EXPECT_EQ(l.verdict, Verdict::insufficient) << to_text(estimator) << l.reflected;
        continue;
      }
      EXPECT_EQ(l.verdict, Verdict::agrees)
          << to_text(estimator) << l.reflected << ' ' << l.p_value << ' ' << l.relative_rmse;
      EXPECT_LT(l.relative_rmse_without_noise, 0.02);
    }
  }
}

TEST(Comparison, SaysThatAFewWalksAreTooFew) {
  const Setting setting(load_stack("sggx_slab"), 40);
  for (const LobeComparison& l : setting.report(Estimator::analog, 500, 1))
    EXPECT_EQ(l.verdict, Verdict::insufficient);
}

TEST(Comparison, TakesNoArrivalsForAgreementWithNextToNothing) {
  // Optical depth 12: single scattering sends some 1e-6 of the light through.
  const Setting setting(spheres("0.5", "12"), 0);
  const auto lobes = setting.report(Estimator::analog, 1000, 1);
  const LobeComparison& through = lobes[lobes.size() - 2];
  ASSERT_FALSE(through.reflected);
  ASSERT_EQ(through.order, Order::one);
  EXPECT_EQ(through.energy_truth[0], 0);
  EXPECT_GT(through.energy_model[0], 0);
  EXPECT_NE(through.verdict, Verdict::differs);
  // An energy of 1e-6 in 1000 walks shows with a chance of 1e-3 at most.
  EXPECT_GT(through.p_value, 0.9);
}

TEST(Comparison, TakesNoArrivalsForADifferenceWhereTheModelHasLight) {
  const Setting setting(spheres("0", "inf"), 0);
  ProjectedLobes model = setting.exact[0];
  for (double& f : model.lobes[Order::all]) f = 0.1 / kPi;
  Simulation simulation(setting.stack, setting.plan, setting.wi, Estimator::analog, kGrid, 1);
  simulation.advance(1000);
  auto lobes = compare(reduce(simulation), &simulation, model, true);
  decide({&lobes.back()});
  EXPECT_EQ(lobes.back().verdict, Verdict::differs);
  EXPECT_TRUE(std::isinf(lobes.back().relative_rmse));
}

TEST(Comparison, ZIsTheDifferenceInStandardErrors) {
  LobeComparison l;
  l.truth = {1, 2, 0};
  l.standard_error = {0.5, 0.25, 0};
  l.model = {2, 1, 1};
  EXPECT_EQ(l.z(), (std::vector<double>{2, -4, 0}));
}

// The exact lobes as a stochastic model finds them: times `factor`, and in each part off by a
// normal number that all cells share, the mean of all parts by `noise` (relative).
ProjectedLobes noisy(const ProjectedLobes& exact, double factor, double noise, std::uint64_t seed) {
  ProjectedLobes model = exact;
  RandomStream stream(seed, 0, StreamPurpose::test);
  double mean = 0;
  for (int part = 0; part < kBatches; ++part) {
    const double u = stream.uniform(), v = stream.uniform();
    const double g = noise * std::sqrt(-2.0 * kBatches * std::log(u)) * std::cos(2 * kPi * v);
    mean += g / kBatches;
    for (auto& lobe : model.parts.emplace_back(exact.lobes))
      for (double& f : lobe) f *= factor * (1 + g);
  }
  for (auto& lobe : model.lobes)
    for (double& f : lobe) f *= factor * (1 + mean);
  return model;
}

// The lobe of order 1 of walks, or of bounds around the exact values, against a noisy model.
LobeComparison judged(const Setting& setting, bool bounded, double factor, std::uint64_t seed) {
  constexpr double kNoise = 0.05;
  Simulation simulation(setting.stack, setting.plan, setting.wi, Estimator::analog, kGrid, seed);
  simulation.advance(bounded ? 1000 : 100000);
  RunResult run = reduce(simulation);
  if (bounded) {
    run.reflected.lobes[0].value = setting.exact[0].lobes[0];
    for (double& bound : run.reflected.lobes[0].standard_error) bound = 1e-6;
  }
  const ProjectedLobes model = noisy(setting.exact[0], factor, kNoise, seed);
  LobeComparison l = compare(run, bounded ? nullptr : &simulation, model, true).front();
  decide({&l});
  return l;
}

TEST(Comparison, DoesNotHoldAStochasticModelsNoiseAgainstIt) {
  const Setting setting(spheres("0.9", "inf"), 40);
  constexpr int kTrials = 60;
  for (const bool bounded : {false, true}) {
    int refused = 0;
    double with = 0, without = 0;
    for (int k = 0; k < kTrials; ++k) {
      const LobeComparison l = judged(setting, bounded, 1, 100 + k);
      EXPECT_EQ(l.order, Order::one);
      refused += l.verdict == Verdict::differs;
      with += l.relative_rmse / kTrials;
      without += l.relative_rmse_without_noise / kTrials;
    }
    EXPECT_LE(refused, most_refusals(kTrials, kReportFalseAlarm)) << bounded;
    // The mean of |g| for normal g of deviation 5 % is 4 %; what exceeds 5 % of it, 0.9 %.
    EXPECT_GT(with, 0.03) << bounded;
    EXPECT_LT(without, 0.025) << bounded;
  }
}

TEST(Comparison, StillFindsAStochasticModelThatIsFarOff) {
  const Setting setting(spheres("0.9", "inf"), 40);
  for (const bool bounded : {false, true}) {
    const LobeComparison l = judged(setting, bounded, 1.5, 1);
    EXPECT_EQ(l.verdict, Verdict::differs) << bounded;
    EXPECT_NEAR(l.relative_rmse_without_noise, 0.5, 0.15) << bounded;
    for (std::size_t k = 0; k < l.model.size(); ++k)
      EXPECT_NEAR(l.model_error[k], 0.05 * 1.5 * setting.exact[0].lobes[0][k],
                  0.3 * 0.05 * 1.5 * setting.exact[0].lobes[0][k]);
  }
}

TEST(Comparison, SplitModelsAddUpToTheWhole) {
  Parameters parameters;
  fill_defaults(find_model("beckmann_diffuse")->parameters, parameters);
  const auto model = find_model("beckmann_diffuse")->make(parameters, nullptr);
  const ProjectedLobes lobes = project(*model, *find_model("beckmann_diffuse"),
                                       direction_from_degrees(60, 0), kGrid, true, 1);
  ASSERT_EQ(lobes.parts.size(), static_cast<std::size_t>(kBatches));
  for (int cell = 0; cell < kGrid.cells(); ++cell) {
    double mean = 0;
    for (const auto& part : lobes.parts) mean += part[Order::all][cell] / kBatches;
    // The parts' cells are quadrature of 4 x 4 points.
    EXPECT_NEAR(mean, lobes.lobes[Order::all][cell], 0.01 * mean) << cell;
  }
}

}  // namespace
}  // namespace lamella
