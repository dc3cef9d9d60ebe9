#pragma once

#include <string>
#include <vector>

#include "compare/reproduce/reproduction.h"

namespace lamella {

/// Every published figure that can be made again, paper by paper. A new one is a function of a
/// paper's header (eon_figures.h, ...) and a line of the list beside it.
[[nodiscard]] const std::vector<Reproduction>& reproductions();

/// The entry with that name, or the one that makes the figure of that name with its own; or
/// nullptr.
[[nodiscard]] const Reproduction* find_reproduction(const std::string& name);

}  // namespace lamella
