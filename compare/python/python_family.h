#pragma once

#include <memory>

#include "analytic/model/model.h"

namespace lamella {

/// A Python function with parameters, as `lamella.Family` has it: what is known of it, and how it
/// becomes a model.
struct PythonFamily {
  std::shared_ptr<const ModelInfo> info;
};

}  // namespace lamella
