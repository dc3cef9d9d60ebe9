#pragma once

#include <filesystem>
#include <vector>

#include "phase/stack/mapped_stack.h"

namespace lamella {

/// The values of a key over the surface, from its picture. u runs to the right from the picture's
/// left edge, v upwards from its bottom edge, both by 1 over the picture; the axes x and y of the
/// stack point along u and v. Linear filtering interpolates values (of directions: vectors, which
/// the key normalises) between the centres of four texels.
class ValueMap {
 public:
  /// Reads the picture. Throws StackFileError, which begins with the key's place: for a file that
  /// cannot be read, a channel that is not there, and the first value that the key does not take.
  explicit ValueMap(const MappedKey& key);

  /// The key's value at a place; any u and v, beyond the picture as its `wrap` says. Throws
  /// StackFileError where opposite directions leave none between them.
  [[nodiscard]] ParameterValue at(double u, double v) const;

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  [[nodiscard]] const float* texel(std::int64_t x, std::int64_t y) const;
  [[nodiscard]] ParameterValue value_of(const double* numbers) const;
  void check() const;

  MappedKey key_;
  std::filesystem::path file_;
  int columns_ = 0, rows_ = 0, numbers_ = 1;  // numbers per texel: 1 or 3
  std::vector<float> texels_;                 // decoded, row by row from the top
};

}  // namespace lamella
