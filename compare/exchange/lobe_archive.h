#pragma once

#include <string>

#include "compare/report/lobe_set.h"

namespace lamella {

/// Lobes as a NumPy archive (.npz, stored): `directions` [n, 3], `mu_edges`, `phi_edges`, `folded`,
/// "SIDE.NAME" and "SIDE.NAME.se" [direction, mu, phi, channel] in float64, and the attributes as
/// texts "attribute.NAME". Equal lobes give equal bytes.
[[nodiscard]] std::string lobe_npz(const LobeSet& set);

/// Lobes as CSV: a row per direction, side, lobe and cell, with its edges (theta_i, phi_i, phi in
/// degrees), f per channel, and se where it is known.
[[nodiscard]] std::string lobe_csv(const LobeSet& set);

}  // namespace lamella
