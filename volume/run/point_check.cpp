#include "volume/run/point_check.h"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>

namespace lamella {

void require_aimable(const Stack& stack) {
  std::optional<std::size_t> delta;
  bool others = false;
  for (std::size_t k = 0; k < stack.layers.size(); ++k) {
    const Layer& layer = stack.layers[k];
    if (layer.interface) {
      others = others || layer.interface->facets.shape != FacetShape::smooth;
    } else if (layer.depth() > 0) {
      if (!is_delta(layer.medium))
        others = true;
      else if (!delta)
        delta = k;
    }
  }
  if (const auto& substrate = stack.substrate) {
    const bool lambert = substrate->model.empty() && !substrate->law;
    others = others || (lambert ? substrate->albedo != Rgb(0)
                                : !(substrate->law && substrate->law->is_delta()));
  }
  if (!delta || !others) return;
  throw std::invalid_argument(fmt::format(
      "f at points of a stack whose layer {} has mirror flakes of roughness 0 beside other "
      "scatterers; allowed: no such flakes, or lobes on cells (lamella simulate, compare)",
      *delta));
}

}  // namespace lamella
