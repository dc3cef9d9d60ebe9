#pragma once

#include <string>

namespace lamella {

/// A share as percent for people, with two significant digits: 0.0083 is "0.83 %", 1.2 is "120 %".
/// Never as a power of ten: from 1 % up to a million % digits alone, beyond it "above 1000000 %",
/// below 1e-8 % "below 0.00000001 %". nan is "-", infinity "inf %". The pages do the same
/// (report/page/source/numbers.js).
[[nodiscard]] std::string percent_text(double share);

/// A share as percent for a column of a table, with two decimals below 100 %: "0.83 %", "41.70 %",
/// "120 %".
[[nodiscard]] std::string percent_cell(double share);

/// A difference, with its sign: "+0.83 %".
[[nodiscard]] std::string signed_percent_cell(double share);

}  // namespace lamella
