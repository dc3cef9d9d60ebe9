#pragma once

#include <vector>

#include "phase/stack/builtin_stack.h"

namespace lamella {

/// The built-in stacks with interfaces: coats over media and over closed forms, plates, metals.
[[nodiscard]] std::vector<BuiltinStack> coated_stacks();

}  // namespace lamella
