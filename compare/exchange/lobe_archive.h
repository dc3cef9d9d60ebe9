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

/// Lobes as a NumPy archive (.npz, stored): `directions` [n, 3], `mu_edges`, `phi_edges`, `folded`,
/// "SIDE.NAME" and "SIDE.NAME.se" [direction, mu, phi, channel] in float64, `further` arrays, and
/// the attributes as texts "attribute.NAME". Equal lobes give equal bytes.
[[nodiscard]] std::string lobe_npz(const LobeSet& set, const std::vector<NamedArray>& further = {});

/// CRC-32 of ISO 3309, which zip archives have.
[[nodiscard]] std::uint32_t crc32_of(const std::string& bytes);

/// Lobes as CSV: a row per direction, side, lobe and cell, with its edges (theta_i, phi_i, phi in
/// degrees), f per channel, and se where it is known.
[[nodiscard]] std::string lobe_csv(const LobeSet& set);

}  // namespace lamella
