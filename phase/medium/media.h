#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "phase/medium/medium.h"
#include "phase/parameters/parameters.h"

namespace lamella {

/// A medium as stack files and `lamella media` know it.
struct MediumInfo {
  std::string name;
  std::string doc;
  std::string source;
  std::vector<ParameterInfo> parameters;  ///< its own keys, beside albedo, thickness and density
  /// Builds the medium from checked parameters and completes them (defaults that depend on others,
  /// so that an echo shows what was used). Throws ParameterError.
  std::function<Medium(Parameters&)> make;
};

[[nodiscard]] const std::vector<MediumInfo>& media();

/// The entry with that name, or nullptr.
[[nodiscard]] const MediumInfo* find_medium(std::string_view name);

}  // namespace lamella
