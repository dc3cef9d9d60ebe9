#include "compare/report/compare_page.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "compare/files/base64.h"
#include "compare/report/json_report.h"
#include "phase/math/degrees.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

std::string key_of(std::size_t run, bool reflected, Order order) {
  return fmt::format("{}/{}/{}", run, reflected ? "reflect" : "transmit", to_text(order));
}

std::size_t index_of(const std::vector<RunResult>& runs, Direction wi) {
  std::size_t k = 0;
  while (k + 1 < runs.size() && !(runs[k].incident == wi)) ++k;
  return k;
}

}  // namespace

std::string base64_floats(const std::vector<double>& values) {
  std::string bytes;
  bytes.reserve(values.size() * 4);
  for (const double v : values) {
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(v));
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(bits >> shift & 255);
  }
  return base64(bytes);
}

Json compare_page_details(const std::vector<RunResult>& runs,
                          const std::vector<std::vector<LobeComparison>>& models) {
  static const Order orders[] = {Order::one, Order::two,  Order::three,    Order::four_plus,
                                 Order::all, Order::zero, Order::scattered, Order::multiple};
  const CellGrid& grid = runs.front().grid;
  Json directions = Json::array(), truth = Json::object(), list = Json::array();
  for (std::size_t k = 0; k < runs.size(); ++k) {
    Json run = to_json(runs[k]);
    run["theta_i"] = theta_degrees(runs[k].incident);
    directions.push_back(std::move(run));
    for (const bool reflected : {true, false}) {
      const SideResult& side = reflected ? runs[k].reflected : runs[k].transmitted;
      for (const Order order : orders) {
        const LobeEstimate& lobe = side.lobes[order];
        if (lobe.value.empty()) continue;
        truth[key_of(k, reflected, order)] = {{"f", base64_floats(lobe.value)},
                                              {"se", base64_floats(lobe.standard_error)}};
      }
    }
  }
  for (const std::vector<LobeComparison>& lobes : models) {
    Json maps = Json::object();
    for (const LobeComparison& l : lobes)
      maps[key_of(index_of(runs, l.wi), l.reflected, l.order)] = base64_floats(l.model);
    list.push_back(std::move(maps));
  }
  return {{"grid",
           {{"mu_cells", grid.mu_cells}, {"phi_cells", grid.phi_cells}, {"folded", grid.folded}}},
          {"channels", runs.front().channels},
          {"runs", std::move(directions)},
          {"truth", std::move(truth)},
          {"models", std::move(list)}};
}

}  // namespace lamella
