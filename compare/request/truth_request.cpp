#include "compare/request/truth_request.h"

#include <fmt/format.h>

#include "compare/request/errors.h"

namespace lamella {

std::string to_text(WalkSetting setting) {
  switch (setting) {
    case WalkSetting::walks:
      return "--walks";
    case WalkSetting::target_error:
      return "--target-error";
    case WalkSetting::max_order:
      return "--max-order";
    case WalkSetting::thin_from:
      return "--thin-from";
    case WalkSetting::seconds:
      break;
  }
  return "--time";
}

std::vector<Direction> default_directions() {
  std::vector<Direction> directions;
  for (const double theta : {0.0, 30.0, 60.0, 80.0})
    directions.push_back(direction_from_degrees(theta, 0));
  return directions;
}

std::string estimator_asked(const TruthRequest& request) {
  return request.estimator ? to_text(*request.estimator) : "auto";
}

std::optional<Estimator> parse_estimator(const std::string& text) {
  if (text == "auto") return std::nullopt;
  for (const Estimator e : {Estimator::analog, Estimator::next_event, Estimator::deterministic})
    if (to_text(e) == text) return e;
  throw UsageError(fmt::format(
      "estimator: found \"{}\"; allowed: auto, analog, next-event, deterministic", text));
}

Plan plan_of(const TruthRequest& request) {
  Plan plan = make_plan(request.stack, request.limits);
  plan.isa = request.isa;
  return plan;
}

}  // namespace lamella
