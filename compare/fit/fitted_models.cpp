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
  if (stack.layers.size() > static_cast<std::size_t>(kSpongecakeLayers))
    return "more layers than are fitted";
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
  if (!lobes.empty() && lobes != "fitted") return request;
  const auto set = [&](const std::string& key, const std::string& value,
                       const std::string& source) {
    std::erase_if(request.values, [&](const auto& v) { return v.first == key; });
    request.values.emplace_back(key, value);
    request.sources[key] = source;
  };
  std::string why_not = refusal(stack);
  if (why_not.empty()) {
    try {
      const SpongecakeTruth fitted = fit_spongecake_by_walks(stack, {});
      for (const auto& [key, value] : parse_model_request(fitted.fit.request).values)
        set(key, value, "fitted");
      set("lobes", "fitted", lobes.empty() ? "default" : "given");
      return request;
    } catch (const std::invalid_argument& error) {
      why_not = error.what();
    }
  }
  if (!lobes.empty())
    throw UsageError(fmt::format(
        "spongecake: key \"lobes\": found \"fitted\" for {}: {}; allowed: none, or the keys of the "
        "lobes",
        stack.name, why_not));
  set("lobes", "none", "not fitted: " + why_not);
  return request;
}

std::vector<BoundModel> fitted_models_for(const std::vector<ModelRequest>& requests,
                                          const Stack& stack) {
  std::vector<BoundModel> bound;
  for (const ModelRequest& request : requests_for(requests, stack))
    bound.push_back(model_for(with_fitted_lobes(request, stack), stack));
  return bound;
}

}  // namespace lamella
