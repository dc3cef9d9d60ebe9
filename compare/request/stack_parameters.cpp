#include "compare/request/stack_parameters.h"

#include <fmt/format.h>

#include <algorithm>

#include "analytic/catalogue/model_plugin.h"
#include "compare/request/errors.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

const ParameterValue* value_of(const Layer& layer, const std::string& key, ParameterValue& albedo) {
  if (key == "albedo") {
    albedo = layer.albedo;
    return &albedo;
  }
  return layer.parameters.has(key) ? &layer.parameters.at(key) : nullptr;
}

// What all layers agree on, or why nothing is taken; neither where no layer has the key.
struct Common {
  std::optional<ParameterValue> value{};
  std::string refusal{};
};

Common common_value(const Stack& stack, const std::string& key) {
  Common common;
  std::vector<std::string> found;
  std::size_t have = 0;
  for (const Layer& layer : stack.layers) {
    ParameterValue albedo;
    const ParameterValue* value = value_of(layer, key, albedo);
    if (!value) continue;
    ++have;
    if (std::find(found.begin(), found.end(), to_text(*value)) != found.end()) continue;
    found.push_back(to_text(*value));
    common.value = *value;
  }
  if (have == 0) return {};
  if (found.size() > 1) return {{}, fmt::format("the layers have {}", listed(found))};
  if (have < stack.layers.size())
    return {{}, fmt::format("{} of {} layers have {}", have, stack.layers.size(), found[0])};
  return common;
}

// What a substrate is to a model that has a surface below it.
Common below(const Stack& stack, const std::string& key) {
  if (!stack.substrate || !key.starts_with("bulk")) return {};
  const Substrate& substrate = *stack.substrate;
  if (key == "bulk") return {substrate.model.empty() ? "lambert" : substrate.model, {}};
  const std::string own = key.substr(std::min(key.size(), std::string("bulk_").size()));
  if (!substrate.model.empty())
    return substrate.parameters.has(own) ? Common{substrate.parameters.at(own), {}} : Common{};
  return own == "albedo" ? Common{substrate.albedo, {}} : Common{};
}

bool is_given(const ModelRequest& request, const std::string& key) {
  return std::any_of(request.values.begin(), request.values.end(),
                     [&](const auto& v) { return v.first == key; });
}

}  // namespace

ModelRequest with_stack_parameters(ModelRequest request, const ModelInfo& info,
                                   const Stack& stack) {
  const ModelRequest asked = request;
  const auto take = [&](const std::string& key, const ParameterValue& value,
                        const std::string& source) {
    request.values.emplace_back(key, request_value(value));
    request.sources[key] = source;
  };
  const std::string source =
      stack.layers.size() > 1 ? fmt::format("stack: all {} layers", stack.layers.size()) : "stack";
  if (info.applies_to)
    if (const auto from_stack = info.applies_to(stack)) {
      for (const auto& [key, value] : from_stack->all())
        if (!is_given(asked, key)) take(key, value, "stack");
      return request;
    }
  // What a choice selects may be had from the stack too, once the choice is made.
  const auto take_common = [&](const std::vector<ParameterInfo>& infos) {
    for (const ParameterInfo& p : infos) {
      if (is_given(request, p.name)) continue;
      Common common = common_value(stack, p.name);
      const bool of_layers = common.value.has_value();
      if (!common.value && common.refusal.empty()) common = below(stack, p.name);
      if (common.value) {
        try {
          (void)checked(p, *common.value);
          take(p.name, *common.value, of_layers ? source : "stack: substrate");
          continue;
        } catch (const ParameterError&) {
          common.refusal = fmt::format("the stack has {}, allowed: {}", to_text(*common.value),
                                       allowed_values(p));
        }
      }
      if (!common.refusal.empty()) request.sources[p.name] = "default; " + common.refusal;
    }
  };
  take_common(info.parameters);
  if (!info.selector.empty()) take_common(parameters_of(info, request));
  return request;
}

ModelRequest without_stack_key(ModelRequest request, const Stack& of) {
  const ModelInfo* info = find_or_load_model(request.name);
  if (!info || !info->needs_stack) return request;
  for (const auto& [key, value] : request.values) {
    // Standard input can be read once.
    if (key != "stack" || value == "-") continue;
    if (to_toml(load_stack(value)) != to_toml(of))
      throw UsageError(
          fmt::format("{}: key \"stack\": found \"{}\", which is not {}; allowed: the stack that "
                      "the command is about, or no such key",
                      request.name, value, of.name));
  }
  std::erase_if(request.values, [](const auto& v) { return v.first == "stack"; });
  return request;
}

BoundModel model_for(const ModelRequest& request, const Stack& stack) {
  ModelRequest whole = without_stack_key(request, stack);
  const ModelInfo* info = find_or_load_model(request.name);
  if (info) whole = with_stack_parameters(std::move(whole), *info, stack);
  return bind_model(whole, &stack);
}

std::vector<BoundModel> models_for(const std::vector<ModelRequest>& requests, const Stack& stack) {
  std::vector<BoundModel> bound;
  for (const ModelRequest& request : requests_for(requests, stack))
    bound.push_back(model_for(request, stack));
  return bound;
}

}  // namespace lamella
