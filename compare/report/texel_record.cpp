#include "compare/report/texel_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "compare/request/errors.h"
#include "compare/request/substrate_model.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

constexpr const char* kTexelLine = "# texel\n";

std::vector<Stack> stacks_in(const std::string& text, const std::string& path,
                             const std::string& name) {
  std::vector<Stack> stacks;
  const std::string line = kTexelLine;
  for (std::size_t at = text.find(line); at != std::string::npos;) {
    const std::size_t from = at + line.size();
    at = text.find(line, from);
    stacks.push_back(with_surface_model(
        parse_stack(text.substr(from, at == std::string::npos ? at : at - from), path, name)));
  }
  return stacks;
}

std::optional<std::vector<TruthRequest::SolverEnd>> ends_in(const std::string& text,
                                                            std::size_t count) {
  std::vector<TruthRequest::SolverEnd> ends;
  std::istringstream words(text);
  for (std::size_t k = 0; k < count; ++k) {
    TruthRequest::SolverEnd end{0, {}, std::nullopt};
    int from = 0;
    if (!(words >> end.nodes >> end.modes[0] >> end.modes[1] >> end.modes[2] >> from))
      return std::nullopt;
    if (from >= 0) end.integrated_from = from;
    ends.push_back(end);
  }
  return ends;
}

}  // namespace

void record_texels(ExrImage& image, const TruthRequest& request,
                   const std::vector<TruthRequest::SolverEnd>& ends) {
  if (request.texels.empty()) return;
  const std::size_t count = ends.empty() ? request.texels.size() : ends.size();
  std::vector<std::string> texts;
  std::string stacks, places, of_ends;
  for (std::size_t k = 0; k < count; ++k) {
    const std::string text = to_toml(request.texels[k]);
    const auto there = std::find(texts.begin(), texts.end(), text);
    places += fmt::format("{}{}", k ? " " : "", there - texts.begin());
    if (there != texts.end()) continue;
    texts.push_back(text);
    stacks += kTexelLine + text + (text.ends_with('\n') ? "" : "\n");
    if (ends.empty()) continue;
    const TruthRequest::SolverEnd& end = ends[k];
    of_ends += fmt::format("{} {} {} {} {}\n", end.nodes, end.modes[0], end.modes[1], end.modes[2],
                           end.integrated_from.value_or(-1));
  }
  image.attributes["lamella.texel_stacks"] = stacks;
  image.attributes["lamella.texel_places"] = places;
  if (!ends.empty()) image.attributes["lamella.texel_ends"] = of_ends;
}

TexelRecord read_texels(const ExrImage& image, const std::string& path) {
  if (!image.attributes.contains("lamella.texels")) return {};
  const auto text = [&](const std::string& name) {
    const auto found = image.attributes.find("lamella." + name);
    return found == image.attributes.end() ? std::string() : found->second;
  };
  const auto refuse = [&](const std::string& what) -> UsageError {
    return UsageError(
        fmt::format("{}: it is the mean over {} texels of a map, {}; allowed: a file "
                    "that lamella simulate or compare wrote, as it was written",
                    path, text("texels"), what));
  };
  const std::vector<Stack> stacks = stacks_in(text("texel_stacks"), path, text("stack_name"));
  if (stacks.empty()) throw refuse("which are not recorded");
  TexelRecord record;
  const bool solved = image.attributes.contains("lamella.texel_ends");
  const auto ends = ends_in(text("texel_ends"), solved ? stacks.size() : 0);
  if (!ends) throw refuse("but lamella.texel_ends is damaged");
  std::istringstream places(text("texel_places"));
  for (std::size_t place = 0; places >> place;) {
    if (place >= stacks.size()) throw refuse("but lamella.texel_places is damaged");
    record.texels.push_back(stacks[place]);
    if (solved) record.ends.push_back((*ends)[place]);
  }
  if (record.texels.empty() || !places.eof()) throw refuse("but lamella.texel_places is damaged");
  return record;
}

}  // namespace lamella
