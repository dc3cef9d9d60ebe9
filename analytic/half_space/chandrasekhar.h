#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// Isotropic scattering in a half space, exact:
///   f = c / (4 pi) H(mu_i) H(mu_o) / (mu_i + mu_o) [1/sr]
/// c: albedo in [0, 1]; H: its isotropic H function (h_function.h). Directional albedo:
/// 1 - sqrt(1 - c) H(mu_i). Relative error below 1e-11. Diverges where both cosines vanish.
/// Lobes: `single`, the same without the H, and `multiple`, the rest.
/// Chandrasekhar 1960, "Radiative Transfer"; d'Eon 2021, eq. 21.
[[nodiscard]] ModelInfo chandrasekhar_model();

}  // namespace lamella
