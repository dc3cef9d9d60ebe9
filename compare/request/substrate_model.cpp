#include "compare/request/substrate_model.h"

#include <fmt/format.h>

#include <algorithm>

#include "analytic/model/model.h"
#include "phase/stack/stack_file.h"
#include "phase/surface/surface_law.h"

namespace lamella {
namespace {

class ModelLaw : public SurfaceLaw {
 public:
  ModelLaw(std::shared_ptr<const Model> model, bool is_symmetric)
      : model_(std::move(model)), is_symmetric_(is_symmetric) {}

  [[nodiscard]] Rgb eval(Direction wi, Direction wo, RandomStream&) const override {
    return model_->eval(wi, wo);
  }

  // A model's sampler gives the way to the light for a way to the viewer. It takes the light's way
  // here: any density serves, as long as the weight divides by it.
  [[nodiscard]] std::optional<Sample> sample(Direction wi, RandomStream& stream) const override {
    const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
    const auto wo = model_->sample(wi, u1, u2, u3);
    if (!wo || !(wo->z > 0)) return std::nullopt;
    const double density = model_->pdf(*wo, wi);
    if (!(density > 0)) return std::nullopt;
    return Sample{*wo, (wo->z / density) * model_->eval(wi, *wo)};
  }

  [[nodiscard]] double density(Direction wi, Direction wo) const override {
    return model_->pdf(wo, wi);
  }

  [[nodiscard]] bool is_symmetric_about_z() const override { return is_symmetric_; }

 private:
  std::shared_ptr<const Model> model_;
  bool is_symmetric_;
};

// What the closed form of micrograins takes below them.
const std::vector<std::string>& surface_models() {
  return find(find_model("micrograin")->parameters, "bulk")->choices;
}

// Closed forms that may lie below differ along x and y by this parameter alone; 0: as along x.
bool tells_x_from_y(const Parameters& p) {
  if (!p.has("roughness_y")) return false;
  return p.number("roughness_y") > 0 && p.number("roughness_y") != p.number("roughness");
}

}  // namespace

Stack with_surface_model(Stack stack) {
  if (!stack.substrate || stack.substrate->model.empty() ||
      (stack.substrate->model == kConductor && stack.substrate->law))
    return stack;
  Substrate& s = *stack.substrate;
  const std::vector<std::string>& allowed = surface_models();
  if (std::find(allowed.begin(), allowed.end(), s.model) == allowed.end()) {
    std::vector<std::string> names{"lambert", "black"};
    if (!stack.grains()) names.push_back(kConductor);
    for (const std::string& name : allowed)
      if (name != names.front()) names.push_back(name);
    const std::string hint = suggestion(s.model, names);
    throw StackFileError(fmt::format("{}: substrate: key \"bsdf\": found \"{}\"{}; allowed: {}",
                                     s.where.at("bsdf"), s.model, hint.empty() ? "" : ", " + hint,
                                     listed(names)));
  }
  const ModelInfo* info = find_model(s.model);
  Parameters complete;
  for (const auto& [key, value] : s.parameters.all()) {
    const ParameterInfo* parameter = find(info->parameters, key);
    if (!parameter) {
      std::vector<std::string> names;
      for (const ParameterInfo& p : info->parameters) names.push_back(p.name);
      const std::string hint = suggestion(key, names);
      throw StackFileError(fmt::format("{}: substrate: key \"{}\": unknown in {}{}; allowed: {}",
                                       s.where.at(key), key, s.model,
                                       hint.empty() ? "" : ", " + hint, listed(names)));
    }
    try {
      complete.set(key, checked(*parameter, value));
    } catch (const ParameterError& error) {
      throw StackFileError(fmt::format("{}: substrate: {}", s.where.at(key), error.what()));
    }
  }
  fill_defaults(info->parameters, complete);
  try {
    s.law = std::make_shared<ModelLaw>(info->make(complete, nullptr), !tells_x_from_y(complete));
  } catch (const ParameterError& error) {
    throw StackFileError(fmt::format("{}: substrate: {}", s.where.at("bsdf"), error.what()));
  }
  s.parameters = std::move(complete);
  return stack;
}

}  // namespace lamella
