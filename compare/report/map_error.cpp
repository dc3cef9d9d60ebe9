#include "compare/report/map_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace lamella {
namespace {

using Energy = std::array<Estimate, 3>;

std::array<std::pair<std::string_view, const Energy*>, 4> energies_of(const RunResult& run) {
  return {{{"reflected", &run.reflected.total},
           {"transmitted", &run.transmitted.total},
           {"uncollided", &run.uncollided},
           {"absorbed", &run.absorbed}}};
}

}  // namespace

std::string map_error_text(const RunResult& map_error, int indent) {
  std::string text;
  for (const auto& [name, energy] : energies_of(map_error)) {
    double worst = 0;
    for (int c = 0; c < map_error.channels; ++c)
      worst = std::max(worst, (*energy)[c].standard_error);
    if (worst > 0) text += fmt::format("{}{} +- {:.1g}", text.empty() ? "" : ", ", name, worst);
  }
  if (text.empty()) text = "nothing, as neighbouring texels are the same";
  return fmt::format("{:{}}texels       as a sample of the map: {}\n", "", indent, text);
}

nlohmann::ordered_json map_error_json(const RunResult& map_error) {
  nlohmann::ordered_json out;
  for (const auto& [name, energy] : energies_of(map_error)) {
    auto& list = out[std::string(name)] = nlohmann::ordered_json::array();
    for (int c = 0; c < map_error.channels; ++c) list.push_back((*energy)[c].standard_error);
  }
  return out;
}

}  // namespace lamella
