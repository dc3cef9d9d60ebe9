#pragma once

#include <vector>

#include "compare/reproduce/reproduction.h"

namespace lamella {

/// Lobes of SpongeCake's multiple scattering (Wang et al. 2022, figures 8 to 13 and 20 to 22):
/// truth, network, fit.
[[nodiscard]] const std::vector<Reproduction>& spongecake_lobe_figures();

}  // namespace lamella
