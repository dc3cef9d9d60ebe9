#include "compare/reproduce/number_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "compare/report/wrapped_text.h"

namespace lamella {
namespace {

const std::string& title_of(const NumberColumn& column) {
  return column.title.empty() ? column.name : column.title;
}

// Each is the error of the column to its left.
const std::string kErrorTitle = "+-";

}  // namespace

NumberRows::NumberRows(const ReproductionContext& context, std::vector<NumberColumn> columns)
    : context_(context), columns_(std::move(columns)) {
  std::set<std::string> titles;
  for (const NumberColumn& c : columns_)
    if (title_of(c) != kErrorTitle && !titles.insert(title_of(c)).second)
      throw std::invalid_argument("a figure with two columns of the title " + title_of(c));
}

int NumberRows::width(const NumberColumn& column) const {
  // Of -0.123456, -1.234e-05: a sign, a digit, the point, digits, an exponent.
  const std::string& format = column.format;
  int least = 8;
  if (format.size() == 3 && format[0] == '.')
    least = std::max(least, format[1] - '0' + (format.back() == 'e' ? 7 : 3));
  return std::max({least, column.width, static_cast<int>(title_of(column).size())});
}

void NumberRows::header(const std::string& above) const {
  std::string line, text = above;
  std::replace(text.begin(), text.end(), '\n', ' ');
  for (const NumberColumn& c : columns_)
    line += fmt::format("{:>{}}", title_of(c), width(c) + (line.empty() ? 0 : 1));
  context_.say(fmt::format("{}{}\n", above.empty() ? "" : "\n" + wrapped("", text), line));
}

void NumberRows::add(const std::vector<Value>& values) {
  if (values.size() != columns_.size())
    throw std::invalid_argument("a row of a figure with another number of columns");
  nlohmann::ordered_json row;
  std::string line;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const NumberColumn& c = columns_[k];
    const int wide = width(c) + (line.empty() ? 0 : 1);
    if (const auto* number = std::get_if<double>(&values[k])) {
      const bool is_there = std::isfinite(*number);
      line += fmt::format(
          "{:>{}}", is_there ? fmt::format(fmt::runtime("{:" + c.format + "}"), *number) : "-",
          wide);
      if (is_there)
        row[c.name] = *number;
      else
        row[c.name] = nullptr;
    } else {
      const std::string& text = std::get<std::string>(values[k]);
      line += fmt::format("{:>{}}", text, wide);
      row[c.name] = text;
    }
  }
  context_.say(line + "\n");
  rows_.push_back(std::move(row));
}

}  // namespace lamella
