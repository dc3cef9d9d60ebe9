#include "volume/grid_walk/grid_scorers.h"

#include "volume/grid_walk/grid_march.h"

namespace lamella {

double estimated_transmittance(const GridWalkStack& stack, const Place& at, Direction w,
                               RandomStream& stream) {
  return transmittance(stack, at, w, [&](const GridWalkLayer& l, const Place& in) {
    return std::visit(
        [&]<class M>(const M&) {
          return ratio_tracked<M>(*l.grid, in.x, in.y, l.thickness - in.z, w, stream);
        },
        l.grid->palette()[0]);
  });
}

}  // namespace lamella
