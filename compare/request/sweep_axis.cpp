#include "compare/request/sweep_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "compare/request/errors.h"
#include "compare/request/numbers.h"
#include "compare/request/split_text.h"
#include "phase/parameters/parameters.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

constexpr std::uint64_t kMostValues = 1000;

[[noreturn]] void fail(const std::string& text) {
  throw UsageError(
      fmt::format("--set: found \"{}\"; allowed: PATH=FROM:TO:COUNT[:log] or PATH=A,B,..., PATH "
                  "being layer.N.KEY (N from 0 at the top) or substrate.KEY, COUNT from 2 to {}",
                  text, kMostValues));
}

// A stack file as to_toml writes it: one "key = value" per line, under a header per part.
struct Part {
  std::string header;
  std::vector<std::pair<std::string, std::string>> lines;
};

std::vector<Part> parts_of(const std::string& toml) {
  std::vector<Part> parts;
  std::istringstream in(toml);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("[")) {
      parts.push_back({line, {}});
    } else if (const std::size_t equals = line.find(" = "); equals != std::string::npos) {
      parts.back().lines.emplace_back(line.substr(0, equals), line.substr(equals + 3));
    }
  }
  return parts;
}

Part& part_of(std::vector<Part>& parts, const Stack& stack, const std::string& path,
              const std::string& option) {
  const std::vector<std::string> words = split_text(path, '.');
  if (words.size() == 3 && words[0] == "layer") {
    const auto index = parse_whole_number(words[1]);
    if (index && *index < stack.layers.size()) return parts[*index];
  } else if (words.size() == 2 && words[0] == "substrate" && stack.substrate) {
    return parts.back();
  }
  throw UsageError(
      fmt::format("{}: found the path \"{}\"; allowed: layer.0 to layer.{}{}, followed by .KEY",
                  option, path, stack.layers.size() - 1, stack.substrate ? ", substrate" : ""));
}

}  // namespace

SweepAxis parse_sweep_axis(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) fail(text);
  SweepAxis axis{text.substr(0, equals), {}};
  const std::string right = text.substr(equals + 1);
  const std::vector<std::string> range = split_text(right, ':');
  if (range.size() == 1) {
    for (const std::string& word : split_text(right, ',')) {
      const auto value = parse_number(word);
      if (!value) fail(text);
      axis.values.push_back(*value);
    }
    return axis;
  }
  const bool logarithmic = range.size() == 4 && range[3] == "log";
  if (range.size() != 3 && !logarithmic) fail(text);
  const auto from = parse_number(range[0]), to = parse_number(range[1]);
  const auto count = parse_whole_number(range[2]);
  if (!from || !to || !std::isfinite(*from) || !std::isfinite(*to) || !count || *count < 2 ||
      *count > kMostValues || (logarithmic && !(*from > 0 && *to > 0)))
    fail(text);
  for (std::uint64_t k = 0; k < *count; ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(*count - 1);
    const double value = logarithmic ? *from * std::pow(*to / *from, t) : *from + t * (*to - *from);
    // Ends as they were given, the rest to twelve digits: 0.7 and not 0.7000000000000001.
    axis.values.push_back(k == 0            ? *from
                          : k == *count - 1 ? *to
                                            : *parse_number(fmt::format("{:.12g}", value)));
  }
  return axis;
}

std::string with_values(const Stack& stack, const std::vector<SweepAxis>& axes,
                        const std::vector<std::size_t>& at) {
  std::vector<std::pair<std::string, std::string>> texts;
  for (std::size_t a = 0; a < axes.size(); ++a)
    texts.emplace_back(axes[a].path, to_text(axes[a].values[at[a]]));
  return with_texts(stack, texts);
}

std::string with_texts(const Stack& stack,
                       const std::vector<std::pair<std::string, std::string>>& texts,
                       const std::string& option) {
  std::vector<Part> parts = parts_of(to_toml(stack));
  for (const auto& [path, value] : texts) {
    Part& part = part_of(parts, stack, path, option);
    const std::string key = path.substr(path.rfind('.') + 1);
    // Two names of one quantity: what is set replaces the other.
    const std::string other = key == "roughness" ? "alpha" : key == "alpha" ? "roughness" : "";
    std::erase_if(part.lines, [&](const auto& line) { return line.first == other; });
    const auto line = std::find_if(part.lines.begin(), part.lines.end(),
                                   [&](const auto& l) { return l.first == key; });
    if (line != part.lines.end())
      line->second = value;
    else
      part.lines.emplace_back(key, value);
  }
  std::string text;
  for (const Part& part : parts) {
    text += part.header + "\n";
    for (const auto& [key, value] : part.lines) text += fmt::format("{} = {}\n", key, value);
    text += "\n";
  }
  return text;
}

std::optional<std::string> text_at(const Stack& stack, const std::string& path,
                                   const std::string& option) {
  std::vector<Part> parts = parts_of(to_toml(stack));
  const std::string key = path.substr(path.rfind('.') + 1);
  for (const auto& [name, value] : part_of(parts, stack, path, option).lines)
    if (name == key) return value;
  return std::nullopt;
}

}  // namespace lamella
