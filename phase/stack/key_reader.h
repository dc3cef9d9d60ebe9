#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "phase/parameters/parameters.h"
#include "phase/stack/toml_library.h"

namespace lamella {

/// A value of a stack file as an error shows it: words in quotes, "an array" for a list.
[[nodiscard]] std::string described(const toml::node& node);

/// Like described, but a list of numbers in full.
[[nodiscard]] std::string text_of(const toml::node& node);

/// A word, a number or a list of numbers; whole numbers are rounded to double. Nothing for any
/// other value.
[[nodiscard]] std::optional<ParameterValue> to_value(const toml::node& node);

/// The error text of a key that `where` does not know.
[[nodiscard]] std::string unknown_key(std::string_view key, const std::vector<std::string>& allowed,
                                      const std::string& where);

/// Reads values by their keys from tables of a stack file; what it refuses, it refuses with file,
/// line, key, the value found and the values allowed (StackFileError).
class KeyReader {
 public:
  /// `file`: the name used in errors.
  explicit KeyReader(std::string file) : file_(std::move(file)) {}

  [[nodiscard]] const std::string& file() const { return file_; }

  [[noreturn]] void fail(const toml::source_region& where, const std::string& message) const;

  /// Those keys of the table that `infos` names, with their defaults; every other key but those in
  /// `also` is an error.
  [[nodiscard]] Parameters read_keys(const toml::table& table,
                                     const std::vector<ParameterInfo>& infos,
                                     const std::vector<std::string>& also,
                                     const std::string& where) const;

  /// A word without control characters; `allowed` is the text of the error.
  [[nodiscard]] std::string read_name(const toml::node& node, const std::string& where,
                                      const std::string& key, const char* allowed) const;

  /// Three whole numbers in [low, high]; `what` tells in the error what they are.
  [[nodiscard]] std::array<int, 3> read_counts(const toml::node& node, const std::string& where,
                                               const std::string& key, double low, double high,
                                               const char* what) const;

 private:
  std::string file_;
};

}  // namespace lamella
