#pragma once

#include <string>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/plan/plan.h"

namespace lamella {

/// One line of `lamella explain`.
struct PlanNote {
  std::string subject;  ///< "colour", "azimuth", ...
  std::string decision;
  std::string reason;
};

[[nodiscard]] std::vector<PlanNote> explain(const Stack& stack, const Plan& plan);

}  // namespace lamella
