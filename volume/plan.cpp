#include "volume/plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "volume/lane_run.h"

namespace lamella {

std::string to_text(Estimator estimator) {
  switch (estimator) {
    case Estimator::analog:
      return "analog";
    case Estimator::next_event:
      return "next-event";
    case Estimator::deterministic:
      break;
  }
  return "deterministic";
}

Plan make_plan(const Stack& stack, std::uint64_t max_order) {
  Plan plan = general_plan(stack, max_order);
  plan.channels = stack.is_grey() ? 1 : 3;
  plan.folded = stack.is_symmetric_about_z();
  plan.single_layer = plan.layers.size() == 1;
  plan.uniform_medium =
      !plan.layers.empty() && std::all_of(plan.layers.begin(), plan.layers.end(), [&](int k) {
        return stack.layers[k].medium.index() == stack.layers[plan.layers[0]].medium.index();
      });
  return plan;
}

Plan general_plan(const Stack& stack, std::uint64_t max_order) {
  Plan plan{.channels = 3,
            .folded = false,
            .single_layer = false,
            .uniform_medium = false,
            .transmits = stack.is_open_below(),
            .max_order = max_order,
            .layers = {}};
  for (int k = 0; k < static_cast<int>(stack.layers.size()); ++k)
    if (stack.layers[k].depth() > 0) plan.layers.push_back(k);
  return plan;
}

std::vector<PlanNote> explain(const Stack& stack, const Plan& plan) {
  std::vector<PlanNote> notes;
  notes.push_back(
      plan.channels == 1
          ? PlanNote{"colour", "one weight channel", "every albedo, f0 and substrate is grey"}
          : PlanNote{"colour", "three weight channels, one walk",
                     "an albedo, f0 or substrate differs between channels"});
  notes.push_back(
      plan.folded
          ? PlanNote{"azimuth", "phi folded onto [0, 180]; the incident azimuth does not matter",
                     "every layer is symmetric about the normal"}
          : PlanNote{"azimuth", "the whole circle of phi", "a layer is not symmetric about z"});
  const std::size_t empty = stack.layers.size() - plan.layers.size();
  notes.push_back({"layers",
                   plan.layers.empty() ? "none is walked"
                   : plan.single_layer
                       ? "one: no layer is looked up"
                       : fmt::format("{}: free flight crosses them exactly", plan.layers.size()),
                   empty ? fmt::format("{} of depth 0 left out", empty) : "all have depth"});
  if (plan.uniform_medium)
    notes.push_back({"medium", "kernel of " + stack.layers[plan.layers[0]].medium_name,
                     "all layers hold the same kind of medium"});
  else
    notes.push_back({"medium", "medium looked up at every event", "layers hold different media"});
  if (stack.is_half_space())
    notes.push_back({"below", "no transmission tallies", "the last layer is infinite"});
  else if (stack.substrate)
    notes.push_back(
        stack.substrate->albedo.max() > 0
            ? PlanNote{"below", "Lambertian reflection, no transmission tallies",
                       "an opaque substrate; its reflection counts as an order"}
            : PlanNote{"below", "absorbed, no transmission tallies", "a black substrate"});
  else
    notes.push_back({"below", "transmission tallies; light from below is allowed",
                     "finite layers without a substrate"});
  const bool fresnel = std::any_of(stack.layers.begin(), stack.layers.end(),
                                   [](const Layer& l) { return l.f0 != Rgb(1); });
  notes.push_back(fresnel ? PlanNote{"Fresnel", "Schlick's factor at each event", "an f0 below 1"}
                          : PlanNote{"Fresnel", "left out", "no f0 below 1"});
  const double one_sided = stack.one_sidedness();
  const bool tilted = !stack.is_reciprocal();
  notes.push_back(
      tilted ? PlanNote{"reciprocity", "not claimed", "a one-sided layer's mean normal is tilted"}
      : one_sided != 0
          ? PlanNote{"reciprocity", "of reflection",
                     fmt::format("one-sided flakes: transmission from above is exp(-{:.6g}) times "
                                 "that from below",
                                 one_sided)}
          : PlanNote{"reciprocity", "of reflection and transmission", "all media are two-sided"});
  notes.push_back({"orders", fmt::format("1, 2, 3, 4+; cut after {} events", plan.max_order),
                   stack.is_half_space() ? "a half space keeps some walks for ever: their share is "
                                           "reported as unresolved"
                                         : "what is cut is reported as unresolved"});
  const auto scalar = why_not_lanes(stack, plan);
  notes.push_back(
      scalar ? PlanNote{"instructions", "scalar kernel, double precision", *scalar}
             : PlanNote{"instructions",
                        fmt::format("{} lanes, single precision; next-event cells: scalar kernel, "
                                    "double precision",
                                    to_text(plan.isa)),
                        "one grey layer whose depth and medium float resolves; the first collision "
                        "is forced "
                        "where its chance is below 5 %"});
  return notes;
}

}  // namespace lamella
