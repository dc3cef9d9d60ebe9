#pragma once

#include "analytic/model.h"

namespace lamella {

/// SpongeCake's single scattering: the generic single scattering of a stack whose layers are all
/// SGGX mirror flakes or Henyey-Greenstein particles, with the paper's importance sampling.
/// Wang et al. 2022, "SpongeCake: A Layered Microflake Surface Appearance Model", section 4.
[[nodiscard]] ModelInfo spongecake_model();

/// Whether SpongeCake describes the stack.
[[nodiscard]] bool is_spongecake_stack(const Stack& stack);

}  // namespace lamella
