#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "compare/nearest/free_parameters.h"
#include "phase/stack/stack.h"

namespace lamella {

/// A stack of which some numbers are free. Their keys are paths as `sweep --set` has them
/// ("layer.0.roughness", "substrate.albedo").
struct ParametricStack {
  Stack stack;
  std::vector<FreeNumber> free;

  /// Its stack file with the numbers at scaled values, twelve digits each.
  [[nodiscard]] std::string toml(std::span<const double> scaled) const;
  /// Throws StackFileError where the values are not allowed together.
  [[nodiscard]] Stack at(std::span<const double> scaled) const;
};

/// Reads PATH=FROM:TO or PATH=FROM:TO:log, each a number that is free between two values; a search
/// begins with the stack's own value where that is between them, else in the middle. A colour
/// (albedo, f0, eta, k) has a number per channel where the target has three. Throws UsageError for
/// what leads nowhere, ends that the stack's reader refuses, and a path that is there twice.
[[nodiscard]] ParametricStack parametric_stack(const Stack& stack,
                                               const std::vector<std::string>& vary, int channels);

}  // namespace lamella
