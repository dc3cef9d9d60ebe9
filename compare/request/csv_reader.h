#pragma once

#include <istream>
#include <optional>
#include <string>
#include <vector>

namespace lamella {

/// The text with control characters as \xNN and shortened to what fits in an error.
[[nodiscard]] std::string shown(const std::string& text);

/// A table of text, line by line, as spreadsheets and statistics programs write it.
///
/// The first line decides which character separates fields: a semicolon, else a comma, else a tab.
/// A line "sep=;" before it (Excel) names the character itself. Fields may stand in double quotes,
/// blanks at their ends are dropped, and so are a byte order mark, blank lines and a carriage
/// return at the end of a line. Between semicolons or tabs a decimal comma is a decimal point; a
/// file uses one decimal mark. Other input is refused with file, line number, and the line's text.
class CsvReader {
 public:
  /// `file`: as named in errors.
  CsvReader(std::istream& in, std::string file);

  /// The fields of the next line that is not blank; nothing at the end. Throws UsageError.
  [[nodiscard]] std::optional<std::vector<std::string>> next();

  /// Number and text of that line, without its end.
  [[nodiscard]] int line() const { return line_; }
  [[nodiscard]] const std::string& text() const { return text_; }

  /// A field of that line as a number with a decimal point; nothing if it is none.
  [[nodiscard]] std::optional<std::string> number_text(const std::string& field);

  /// Refuses that line: throws UsageError with file, line, its text, what else was `found` (may be
  /// empty) and what is `allowed`.
  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const;

 private:
  bool read_line();
  [[nodiscard]] std::vector<std::string> fields() const;

  std::istream& in_;
  std::string file_, text_{};
  int line_ = 0;
  char separator_ = 0;     // none before the first line
  char decimal_mark_ = 0;  // none before a number with one
};

}  // namespace lamella
