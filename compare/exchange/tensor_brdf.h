#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "analytic/model/model.h"

namespace lamella {

/// values[k] = f(pairs[k]) [1/sr], directions above the surface: what is exported.
using BsdfFunction =
    std::function<void(std::span<const DirectionPair> pairs, std::span<Rgb> values)>;

/// Sizes of a tensor file: nodes of theta (`directions`), of the density of half vectors along
/// either axis (`density`), of the table along either axis (`table`).
struct TensorSize {
  int directions = 32, density = 128, table = 64;
};

enum class TensorColors { rgb, spectra };

/// A measured BSDF for Mitsuba 3 (rgb: its RGB variants) or pbrt-v4 (spectra: f at 450, 550 and 650
/// nm is blue, green and red). Reflection alone, from above. `isotropic`: one azimuth is enough;
/// else 17 of them cover the circle. The file's w_i is the direction to the camera, our w_o.
///
/// The half vector's chart is u = sqrt(2 theta / pi), v = (phi + pi) / (2 pi); the file's value is
/// table(s) ndf / (4 sigma) = f cos, ndf = 1, sigma = 1/4, and s where the warp of `vndf` takes the
/// half vector from. The density is half f cos, half nearly cos, so that peaks have many nodes and
/// every direction has some. Dupuy and Jakob 2018, "An adaptive parameterization for efficient
/// material acquisition and rendering".
[[nodiscard]] std::string tensor_brdf(const BsdfFunction& f, bool isotropic, TensorColors colors,
                                      const TensorSize& size, const std::string& description);

/// A file of that format as a closed form with the lobe "measured". Throws FormatError, which
/// begins with `file`.
[[nodiscard]] std::unique_ptr<Model> read_tensor_brdf(const std::string& bytes,
                                                      const std::string& file);

}  // namespace lamella
