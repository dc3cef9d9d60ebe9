#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>

#include "compare/request/model_request.h"

namespace lamella {

/// A model as Python holds it: a closed form with its parameters, a Python function, or a measured
/// material.
struct PythonModel {
  std::shared_ptr<const ModelInfo> own_info{};  ///< of what no catalogue has
  pybind11::object function{};                  ///< or none
  std::shared_ptr<const Model> measured{};      ///< or none
  std::optional<Stack> stack{};                 ///< of a model that was built from one
  BoundModel bound;
  int channels = 1;

  [[nodiscard]] bool is_function() const { return static_cast<bool>(function); }
};

/// The model once more: what `compare_stack` takes for its own. The Python object must outlive it.
[[nodiscard]] BoundModel copy_of(const PythonModel& model);

}  // namespace lamella
