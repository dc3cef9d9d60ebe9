#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace lamella {

/// A file of another program's format that cannot be taken: file, what was found, what is allowed.
struct FormatError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Bytes of a file that are read at most: beyond it is no measured material.
inline constexpr std::uint64_t kMostFormatBytes = std::uint64_t{1} << 30;

/// A whole file. Throws FormatError where it cannot be read or is larger than kMostFormatBytes:
/// before anything is allocated.
[[nodiscard]] std::string read_format_file(const std::filesystem::path& path);

/// A named array of a tensor file, in C order.
struct TensorField {
  std::string name;
  std::vector<std::uint64_t> shape;
  bool is_bytes = false;       ///< u8 instead of f32
  std::vector<float> numbers;  ///< of f32 and f64
  std::string bytes;           ///< of u8
};

/// The container of Mitsuba's and pbrt's measured BSDFs (`.bsdf`), version 1.0: arrays by name.
[[nodiscard]] std::string tensor_file(const std::vector<TensorField>& fields);

/// Reads it back. Fields of other types than u8, f32 and f64 are left out. Throws FormatError,
/// which begins with `file`: truncated, sizes that do not fit the file, no such file at all.
[[nodiscard]] std::vector<TensorField> read_tensor_file(const std::string& bytes,
                                                        const std::string& file);

}  // namespace lamella
