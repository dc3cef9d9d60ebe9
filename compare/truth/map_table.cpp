#include "compare/truth/map_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "compare/request/errors.h"
#include "phase/stack/stack_file.h"
#include "volume/solver/closed_orders.h"

namespace lamella {
namespace {

// The cubic through the four equally spaced nodes nearest to a place from 0 to nodes - 1: what each
// of all nodes counts.
std::vector<double> cubic_weights(double place, int nodes) {
  const int from = std::clamp(static_cast<int>(place) - 1, 0, nodes - 4);
  const double x = place - from;
  std::vector<double> weights(static_cast<std::size_t>(nodes), 0.0);
  const auto w = weights.begin() + from;
  w[0] = -(x - 1) * (x - 2) * (x - 3) / 6;
  w[1] = x * (x - 2) * (x - 3) / 2;
  w[2] = -x * (x - 1) * (x - 3) / 2;
  w[3] = x * (x - 1) * (x - 2) / 6;
  return weights;
}

}  // namespace

MapTable MapTable::make(TruthRequest request, std::vector<MapAxis> axes, const StackAt& stack_at,
                        const StopFlag* stop, const Report& report) {
  if (axes.empty() || axes.size() > kMostAxes) {
    std::vector<std::string> paths;
    for (const MapAxis& axis : axes) paths.push_back(axis.path);
    throw UsageError(
        fmt::format("--table: found {} numbers that maps move ({}); allowed: 1 to {}, over which a "
                    "table is made, or a place (--at U,V)",
                    axes.size(), fmt::join(paths, ", "), kMostAxes));
  }
  MapTable out;
  out.axes_ = std::move(axes);
  out.nodes_ = out.axes_.size() == 1 ? kNodesOfOne : kNodesOfTwo;
  const auto nodes = static_cast<std::size_t>(out.nodes_);
  const std::size_t count = out.axes_.size() == 1 ? nodes : nodes * nodes;
  std::map<std::string, std::size_t> there;
  for (std::size_t k = 0; k < count; ++k) {
    std::array<double, kMostAxes> numbers{};
    std::size_t left = k;
    for (std::size_t a = 0; a < out.axes_.size(); ++a) {
      const double x = static_cast<double>(left % nodes) / static_cast<double>(nodes - 1);
      numbers[a] = (1 - x) * out.axes_[a].low + x * out.axes_[a].high;
      left /= nodes;
    }
    request.stack = stack_at(std::span(numbers).first(out.axes_.size()));
    const auto [known, is_new] = there.try_emplace(to_toml(request.stack), out.tables_.size());
    out.of_node_.push_back(known->second);
    if (!is_new) continue;
    if (report) report(k, count);
    check_preview("preview --table", request.stack);
    out.tables_.push_back(LobeTable::make(request, stop));
    if (!out.tables_.back().is_like(out.tables_.front()))
      throw UsageError(
          fmt::format("--table: found maps with which surfaces of {} turn from smooth to rough; "
                      "allowed: roughness of {} or more everywhere, or below it everywhere",
                      request.stack.name, kLeastLobe));
  }
  std::vector<std::string> told;
  for (const MapAxis& axis : out.axes_)
    told.push_back(fmt::format("{} from {:.4g} to {:.4g}", axis.path, axis.low, axis.high));
  out.source_ = fmt::format("{} tables over {} ({})", out.tables_.size(), fmt::join(told, " and "),
                            out.tables_.front().source());
  return out;
}

MapTable::Place MapTable::place(const Stack& stack, std::span<const Rgb> values) const {
  Place place{LobeTable::drawn_stack(stack), std::vector<Rgb>(of_node_.size(), Rgb(1))};
  for (int c = 0; c < 3; ++c) {
    std::size_t stride = 1;
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      const double range = axes_[a].high - axes_[a].low;
      const double x = range > 0 ? (values[a][c] - axes_[a].low) / range : 0;
      const std::vector<double> weights =
          cubic_weights(std::clamp(x, 0.0, 1.0) * (nodes_ - 1), nodes_);
      for (std::size_t k = 0; k < of_node_.size(); ++k)
        place.weights[k][c] *= weights[k / stride % weights.size()];
      stride *= weights.size();
    }
  }
  return place;
}

std::function<Rgb(Direction)> MapTable::towards(const Place& place, Direction wo) const {
  std::vector<std::pair<Rgb, std::function<Rgb(Direction)>>> parts;
  std::vector<Rgb> weights(tables_.size());
  for (std::size_t k = 0; k < of_node_.size(); ++k) weights[of_node_[k]] += place.weights[k];
  for (std::size_t t = 0; t < tables_.size(); ++t)
    if (weights[t] != Rgb()) parts.emplace_back(weights[t], tables_[t].rest_towards(wo));
  return [this, &place, o = raised_to(wo, HalfVectorGrid::kLeastMu),
          parts = std::move(parts)](Direction wi) {
    Rgb rest;
    for (const auto& [weight, part] : parts) rest += weight * part(wi);
    for (int c = 0; c < 3; ++c) rest[c] = std::max(rest[c], 0.0);
    const Direction i = raised_to(wi, HalfVectorGrid::kLeastMu);
    return rest + tables_.front().closed_of(place.stack, i, o);
  };
}

Rgb MapTable::specular(const Place& place, Direction wo) const {
  return mirrored_share(place.stack, raised_to(wo, HalfVectorGrid::kLeastMu));
}

}  // namespace lamella
