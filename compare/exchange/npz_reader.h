#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "compare/exchange/lobe_archive.h"

namespace lamella {

/// An array of a NumPy archive: numbers in C order, or a text of no axes.
struct NpzArray {
  std::vector<std::size_t> shape{};
  std::vector<double> values{};
  std::string text{};
};

/// Reads what lobe_npz writes: a zip archive without compression of arrays of float64, booleans and
/// single texts of ASCII. The content is untrusted: sizes are held against the file's before there
/// is room made for them, members against their CRC-32. `file`: as named in errors. Throws
/// FormatError.
[[nodiscard]] std::map<std::string, NpzArray> read_npz(const std::string& bytes,
                                                       const std::string& file);

/// The lobes of an archive of lobe_npz, with their attributes; energies are left out. Throws
/// FormatError where arrays are missing or of another shape.
[[nodiscard]] LobeSet lobes_of_npz(const std::map<std::string, NpzArray>& arrays,
                                   const std::string& file);

}  // namespace lamella
