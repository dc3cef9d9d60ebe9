#pragma once

#include <functional>
#include <memory>

#include "compare/maps/surface_stack.h"
#include "compare/render/surface_scatter.h"
#include "compare/request/run_monitor.h"
#include "compare/truth/map_table.h"

namespace lamella {

/// What the maps of a surface move, over the places that pictures show (PlaceGrid): numbers and
/// colours, the latter from the least to the greatest of any channel. Throws UsageError for a map
/// of directions.
[[nodiscard]] std::vector<MapAxis> map_axes(const SurfaceStack& surface);

/// The reflection of a stack with maps by tables over what its maps move. `shown`: what is drawn of
/// a place's stack. Surface and table must outlive it.
[[nodiscard]] MapTable map_table(const SurfaceStack& surface, const TruthRequest& request,
                                 const std::function<Stack(Stack)>& shown,
                                 const RunMonitor& monitor);
[[nodiscard]] std::unique_ptr<SurfaceScatter> mapped_table_surface(
    const SurfaceStack& surface, const MapTable& table, const std::function<Stack(Stack)>& shown);

}  // namespace lamella
