#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "compare/report/lobe_set.h"

namespace lamella {

/// An array of a NumPy archive beside the lobes, values in C order.
struct NamedArray {
  std::string name;
  std::vector<std::size_t> shape;
  std::vector<double> values;
};

/// Which numbers of lobes an archive has: all in float64; or values in float32, and standard errors
/// of "all" alone.
enum class NpzLobes { full, compact };

/// Lobes as a NumPy archive (.npz, stored): `directions` [n, 3], `mu_edges`, `phi_edges`, `folded`,
/// "SIDE.NAME" and "SIDE.NAME.se" [direction, mu, phi, channel], `further` arrays in float64, and
/// the attributes as texts "attribute.NAME". Equal lobes give equal bytes.
[[nodiscard]] std::string lobe_npz(const LobeSet& set, const std::vector<NamedArray>& further = {},
                                   NpzLobes form = NpzLobes::full);

/// Lobes as CSV: a row per direction, side, lobe and cell, with its edges (theta_i, phi_i, phi in
/// degrees), f per channel, and se where it is known.
[[nodiscard]] std::string lobe_csv(const LobeSet& set);

}  // namespace lamella
