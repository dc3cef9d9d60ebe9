#include "compare/fit/fitted_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "analytic/layered/spongecake.h"
#include "compare/fit/least_squares.h"
#include "compare/fit/spongecake_truth.h"
#include "compare/request/errors.h"
#include "compare/request/stack_parameters.h"

namespace lamella {
namespace {

// Why the lobes cannot be fitted; empty if they can.
std::string refusal(const Stack& stack) {
  if (!has_least_squares()) return "this build has no Ceres";
  if (!is_spongecake_stack(stack)) return "not a stack of SpongeCake's";
  return {};
}

}  // namespace

ModelRequest with_fitted_lobes(ModelRequest request, const Stack& stack) {
  if (request.name != "spongecake") return request;
  std::string lobes;
  bool has_lobes = false;
  for (const auto& [key, value] : request.values) {
    if (key == "lobes") lobes = value;
    has_lobes = has_lobes || (key != "lobes" && key != "stack");
  }
  if (has_lobes) {
    if (lobes.empty()) request.values.emplace_back("lobes", "given");
    return request;
  }
  const bool open = lobes.empty() || lobes == "auto";
  if (!open && lobes != "fit" && lobes != "network") return request;
  const std::string source = lobes.empty() ? "default" : "given";
  const auto set = [&](const std::string& key, const std::string& value, const std::string& from) {
    std::erase_if(request.values, [&](const auto& v) { return v.first == key; });
    request.values.emplace_back(key, value);
    request.sources[key] = from;
  };
  const auto take = [&](const std::string& text, const std::string& from) {
    for (const auto& [key, value] : parse_model_request(text).values) set(key, value, from);
    set("lobes", from, source);
    return request;
  };
  const std::string no_network = why_no_network(stack);
  if (no_network.empty() && (open || lobes == "network"))
    return take(lobes_request(stack, predicted_lobes(stack)), "network");
  if (lobes == "network")
    throw UsageError(fmt::format(
        "spongecake: key \"lobes\": found \"network\" for {}: {}; allowed: fit, none, auto, or the "
        "keys of the lobes",
        stack.name, no_network));
  std::string why_not = refusal(stack);
  if (why_not.empty()) {
    try {
      request = take(fit_spongecake_to_truth(stack, {}).fit.request, "fit");
      if (!no_network.empty())
        request.sources["lobes"] = fmt::format("{}; no network: {}", source, no_network);
      return request;
    } catch (const std::invalid_argument& error) {
      why_not = error.what();
    }
  }
  if (!open)
    throw UsageError(fmt::format(
        "spongecake: key \"lobes\": found \"fit\" for {}: {}; allowed: none, or the keys of the "
        "lobes",
        stack.name, why_not));
  set("lobes", "none", fmt::format("not fitted: {}; no network: {}", why_not, no_network));
  return request;
}

std::vector<BoundModel> fitted_models_for(const std::vector<ModelRequest>& requests,
                                          const Stack& stack) {
  std::vector<BoundModel> bound;
  for (const ModelRequest& request : requests_for(requests, stack))
    bound.push_back(model_for(with_fitted_lobes(request, stack), stack));
  return bound;
}

PlacedRequest placed_request(const ModelRequest& request, const Stack& middle) {
  PlacedRequest placed{request, with_fitted_lobes(request, middle), false};
  if (request.name != "spongecake") return placed;
  // Of the keys, `lobes` and `stack` leave the lobes open.
  std::string lobes = "auto";
  for (const auto& [key, value] : request.values) {
    if (key == "lobes") lobes = value;
    if (key != "lobes" && key != "stack") lobes = "given";
  }
  placed.predicts = lobes == "auto" || lobes == "network";
  return placed;
}

BoundModel model_at(const PlacedRequest& request, const Stack& place) {
  const bool predicted = request.predicts && why_no_network(place).empty();
  return model_for(predicted ? with_fitted_lobes(request.own, place) : request.of_middle, place);
}

}  // namespace lamella
