#include "compare/command/mapped_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compare/render/place_grid.h"
#include "compare/request/errors.h"

namespace lamella {
namespace {

Rgb color_of(const ParameterValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return Rgb(*number);
  return std::get<Rgb>(value);
}

std::vector<Rgb> colors_of(const std::vector<ParameterValue>& values) {
  std::vector<Rgb> colors;
  for (const ParameterValue& value : values) colors.push_back(color_of(value));
  return colors;
}

}  // namespace

std::vector<MapAxis> map_axes(const SurfaceStack& surface) {
  const std::vector<std::string> paths = surface.paths();
  std::vector<MapAxis> axes;
  const int columns = std::min(surface.columns(), kMostPlaces);
  const int rows = std::min(surface.rows(), kMostPlaces);
  for (int k = 0; k < columns * rows; ++k) {
    const std::vector<ParameterValue> values =
        surface.values((k % columns + 0.5) / columns, (k / columns + 0.5) / rows);
    for (std::size_t a = 0; a < values.size(); ++a) {
      if (!std::holds_alternative<double>(values[a]) && !std::holds_alternative<Rgb>(values[a]))
        throw UsageError(
            fmt::format("--table: found a map of directions, {}; allowed: maps of numbers and "
                        "colours, or a place (--at U,V)",
                        paths[a]));
      const Rgb value = color_of(values[a]);
      const auto [low, high] = std::minmax({value.r, value.g, value.b});
      if (k == 0) axes.push_back({paths[a], low, high});
      axes[a].low = std::min(axes[a].low, low);
      axes[a].high = std::max(axes[a].high, high);
    }
  }
  return axes;
}

MapTable map_table(const SurfaceStack& surface, const TruthRequest& request,
                   const std::function<Stack(Stack)>& shown, const RunMonitor& monitor) {
  const std::vector<ParameterValue> middle = surface.values(0.5, 0.5);
  const auto stack_at = [&](std::span<const double> numbers) {
    std::vector<ParameterValue> values = middle;
    for (std::size_t a = 0; a < values.size(); ++a)
      if (std::holds_alternative<double>(values[a]))
        values[a] = numbers[a];
      else
        values[a] = Rgb(numbers[a]);
    return shown(surface.with(values));
  };
  const auto report = [&](std::size_t done, std::size_t of) {
    if (monitor.progress) monitor.progress("tables over the maps", {done, of, 0});
  };
  MapTable table = MapTable::make(request, map_axes(surface), stack_at, monitor.stop, report);
  if (monitor.finished) monitor.finished();
  return table;
}

std::unique_ptr<SurfaceScatter> mapped_table_surface(const SurfaceStack& surface,
                                                     const MapTable& table,
                                                     const std::function<Stack(Stack)>& shown) {
  const auto places = std::make_shared<PlaceGrid<MapTable::Place>>(
      surface.columns(), surface.rows(), [&surface, &table, shown](double u, double v) {
        const std::vector<ParameterValue> values = surface.values(u, v);
        return std::make_unique<MapTable::Place>(
            table.place(shown(surface.with(values)), colors_of(values)));
      });
  TableOfPlaces of;
  of.towards = [&table, places](double u, double v, Direction wo) {
    return table.towards(places->at(u, v), wo);
  };
  if (table.has_specular())
    of.specular = [&table, places](double u, double v, Direction wo) {
      return table.specular(places->at(u, v), wo);
    };
  return tabulated_surface(std::move(of));
}

}  // namespace lamella
