#pragma once

#include <memory>
#include <string>

#include "analytic/model/model.h"
#include "compare/exchange/tensor_brdf.h"

namespace lamella {

/// MERL's `.binary`: isotropic reflection, RGB, on 90 x 90 x 180 bins of theta_h (finer towards the
/// normal), theta_d and phi_d, 34992012 bytes. Values at the bins' centres; bins whose directions
/// lie below the horizon hold -1. Isotropic f alone: w_i lies at azimuths about 0 here.
/// Matusik et al. 2003, "A data-driven reflectance model".
[[nodiscard]] std::string merl_brdf(const BsdfFunction& f);

/// A file of that format as a closed form with the lobe "measured": linear between the centres of
/// bins, those below the horizon (negative) left out. Throws FormatError, which begins with `file`.
[[nodiscard]] std::unique_ptr<Model> read_merl_brdf(const std::string& bytes,
                                                    const std::string& file);

}  // namespace lamella
