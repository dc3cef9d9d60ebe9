#include "analytic/model/models_below.h"

#include <algorithm>
#include <iterator>

namespace lamella {

ModelsBelow::ModelsBelow(const std::vector<ModelInfo>& models, std::string prefix,
                         std::string where)
    : prefix_(std::move(prefix)), where_(std::move(where)) {
  auto below = std::make_shared<std::vector<ModelInfo>>();
  // A stack below would be a layer of its own.
  std::copy_if(models.begin(), models.end(), std::back_inserter(*below),
               [](const ModelInfo& info) { return !info.needs_stack; });
  models_ = std::move(below);
}

std::vector<std::string> ModelsBelow::names() const {
  std::vector<std::string> names;
  for (const ModelInfo& info : *models_) names.push_back(info.name);
  return names;
}

const ModelInfo& ModelsBelow::named(const std::string& name) const {
  return *std::find_if(models_->begin(), models_->end(),
                       [&](const ModelInfo& info) { return info.name == name; });
}

std::vector<ParameterInfo> ModelsBelow::parameters(const std::string& name) const {
  std::vector<ParameterInfo> list;
  for (ParameterInfo p : named(name).parameters) {
    if (p.name == "albedo") continue;
    p.name = prefix_ + p.name;
    p.doc = where_ + ": " + p.doc;
    list.push_back(std::move(p));
  }
  return list;
}

Parameters ModelsBelow::values(const std::string& name, const Parameters& upper) const {
  const ModelInfo& model = named(name);
  Parameters below;
  for (ParameterInfo named : model.parameters) {
    const std::string own = named.name;
    named.name = prefix_ + own;
    if (upper.has(named.name)) below.set(own, checked(named, upper.at(named.name)));
  }
  fill_defaults(model.parameters, below);
  return below;
}

}  // namespace lamella
