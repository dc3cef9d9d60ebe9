#include "compare/reproduce/reproduction.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "compare/report/wrapped_text.h"

namespace lamella {

const std::vector<std::string>& quality_names() {
  static const std::vector<std::string> names{"draft", "quick", "final"};
  return names;
}

Quality quality_from_text(const std::string& name) {
  const auto& names = quality_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw std::invalid_argument("quality: " + name);
  return static_cast<Quality>(found - names.begin());
}

std::uint64_t Reproduction::walks_of(Quality quality) const {
  if (walks == 1 || quality == Quality::quick) return walks;
  return quality == Quality::final ? 10 * walks : std::max<std::uint64_t>(1, walks / 100);
}

void ReproductionContext::write(const std::string& name, const Chart& chart) {
  write(name, [&](PictureFormat format) { return draw_chart(chart, format); });
}

void ReproductionContext::write(const std::string& name,
                                const std::function<std::string(PictureFormat)>& draw) {
  for (const std::string& path : write_pictures(folder + "/" + name, formats, draw))
    pictures.push_back(std::filesystem::path(path).filename().string());
}

void ReproductionContext::say(const std::string& text) const {
  if (!table) return;
  fmt::print(table, "{}", text);
  std::fflush(table);
}

void ReproductionContext::find(const std::string& paper, const std::string& here, bool agrees) {
  say(fmt::format("\n{}{}", wrapped("the paper: ", paper, 2),
                  wrapped(agrees ? "agrees: " : "does not agree: ", here, 2)));
  findings.push_back({paper, here, agrees});
}

}  // namespace lamella
