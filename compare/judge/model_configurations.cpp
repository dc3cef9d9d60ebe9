#include "compare/judge/model_configurations.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "compare/fit/fitted_models.h"
#include "compare/judge/parameter_steps.h"
#include "compare/request/errors.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

constexpr int kSteps = 3;
// Draws of random corners without a new one, after which there are taken to be no more.
constexpr int kVainDraws = 64;

// A parameter that varies, the texts of its values in the order of its range.
struct Axis {
  std::string key;
  std::vector<std::string> values;
  bool is_shape = false;
};

std::vector<Axis> axes_of(const ModelInfo& info, const ModelRequest& request) {
  std::vector<Axis> axes;
  for (const ParameterInfo& p : parameters_of(info, request)) {
    const bool given = std::any_of(request.values.begin(), request.values.end(),
                                   [&](const auto& v) { return v.first == p.name; });
    const bool below = !info.selected_prefix.empty() && p.name.starts_with(info.selected_prefix);
    if (given || below || p.name == info.selector) continue;
    Axis axis{p.name, {}, is_shape(p) && !is_white(p)};
    if (axis.is_shape)
      for (const double x : steps_of_range(p, kSteps)) axis.values.push_back(to_text(x));
    else if (p.kind == ParameterKind::choice)
      axis.values = p.choices;
    else if (is_white(p))
      axis.values = p.kind == ParameterKind::color
                        ? std::vector<std::string>{"1", "0", "0.9,0.5,0.1"}
                        : std::vector<std::string>{"1", "0"};
    if (!axis.values.empty()) axes.push_back(std::move(axis));
  }
  return axes;
}

}  // namespace

std::string to_request(const ModelRequest& request) {
  std::string text = request.name;
  for (const auto& [key, value] : request.values) text += fmt::format(",{}={}", key, value);
  return text;
}

std::vector<ModelRequest> configurations_of(const ModelInfo& info, const ModelRequest& request,
                                            int most, std::uint64_t seed) {
  std::vector<ModelRequest> list{request};
  const auto add = [&](ModelRequest next) {
    const std::string text = to_request(next);
    const bool is_new = std::none_of(list.begin(), list.end(), [&](const ModelRequest& other) {
      return to_request(other) == text;
    });
    if (is_new && list.size() < static_cast<std::size_t>(most)) list.push_back(std::move(next));
    return is_new;
  };
  const std::vector<Axis> axes = axes_of(info, request);
  ModelRequest white = request;
  for (const ParameterInfo& p : parameters_of(info, request)) {
    const bool given = std::any_of(request.values.begin(), request.values.end(),
                                   [&](const auto& v) { return v.first == p.name; });
    if (is_white(p) && !given) white.values.emplace_back(p.name, "1");
  }
  add(white);
  const auto with = [&](ModelRequest changed, const Axis& axis, std::size_t step) {
    const auto there = std::find_if(changed.values.begin(), changed.values.end(),
                                    [&](const auto& v) { return v.first == axis.key; });
    if (there != changed.values.end())
      there->second = axis.values[step];
    else
      changed.values.emplace_back(axis.key, axis.values[step]);
    return changed;
  };
  for (const std::size_t step : {std::size_t{0}, std::size_t{2}, std::size_t{1}}) {
    ModelRequest all = white;
    for (const Axis& axis : axes)
      if (axis.is_shape) all = with(all, axis, step);
    add(all);
  }
  for (const Axis& axis : axes)
    for (std::size_t k = 0; k < axis.values.size(); ++k) add(with(white, axis, k));
  if (axes.empty()) return list;
  RandomStream stream(seed, 0, StreamPurpose::model);
  for (int vain = 0; vain < kVainDraws && list.size() < static_cast<std::size_t>(most); ++vain) {
    ModelRequest corner = white;
    for (const Axis& axis : axes)
      corner = with(
          corner, axis,
          static_cast<std::size_t>(stream.uniform() * static_cast<double>(axis.values.size())));
    if (add(corner)) vain = -1;
  }
  return list;
}

std::vector<CheckConfiguration> configurations_to_check(const ModelInfo& info,
                                                        const ModelRequest& request,
                                                        const std::optional<Stack>& stack, int most,
                                                        std::uint64_t seed) {
  const Stack* of = stack ? &*stack : nullptr;
  const auto first =
      std::make_shared<BoundModel>(bind_model(of ? with_fitted_lobes(request, *of) : request, of));
  std::vector<CheckConfiguration> list{
      {to_request(request),
       [first] { return std::shared_ptr<const Model>(first, first->model.get()); }}};
  if (of) return list;
  const std::vector<ModelRequest> all = configurations_of(info, request, most, seed);
  for (std::size_t k = 1; k < all.size(); ++k)
    list.push_back({to_request(all[k]), [next = all[k]]() -> std::shared_ptr<const Model> {
                      try {
                        return bind_model(next, nullptr).model;
                      } catch (const UsageError&) {
                        return nullptr;
                      }
                    }});
  return list;
}

}  // namespace lamella
