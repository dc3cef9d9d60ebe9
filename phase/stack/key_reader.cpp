#include "phase/stack/key_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "phase/stack/stack_file_error.h"

namespace lamella {
namespace {

// A number, whole ones rounded to double: toml++ converts only those that double holds exactly.
double number_in(const toml::node& node) {
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  return node.as_floating_point()->get();
}

}  // namespace

std::string described(const toml::node& node) {
  if (const auto* s = node.as_string()) return '"' + s->get() + '"';
  if (node.is_table()) return "a table";
  if (node.is_array()) return "an array";
  if (node.is_number()) return to_text(number_in(node));
  if (const auto flag = node.value<bool>()) return *flag ? "true" : "false";
  return "a date or time";
}

std::string text_of(const toml::node& node) {
  const auto value = node.is_array() ? to_value(node) : std::nullopt;
  return value ? to_text(*value) : described(node);
}

std::optional<ParameterValue> to_value(const toml::node& node) {
  if (const auto* s = node.as_string()) return s->get();
  if (node.is_number()) return number_in(node);
  const toml::array* array = node.as_array();
  if (!array) return std::nullopt;
  std::vector<double> numbers;
  for (const auto& element : *array) {
    if (!element.is_number()) return std::nullopt;
    numbers.push_back(number_in(element));
  }
  return numbers;
}

std::string unknown_key(std::string_view key, const std::vector<std::string>& allowed,
                        const std::string& where) {
  const std::string hint = suggestion(key, allowed);
  return fmt::format("key \"{}\": unknown in {}{}; allowed: {}", key, where,
                     hint.empty() ? "" : ", " + hint, listed(allowed));
}

void KeyReader::fail(const toml::source_region& where, const std::string& message) const {
  // A value that was taken from a picture stands in no line.
  if (where.begin.line == 0) throw StackFileError(fmt::format("{}: {}", file_, message));
  throw StackFileError(fmt::format("{}:{}: {}", file_, where.begin.line, message));
}

Parameters KeyReader::read_keys(const toml::table& table, const std::vector<ParameterInfo>& infos,
                                const std::vector<std::string>& also,
                                const std::string& where) const {
  Parameters parameters;
  std::vector<std::string> allowed = also;
  for (const ParameterInfo& info : infos) allowed.push_back(info.name);
  for (const auto& [key, node] : table) {
    const ParameterInfo* info = find(infos, key.str());
    if (!info) {
      if (std::find(also.begin(), also.end(), key.str()) != also.end()) continue;
      fail(key.source(), unknown_key(key.str(), allowed, where));
    }
    auto value = to_value(node);
    // true and false are words of a choice.
    if (const auto* flag = node.as_boolean(); flag && info->kind == ParameterKind::choice)
      value = std::string(flag->get() ? "true" : "false");
    if (!value)
      fail(node.source(), fmt::format("{}: key \"{}\": found {}; allowed: {}", where, info->name,
                                      described(node), allowed_values(*info)));
    try {
      parameters.set(info->name, checked(*info, *value));
    } catch (const ParameterError& error) {
      const bool number = info->kind != ParameterKind::choice && node.is_string();
      fail(node.source(), fmt::format("{}: {}{}", where, error.what(),
                                      number ? ", or a picture (.exr, .png, .jpg)" : ""));
    }
  }
  fill_defaults(infos, parameters);
  return parameters;
}

std::string KeyReader::read_name(const toml::node& node, const std::string& where,
                                 const std::string& key, const char* allowed) const {
  const auto* name = node.as_string();
  const auto is_control = [](char c) { return (c >= 0 && c < ' ') || c == 127; };
  if (!name || name->get().empty() ||
      std::any_of(name->get().begin(), name->get().end(), is_control))
    fail(node.source(), fmt::format("{}: key \"{}\": found {}; allowed: {}", where, key,
                                    name && !name->get().empty() ? "a name with control characters"
                                                                 : described(node),
                                    allowed));
  return name->get();
}

std::array<int, 3> KeyReader::read_counts(const toml::node& node, const std::string& where,
                                          const std::string& key, double low, double high,
                                          const char* what) const {
  std::vector<double> numbers;
  if (const auto value = to_value(node))
    if (const auto* list = std::get_if<std::vector<double>>(&*value)) numbers = *list;
  if (numbers.size() != 3 || !std::all_of(numbers.begin(), numbers.end(), [&](double x) {
        return x == std::floor(x) && x >= low && x <= high;
      }))
    fail(node.source(),
         fmt::format("{}: key \"{}\": found {}; allowed: three whole numbers [x, y, z] in [{}, "
                     "{}], {}",
                     where, key, text_of(node), to_text(low), to_text(high), what));
  return {static_cast<int>(numbers[0]), static_cast<int>(numbers[1]), static_cast<int>(numbers[2])};
}

}  // namespace lamella
