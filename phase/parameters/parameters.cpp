#include "phase/parameters/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>

#include "phase/parameters/toml_text.h"

namespace lamella {
namespace {

std::string kind_in_words(const ParameterInfo& info) {
  switch (info.kind) {
    case ParameterKind::number:
      return "a number";
    case ParameterKind::color:
      return "a number or three numbers [r, g, b], each";
    case ParameterKind::vector:
      return "three numbers [x, y, z], not all zero";
    case ParameterKind::matrix:
      return "six numbers [xx, yy, zz, xy, xz, yz] of a symmetric positive definite matrix";
    case ParameterKind::one_or_two:
      return "a number or two numbers [along x, along y], each";
    case ParameterKind::choice:
      break;
  }
  return "one of " + listed(info.choices);
}

bool in_range(const ParameterInfo& info, double x) {
  if (std::isnan(x)) return false;
  if (info.min_open ? x <= info.min : x < info.min) return false;
  return info.max_open ? x < info.max : x <= info.max;
}

std::optional<double> parse_number(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// The unit vector along v, whose largest element is `largest`. A vector of length 1 up to the
// rounding of a former normalisation (its square within 9 half-ulps) stays as it is, so that a
// stack that was written reads back the same.
Direction unit_along(Direction v, double largest) {
  constexpr double kRounding = 4.5 * std::numeric_limits<double>::epsilon();
  if (std::abs(dot(v, v) - 1) <= kRounding) return v;
  return normalized((1 / largest) * v);
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])});
      diagonal = above;
    }
  }
  return row.back();
}

std::string in_lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

// Whether every part of the word, between underscores or hyphens, is in the name.
bool has_parts(std::string_view name, std::string_view word) {
  while (!word.empty()) {
    const std::size_t end = std::min(word.find_first_of("_-"), word.size());
    if (name.find(word.substr(0, end)) == std::string_view::npos) return false;
    word.remove_prefix(std::min(end + 1, word.size()));
  }
  return true;
}

}  // namespace

ParameterError::ParameterError(std::string key_, std::string found_, std::string allowed_)
    : std::runtime_error(fmt::format("key \"{}\": found {}; allowed: {}", key_, found_, allowed_)),
      key(std::move(key_)),
      found(std::move(found_)),
      allowed(std::move(allowed_)) {}

const ParameterValue& Parameters::at(std::string_view name) const {
  const auto it = values_.find(name);
  if (it == values_.end()) throw std::out_of_range(fmt::format("no parameter \"{}\"", name));
  return it->second;
}

double Parameters::number(std::string_view name) const { return std::get<double>(at(name)); }
Rgb Parameters::color(std::string_view name) const { return std::get<Rgb>(at(name)); }
const std::string& Parameters::choice(std::string_view name) const {
  return std::get<std::string>(at(name));
}
Direction Parameters::vector(std::string_view name) const {
  const auto& v = std::get<std::vector<double>>(at(name));
  return {v.at(0), v.at(1), v.at(2)};
}

bool Parameters::has_color() const {
  return std::any_of(values_.begin(), values_.end(), [](const auto& entry) {
    const Rgb* color = std::get_if<Rgb>(&entry.second);
    return color && !color->is_grey();
  });
}

std::string allowed_values(const ParameterInfo& info) {
  std::string text = kind_in_words(info);
  if (info.kind != ParameterKind::number && info.kind != ParameterKind::color &&
      info.kind != ParameterKind::one_or_two)
    return text;
  const bool upper = std::isfinite(info.max) || !info.max_open;
  if (info.min == -std::numeric_limits<double>::infinity() && !std::isfinite(info.max)) return text;
  return text + fmt::format(" in {}{}, {}{}", info.min_open ? '(' : '[', to_text(info.min),
                            to_text(info.max), upper && !info.max_open ? ']' : ')');
}

std::string to_text(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return fmt::format("{}", value);
}

std::string to_text(const ParameterValue& value) {
  struct Visitor {
    std::string operator()(double x) const { return to_text(x); }
    std::string operator()(Rgb c) const {
      if (c.is_grey()) return to_text(c.r);
      return fmt::format("[{}, {}, {}]", to_text(c.r), to_text(c.g), to_text(c.b));
    }
    std::string operator()(const std::vector<double>& v) const {
      std::string text = "[";
      for (std::size_t i = 0; i < v.size(); ++i) text += (i ? ", " : "") + to_text(v[i]);
      return text + "]";
    }
    std::string operator()(const std::string& s) const { return quoted(s); }
  };
  return std::visit(Visitor{}, value);
}

ParameterValue checked(const ParameterInfo& info, const ParameterValue& value) {
  const auto refuse = [&]() -> ParameterError {
    return {info.name, to_text(value), allowed_values(info)};
  };
  switch (info.kind) {
    case ParameterKind::number: {
      const double* x = std::get_if<double>(&value);
      if (!x || !in_range(info, *x)) throw refuse();
      return *x;
    }
    case ParameterKind::color: {
      Rgb color;
      if (const double* x = std::get_if<double>(&value)) {
        color = Rgb(*x);
      } else if (const Rgb* c = std::get_if<Rgb>(&value)) {
        color = *c;
      } else if (const auto* v = std::get_if<std::vector<double>>(&value); v && v->size() == 3) {
        color = {(*v)[0], (*v)[1], (*v)[2]};
      } else {
        throw refuse();
      }
      for (int c = 0; c < 3; ++c)
        if (!in_range(info, color[c])) throw refuse();
      return color;
    }
    case ParameterKind::vector: {
      const auto* v = std::get_if<std::vector<double>>(&value);
      if (!v || v->size() != 3) throw refuse();
      double largest = 0;
      for (const double x : *v) {
        if (!std::isfinite(x)) throw refuse();
        largest = std::max(largest, std::abs(x));
      }
      if (!(largest > 0)) throw refuse();
      const Direction unit = unit_along({(*v)[0], (*v)[1], (*v)[2]}, largest);
      return std::vector<double>{unit.x, unit.y, unit.z};
    }
    case ParameterKind::matrix: {
      const auto* v = std::get_if<std::vector<double>>(&value);
      if (!v || v->size() != 6) throw refuse();
      return *v;
    }
    case ParameterKind::one_or_two: {
      if (const double* x = std::get_if<double>(&value)) {
        if (!in_range(info, *x)) throw refuse();
        return *x;
      }
      const auto* v = std::get_if<std::vector<double>>(&value);
      if (!v || v->size() != 2 || !in_range(info, (*v)[0]) || !in_range(info, (*v)[1]))
        throw refuse();
      if ((*v)[0] == (*v)[1]) return (*v)[0];
      return *v;
    }
    case ParameterKind::choice: {
      const auto* s = std::get_if<std::string>(&value);
      if (!s) throw refuse();
      if (std::find(info.choices.begin(), info.choices.end(), *s) == info.choices.end()) {
        const std::string hint = suggestion(*s, info.choices);
        throw ParameterError(info.name, to_text(value),
                             allowed_values(info) + (hint.empty() ? "" : " (" + hint + ")"));
      }
      return *s;
    }
  }
  throw refuse();
}

ParameterValue parse_value(const ParameterInfo& info, std::string_view text) {
  if (info.kind == ParameterKind::choice) return checked(info, std::string(text));
  std::vector<double> numbers;
  for (std::string_view rest = text;;) {
    const auto comma = rest.find(',');
    const auto number = parse_number(rest.substr(0, comma));
    if (!number)
      throw ParameterError(info.name, '"' + std::string(text) + '"', allowed_values(info));
    numbers.push_back(*number);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (numbers.size() == 1) return checked(info, numbers[0]);
  return checked(info, numbers);
}

void fill_defaults(const std::vector<ParameterInfo>& infos, Parameters& parameters) {
  for (const ParameterInfo& info : infos)
    if (!info.default_value.empty() && !parameters.has(info.name))
      parameters.set(info.name, parse_value(info, info.default_value));
}

const ParameterInfo* find(const std::vector<ParameterInfo>& infos, std::string_view name) {
  const auto it = std::find_if(infos.begin(), infos.end(),
                               [&](const ParameterInfo& info) { return info.name == name; });
  return it == infos.end() ? nullptr : &*it;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& candidates) {
  const std::string typed = in_lower_case(word);
  const std::string* best = nullptr;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(typed, in_lower_case(candidate));
    if (distance < best_distance) {
      best = &candidate;
      best_distance = distance;
    }
  }
  if (best) return fmt::format("did you mean \"{}\"?", *best);
  // A part of a name, "sand" of "vmf_sand": a shorter word is a part of too many.
  constexpr std::size_t kShortest = 3, kMost = 3;
  std::string found;
  std::size_t count = 0;
  if (typed.size() >= kShortest)
    for (const std::string& candidate : candidates)
      if (has_parts(in_lower_case(candidate), typed) && ++count <= kMost)
        found += fmt::format("{}\"{}\"", count > 1 ? " or " : "", candidate);
  return count > 0 && count <= kMost ? fmt::format("did you mean {}?", found) : "";
}

std::string listed(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace lamella
