#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "compare/reproduce/reproduction.h"

namespace lamella {

/// A column of a figure's table: its name in the answer, its title on the terminal (empty: the
/// name), and how a number is written there, as in fmt: ".4f", ".2e", "g".
struct NumberColumn {
  std::string name;
  std::string format = "g";
  std::string title = "";
  int width = 0;  ///< of text; 0: as the title needs, 8 at least
};

/// The rows of a figure: printed as they come, and kept for the answer. Numbers that are not finite
/// are null there, and - on the terminal.
class NumberRows {
 public:
  using Value = std::variant<double, std::string>;

  /// Titles differ, but for "+-", which is of the column to its left. Throws std::invalid_argument.
  NumberRows(const ReproductionContext& context, std::vector<NumberColumn> columns);
  /// The columns' titles, after a text that is broken into lines.
  void header(const std::string& above = "") const;
  /// One value per column. Throws std::invalid_argument for another number of them.
  void add(const std::vector<Value>& values);
  /// The rows so far.
  [[nodiscard]] const nlohmann::ordered_json& rows() const { return rows_; }

 private:
  [[nodiscard]] int width(const NumberColumn& column) const;

  const ReproductionContext& context_;
  std::vector<NumberColumn> columns_;
  nlohmann::ordered_json rows_ = nlohmann::ordered_json::array();
};

}  // namespace lamella
