// Order 1 of the walk against the closed form: every medium, reflection and transmission, one and
// three layers, with and without a substrate, from above and below, both estimators. Each
// comparison takes the correlation between cells into account (compare/judge/comparison.h).
#include <gtest/gtest.h>

#include "analytic/layered/single_scattering_model.h"
#include "compare/judge/comparison.h"
#include "tests/volume/run/stacks.h"

namespace lamella {
namespace {

using testing::every_medium;
using testing::layer;
using testing::stack_from;

std::vector<Stack> stacks_with(const std::string& medium) {
  const std::string thin = medium + "\nalbedo = 0.8\nthickness = ";
  const std::string one = layer(thin + "1");
  const std::string three = layer("medium = 'henyey_greenstein'\ng = 0.3\nthickness = 0.3") +
                            layer(thin + "0.7") +
                            layer("medium = 'sggx'\nroughness = 0.6\nthickness = 0.4");
  const std::string substrate = "[substrate]\nalbedo = 0.5\n";
  return {stack_from(one), stack_from(three), stack_from(one + substrate),
          stack_from(three + substrate)};
}

// p-values of order 1 of a stack, both sides and both estimators.
std::vector<double> p_values(const Stack& stack, Direction wi) {
  const ModelInfo& info = *find_model("single_scattering");
  const auto model = info.make({}, &stack);
  const Plan plan = make_plan(stack);
  const CellGrid grid{6, 8, plan.folded};
  std::vector<double> p;
  for (const bool reflected : {true, false}) {
    if (!reflected && !stack.is_open_below()) continue;
    const bool up = (wi.z > 0) == reflected;
    const ProjectedLobes projected = project(*model, info, wi, grid, up, plan.channels);
    for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
      Simulation truth(stack, plan, wi, estimator, grid, 3);
      truth.advance(testing::soaked(estimator == Estimator::analog ? 60000 : 13000));
      for (const LobeComparison& l : compare(reduce(truth), &truth, projected, reflected))
        if (l.order == Order::one) p.push_back(l.p_value);
    }
  }
  return p;
}

TEST(OrderOne, OfTheWalkMatchesTheClosedFormForEveryMedium) {
  std::vector<double> all;
  for (const std::string& medium : every_medium())
    for (const Stack& stack : stacks_with(medium))
      for (const double theta : {65.0, 130.0}) {
        if (theta > 90 && !stack.is_open_below()) continue;
        for (const double p : p_values(stack, direction_from_degrees(theta, 25))) {
          EXPECT_GT(p, testing::test_level())
              << medium << ", layers " << stack.layers.size() << ", theta " << theta;
          all.push_back(p);
        }
      }
  // The p-values are those of true hypotheses: few are small. (They are conservative: twice the
  // smaller of two, one of them by Bonferroni's bound.)
  const auto below = [&](double level) {
    return static_cast<double>(
        std::count_if(all.begin(), all.end(), [&](double p) { return p < level; }));
  };
  const double n = static_cast<double>(all.size());
  EXPECT_GT(n, 200);
  for (const double level : {0.01, 0.05, 0.2})
    EXPECT_LT(below(level), n * level + testing::allowed_z() * std::sqrt(n * level * (1 - level)));
  EXPECT_GT(below(0.5), 0.1 * n);  // and they do vary
}

}  // namespace
}  // namespace lamella
