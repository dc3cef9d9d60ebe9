#pragma once

#include <istream>
#include <string>
#include <vector>

#include "analytic/model/model.h"

namespace lamella {

/// Direction pairs as read from CSV, with the text of each row for the echo: its numbers between
/// commas, with decimal points.
struct DirectionPairs {
  std::string file;  ///< as named in errors
  std::string header;
  std::vector<std::string> rows;
  std::vector<int> lines;  ///< of the file, from 1
  std::vector<DirectionPair> pairs;
};

/// Reads CSV (CsvReader says which forms it takes) with the header theta_i,phi_i,theta_o,phi_o or
/// mu_i,phi_i,mu_o,phi_o; theta in [0, 180] and phi in degrees, mu a cosine in [-1, 1]. Throws
/// UsageError, which names file, line, the value found and the values allowed.
[[nodiscard]] DirectionPairs read_pairs(std::istream& in, const std::string& file);

/// Refuses the pair k: throws UsageError with file, line and the row.
[[noreturn]] void refuse_pair(const DirectionPairs& pairs, std::size_t k,
                              const std::string& message);

}  // namespace lamella
