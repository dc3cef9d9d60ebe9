#pragma once

#include <cstddef>
#include <vector>

#include "phase/stack/stack.h"

namespace lamella {

/// Entries [begin, end) of Stack::layers between two boundaries, all of one index of refraction,
/// through which light is followed in spherical harmonics.
struct LayerBlock {
  std::size_t begin, end;
  double index;
};

/// Whether facets or a substrate tell x from y.
[[nodiscard]] bool has_anisotropic_boundaries(const Stack& stack);

/// From the top: what lies between boundaries and holds a layer without symmetry about the normal;
/// where nothing does, all that holds a layer of some depth. What
/// lies beside a boundary that is not symmetric is a block, too, though it may hold no layer: such
/// a boundary has no others about it.
[[nodiscard]] std::vector<LayerBlock> layer_blocks(const Stack& stack);

/// The layers of a block, without what is around it.
[[nodiscard]] Stack stack_of(const Stack& stack, const LayerBlock& block);

}  // namespace lamella
