#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "phase/parameters/parameters.h"
#include "phase/surface/conductor.h"
#include "phase/surface/microfacet.h"

namespace lamella {

/// A boundary between two dielectrics, an entry of the list of layers without thickness: its
/// surface, and the index of the medium below it. The medium above gives the other index.
struct Interface {
  Facets facets{.shape = FacetShape::smooth};
  Masking masking = Masking::beta;
  bool multiple = false;
  double ior = 1;  ///< index of refraction of everything below, up to the next interface
};

/// An interface as stack files and `lamella media` know it.
struct InterfaceInfo {
  std::string name;
  std::string doc;
  std::string source;
  std::vector<ParameterInfo> parameters;
  /// Builds the interface from checked, completed parameters. Throws ParameterError.
  std::function<Interface(const Parameters&)> make;
};

[[nodiscard]] const std::vector<InterfaceInfo>& interfaces();

/// The entry with that name, or nullptr.
[[nodiscard]] const InterfaceInfo* find_interface(std::string_view name);

/// Keys of a substrate that is a conductor (`bsdf = "conductor"`).
[[nodiscard]] const std::vector<ParameterInfo>& conductor_parameters();

/// The conductor of checked, completed parameters under a medium of index `above`: eta + i k of the
/// keys are against vacuum. Throws ParameterError.
[[nodiscard]] Conductor::Setting conductor_setting(const Parameters& parameters, double above);

}  // namespace lamella
