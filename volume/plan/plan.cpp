#include "volume/plan/plan.h"

#include <algorithm>

#include "volume/plan/longest_walk.h"
#include "volume/voxels/density_grid.h"

namespace lamella {

namespace {

void take_grids(std::vector<std::shared_ptr<const DensityGrid>> grids, Plan& plan) {
  plan.grids = std::move(grids);
  for (const auto& grid : plan.grids)
    if (grid)
      plan.warnings.insert(plan.warnings.end(), grid->warnings().begin(), grid->warnings().end());
}

// Everything but the grids.
Plan bare_plan(const Stack& stack, const WalkLimits& limits) {
  Plan plan{.channels = 3,
            .folded = false,
            .single_layer = false,
            .uniform_medium = false,
            .boundaries = stack.has_boundaries(),
            .rough_boundaries = stack.has_rough_interfaces(),
            .transmits = stack.is_open_below(),
            .max_order = limits.max_order.value_or(kMaxOrder),
            .sampling = limits.sampling,
            .layers = {},
            .grids = {},
            .warnings = {}};
  if (stack.grains()) return plan;
  for (int k = 0; k < static_cast<int>(stack.layers.size()); ++k)
    if (stack.has_grid() ? stack.layers[k].thickness > 0 : stack.layers[k].depth() > 0)
      plan.layers.push_back(k);
  if (stack.has_grid()) return plan;
  plan.order_one = limits.order_one;
  plan.thinning = limits.thinning.value_or(thinning_for(stack, plan.layers, plan.max_order));
  if (!limits.max_order && plan.thinning.is_on()) plan.max_order = kThinnedMaxOrder;
  return plan;
}

}  // namespace

Plan make_plan(const Stack& stack, const WalkLimits& limits) {
  return make_plan(
      stack, limits,
      stack.has_grid() ? load_grids(stack) : std::vector<std::shared_ptr<const DensityGrid>>());
}

Plan make_plan(const Stack& stack, const WalkLimits& limits,
               std::vector<std::shared_ptr<const DensityGrid>> grids) {
  Plan plan = bare_plan(stack, limits);
  if (stack.has_grid()) {
    take_grids(std::move(grids), plan);
    const bool grey = std::all_of(plan.grids.begin(), plan.grids.end(),
                                  [](const auto& grid) { return !grid || grid->is_grey(); });
    plan.channels = stack.is_grey() && grey ? 1 : 3;
    return plan;
  }
  plan.channels = stack.is_grey() ? 1 : 3;
  plan.folded = stack.is_symmetric_about_z();
  plan.single_layer = plan.layers.size() == 1;
  plan.uniform_medium =
      !plan.layers.empty() && std::all_of(plan.layers.begin(), plan.layers.end(), [&](int k) {
        return stack.layers[k].medium.index() == stack.layers[plan.layers[0]].medium.index();
      });
  return plan;
}

Plan general_plan(const Stack& stack, const WalkLimits& limits) {
  Plan plan = bare_plan(stack, limits);
  if (stack.has_grid()) take_grids(load_grids(stack), plan);
  return plan;
}

}  // namespace lamella
