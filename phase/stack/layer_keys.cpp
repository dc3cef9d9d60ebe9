#include "phase/stack/layer_keys.h"

namespace lamella {

const ParameterInfo& albedo_key() {
  static const ParameterInfo key{.name = "albedo",
                                 .kind = ParameterKind::color,
                                 .unit = "1",
                                 .doc = "single-scattering albedo",
                                 .default_value = "1",
                                 .min = 0,
                                 .max = 1};
  return key;
}

const ParameterInfo& thickness_key() {
  static const ParameterInfo key{
      .name = "thickness", .unit = "mm", .doc = "inf for a half space", .min = 0};
  return key;
}

const ParameterInfo& density_key() {
  static const ParameterInfo key{.name = "density",
                                 .unit = "1/mm",
                                 .doc = "multiplies sigma",
                                 .default_value = "1",
                                 .min = 0,
                                 .max_open = true};
  return key;
}

}  // namespace lamella
