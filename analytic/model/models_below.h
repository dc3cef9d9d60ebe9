#pragma once

#include <memory>
#include <string>
#include <vector>

#include "analytic/model/model.h"

namespace lamella {

/// The closed forms that may lie below another: those that stand for a surface of their own,
/// without a stack. Their parameters are the upper model's, under a prefix; the albedo stands for
/// every one of them, so it is a parameter of the upper model itself. Copies share the list.
class ModelsBelow {
 public:
  /// `prefix`: of the keys, as "base."; `where`: what the documentation of a key says first, as
  /// "of the base".
  ModelsBelow(const std::vector<ModelInfo>& models, std::string prefix, std::string where);

  [[nodiscard]] const std::vector<ModelInfo>& all() const { return *models_; }
  [[nodiscard]] std::vector<std::string> names() const;

  /// `name` is one of names().
  [[nodiscard]] const ModelInfo& named(const std::string& name) const;

  /// That model's parameters but the albedo, with the prefix.
  [[nodiscard]] std::vector<ParameterInfo> parameters(const std::string& name) const;

  /// That model's own parameters, taken from those of the upper model and filled with defaults.
  /// Throws ParameterError with the key as the upper model has it.
  [[nodiscard]] Parameters values(const std::string& name, const Parameters& upper) const;

 private:
  std::shared_ptr<const std::vector<ModelInfo>> models_;
  std::string prefix_, where_;
};

}  // namespace lamella
