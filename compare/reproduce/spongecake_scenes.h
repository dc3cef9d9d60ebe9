#pragma once

#include <functional>
#include <memory>
#include <string>

#include "compare/fit/fitted_models.h"
#include "compare/render/surface_scatter.h"
#include "compare/reproduce/reproduction.h"
#include "volume/mesh/triangle_mesh.h"

namespace lamella {

// SpongeCake's scenes, with textures and objects that are generated here.

/// A stack whose numbers vary over the surface: its text at a place, u and v from 0 to 1.
using StackText = std::function<std::string(double u, double v)>;

/// Its truth by walks, and a closed form of it.
[[nodiscard]] std::unique_ptr<SurfaceScatter> walked_texture(const StackText& text);
[[nodiscard]] std::unique_ptr<SurfaceScatter> closed_texture(const StackText& text,
                                                             const std::string& request);

/// Layers of a stack file.
[[nodiscard]] std::string flake_layer(const std::string& shape, Direction axis, double roughness,
                                      Rgb albedo, double f0, double thickness);

/// A smooth random function of period 1 in u and v, within about -1 and 1: a sum of waves of at
/// most `waves` periods.
[[nodiscard]] double wavy(double u, double v, int waves, std::uint64_t seed);

}  // namespace lamella
