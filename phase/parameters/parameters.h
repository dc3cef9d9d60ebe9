#pragma once

#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "phase/math/color.h"
#include "phase/math/vec3.h"

namespace lamella {

/// one_or_two: a number, or two that differ along x and along y.
enum class ParameterKind { number, color, vector, matrix, choice, one_or_two };

/// The description of a parameter of a medium or a model: enough to read, check and echo the
/// parameter and to print its documentation.
struct ParameterInfo {
  std::string name;
  ParameterKind kind = ParameterKind::number;
  std::string unit;                ///< "1" for dimensionless
  std::string doc;                 ///< one line
  std::string default_value = {};  ///< as written in a stack file; empty if there is none
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_open = false, max_open = false;
  std::vector<std::string> choices = {};  ///< of a choice
};

/// A number, a colour, a vector or matrix as its elements, or a choice.
using ParameterValue = std::variant<double, Rgb, std::vector<double>, std::string>;

/// Values by name. Names are those of the ParameterInfo list they were read by.
class Parameters {
 public:
  void set(std::string name, ParameterValue value) {
    values_.insert_or_assign(std::move(name), std::move(value));
  }
  [[nodiscard]] bool has(std::string_view name) const { return values_.contains(name); }
  /// The value under that name. Throws std::out_of_range if it is absent.
  [[nodiscard]] const ParameterValue& at(std::string_view name) const;
  [[nodiscard]] double number(std::string_view name) const;
  [[nodiscard]] Rgb color(std::string_view name) const;
  [[nodiscard]] Direction vector(std::string_view name) const;
  [[nodiscard]] const std::string& choice(std::string_view name) const;
  [[nodiscard]] const std::map<std::string, ParameterValue, std::less<>>& all() const {
    return values_;
  }
  /// Whether any colour among the values differs between its channels.
  [[nodiscard]] bool has_color() const;

 private:
  std::map<std::string, ParameterValue, std::less<>> values_;
};

/// A parameter that cannot be taken: what was found, and what is allowed.
struct ParameterError : std::runtime_error {
  ParameterError(std::string key_, std::string found_, std::string allowed_);
  std::string key, found, allowed;
};

/// What the parameter allows, in words: "a number in [0, 1]".
[[nodiscard]] std::string allowed_values(const ParameterInfo& info);

/// The value in the form a stack file has it: 0.5, [1, 2, 3], "surface", inf.
[[nodiscard]] std::string to_text(const ParameterValue& value);

/// A number in its shortest form that reads back the same; inf, -inf, nan by name.
[[nodiscard]] std::string to_text(double value);

/// Checks kind and range. A number is taken for a colour (grey). Throws ParameterError.
[[nodiscard]] ParameterValue checked(const ParameterInfo& info, const ParameterValue& value);

/// Reads "0.5", "0.9,0.5,0.2", "surface" or "inf" as the kind of the parameter wants, checked.
[[nodiscard]] ParameterValue parse_value(const ParameterInfo& info, std::string_view text);

/// Fills in the defaults of those parameters that have one and were not given.
void fill_defaults(const std::vector<ParameterInfo>& infos, Parameters& parameters);

/// The entry with that name, or nullptr.
[[nodiscard]] const ParameterInfo* find(const std::vector<ParameterInfo>& infos,
                                        std::string_view name);

/// `did you mean "albedo"?` for the candidate nearest in spelling or with its parts, or nothing.
[[nodiscard]] std::string suggestion(std::string_view word,
                                     const std::vector<std::string>& candidates);

/// The words with commas between them.
[[nodiscard]] std::string listed(const std::vector<std::string>& words);

}  // namespace lamella
