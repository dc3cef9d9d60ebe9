#include "compare/nearest/parametric_stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/request/errors.h"
#include "compare/request/numbers.h"
#include "compare/request/split_text.h"
#include "compare/request/substrate_model.h"
#include "compare/request/sweep_axis.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

[[noreturn]] void refuse(const std::string& text) {
  throw UsageError(
      fmt::format("--vary: found \"{}\"; allowed: PATH=FROM:TO[:log], PATH being layer.N.KEY (N "
                  "from 0 at the top) or substrate.KEY",
                  text));
}

bool is_color_key(const std::string& path) {
  const std::string key = path.substr(path.rfind('.') + 1);
  return key == "albedo" || key == "f0" || key == "eta" || key == "k";
}

// The stack's own value of a key, of a channel; nothing where the file has none or no number.
std::optional<double> own_value(const Stack& stack, const std::string& path, int channel) {
  const std::optional<std::string> text = text_at(stack, path, "--vary");
  if (!text || text->empty()) return std::nullopt;
  if (text->front() != '[') return parse_number(*text);
  const std::vector<std::string> parts = split_text(text->substr(1, text->size() - 2), ',');
  const auto k = static_cast<std::size_t>(std::max(channel, 0));
  return k < parts.size() ? parse_number(parts[k]) : std::nullopt;
}

FreeNumber free_number(const Stack& stack, const std::string& path, int channel, double from,
                       double to, bool logarithmic) {
  FreeNumber free{.key = path,
                  .channel = channel,
                  .is_color = channel >= 0,
                  .low = from,
                  .high = to,
                  .is_logarithmic = logarithmic};
  const std::optional<double> own = own_value(stack, path, channel);
  free.standard = own && *own >= from && *own <= to ? free.scaled(*own) : 0.5;
  return free;
}

}  // namespace

std::string ParametricStack::toml(std::span<const double> scaled) const {
  std::vector<std::pair<std::string, std::string>> texts;
  for (std::size_t k = 0; k < free.size(); ++k) {
    const std::string value = fmt::format("{:.12g}", free[k].value(scaled[k]));
    if (free[k].channel < 0)
      texts.emplace_back(free[k].key, value);
    else if (free[k].channel == 0)
      texts.emplace_back(free[k].key, fmt::format("[{}", value));
    else
      texts.back().second += fmt::format(", {}{}", value, free[k].channel == 2 ? "]" : "");
  }
  return with_texts(stack, texts, "--vary");
}

Stack ParametricStack::at(std::span<const double> scaled) const {
  return with_surface_model(parse_stack(toml(scaled), "--vary", stack.name));
}

ParametricStack parametric_stack(const Stack& stack, const std::vector<std::string>& vary,
                                 int channels) {
  if (vary.empty())
    throw UsageError("--stack: found no --vary; allowed: --vary PATH=FROM:TO[:log], repeatable");
  ParametricStack parametric{stack, {}};
  for (const std::string& text : vary) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) refuse(text);
    const std::string path = text.substr(0, equals);
    const std::vector<std::string> words = split_text(text.substr(equals + 1), ':');
    const bool logarithmic = words.size() == 3 && words[2] == "log";
    if (words.size() != 2 && !logarithmic) refuse(text);
    const auto from = parse_number(words[0]), to = parse_number(words[1]);
    if (!from || !to || !(*from < *to) || !std::isfinite(*from) || !std::isfinite(*to) ||
        (logarithmic && !(*from > 0)))
      refuse(text);
    for (const FreeNumber& free : parametric.free)
      if (free.key == path)
        throw UsageError(fmt::format("--vary: found the path \"{}\" twice; allowed: once", path));
    const bool per_channel = channels == 3 && is_color_key(path);
    for (int c = per_channel ? 0 : -1; c < (per_channel ? 3 : 0); ++c)
      parametric.free.push_back(free_number(stack, path, c, *from, *to, logarithmic));
  }
  // Both ends of every range can be read.
  const std::vector<double> low(parametric.free.size(), 0.0), high(parametric.free.size(), 1.0);
  (void)parametric.at(low);
  (void)parametric.at(high);
  return parametric;
}

}  // namespace lamella
