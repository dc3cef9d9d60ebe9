#pragma once

#include <optional>
#include <string>
#include <vector>

#include "phase/stack/key_reader.h"
#include "phase/stack/stack.h"

namespace lamella {

/// Every key of a layer that stands beside "grid", and "grid" itself.
[[nodiscard]] const std::vector<std::string>& grid_keys();

/// The density grid of a layer, if the layer names one. `where` is the layer's name in errors,
/// `thickness` [mm] the layer's. Throws StackFileError.
[[nodiscard]] std::optional<GridReference> read_grid(const KeyReader& keys,
                                                     const toml::table& table,
                                                     const std::string& where, double thickness);

}  // namespace lamella
