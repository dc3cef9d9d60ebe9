#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// A shared object that is refused as a model. what() names file, value found and values allowed.
struct ModelPluginError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Whether a model's name is the path of a shared object: it has a slash or ends with ".so".
[[nodiscard]] bool is_plugin_path(std::string_view name);

/// The model in a shared object (analytic/catalogue/lamella_model.h says what it must export). It
/// stays loaded; the same path gives the same entry. Throws ModelPluginError. Its values are
/// checked at every evaluation: one that is not finite, or negative, throws std::domain_error with
/// the pair at which it was found.
[[nodiscard]] const ModelInfo& load_model_plugin(const std::string& path);

/// The built-in model of that name or the one in that shared object; nullptr if no built-in model
/// has the name.
[[nodiscard]] const ModelInfo* find_or_load_model(const std::string& name);

}  // namespace lamella
