#include "compare/samples/stack_design.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "compare/request/errors.h"
#include "compare/request/numbers.h"
#include "compare/request/split_text.h"
#include "compare/request/substrate_model.h"
#include "compare/request/sweep_axis.h"
#include "phase/random/random.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

constexpr std::uint64_t kMostStacks = 1000000;

// A key, and where its values lie.
struct DesignAxis {
  std::string path;
  std::vector<double> list;  // empty: a range
  double from = 0, to = 0;
  bool logarithmic = false;
};

[[noreturn]] void refuse_axis(const std::string& text) {
  throw UsageError(
      fmt::format("--set: found \"{}\" with --design; allowed: PATH=FROM:TO[:log] or PATH=A,B,..., "
                  "PATH being layer.N.KEY (N from 0 at the top) or substrate.KEY",
                  text));
}

DesignAxis axis_of(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) refuse_axis(text);
  DesignAxis axis{.path = text.substr(0, equals), .list = {}};
  const std::vector<std::string> words = split_text(text.substr(equals + 1), ':');
  if (words.size() == 1) {
    for (const std::string& word : split_text(words[0], ',')) {
      const auto value = parse_number(word);
      if (!value) refuse_axis(text);
      axis.list.push_back(*value);
    }
    return axis;
  }
  axis.logarithmic = words.size() == 3 && words[2] == "log";
  if (words.size() != 2 && !axis.logarithmic) refuse_axis(text);
  const auto from = parse_number(words[0]), to = parse_number(words[1]);
  if (!from || !to || !std::isfinite(*from) || !std::isfinite(*to) ||
      (axis.logarithmic && !(*from > 0 && *to > 0)))
    refuse_axis(text);
  axis.from = *from;
  axis.to = *to;
  return axis;
}

std::uint64_t count_of(const std::string& text) {
  const std::string name = "latin:";
  const std::optional<std::uint64_t> count =
      parse_whole_number(text.starts_with(name) ? text.substr(name.size()) : std::string());
  const std::uint64_t stacks = count.value_or(0);
  if (stacks < 1 || stacks > kMostStacks)
    throw UsageError(fmt::format("--design: found \"{}\"; allowed: latin:COUNT, COUNT from 1 to {}",
                                 text, kMostStacks));
  return stacks;
}

// The values of an axis for all stacks.
std::vector<double> values_of(const DesignAxis& axis, std::uint64_t count, std::uint64_t seed,
                              std::uint64_t number) {
  RandomStream stream(seed, number, StreamPurpose::measure);
  std::vector<std::uint64_t> part(count);
  std::iota(part.begin(), part.end(), std::uint64_t{0});
  for (std::uint64_t k = count; k > 1; --k)
    std::swap(part[k - 1],
              part[std::min(static_cast<std::uint64_t>(static_cast<double>(k) * stream.uniform()),
                            k - 1)]);
  std::vector<double> values;
  for (const std::uint64_t p : part) {
    if (!axis.list.empty()) {
      values.push_back(axis.list[p % axis.list.size()]);
      continue;
    }
    const double t = (static_cast<double>(p) + stream.uniform()) / static_cast<double>(count);
    const double value = axis.logarithmic ? axis.from * std::pow(axis.to / axis.from, t)
                                          : axis.from + t * (axis.to - axis.from);
    values.push_back(*parse_number(fmt::format("{:.6g}", value)));
  }
  return values;
}

}  // namespace

std::vector<DesignedStack> latin_design(const Stack& stack, const std::string& text,
                                        const std::vector<std::string>& sets, std::uint64_t seed) {
  const std::uint64_t count = count_of(text);
  if (sets.empty())
    throw UsageError("--design: found no --set; allowed: --set PATH=FROM:TO[:log], repeatable");
  std::vector<SweepAxis> axes;
  for (std::size_t a = 0; a < sets.size(); ++a) {
    const DesignAxis axis = axis_of(sets[a]);
    axes.push_back({axis.path, values_of(axis, count, seed, a)});
  }
  const int digits = std::max(4, static_cast<int>(fmt::format("{}", count - 1).size()));
  std::vector<DesignedStack> stacks;
  for (std::size_t k = 0; k < count; ++k) {
    DesignedStack one{fmt::format("{:0{}}", k, digits),
                      with_values(stack, axes, std::vector<std::size_t>(axes.size(), k)),
                      {}};
    for (const SweepAxis& axis : axes) one.values.emplace_back(axis.path, axis.values[k]);
    (void)with_surface_model(
        parse_stack(one.toml, fmt::format("--design, stack {}", one.name), one.name));
    stacks.push_back(std::move(one));
  }
  return stacks;
}

}  // namespace lamella
