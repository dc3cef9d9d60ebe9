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

/// From the top: what lies between boundaries and holds a layer without symmetry about the normal;
/// where nothing does, all that holds a layer of some depth.
[[nodiscard]] std::vector<LayerBlock> layer_blocks(const Stack& stack);

/// The layers of a block, without what is around it.
[[nodiscard]] Stack stack_of(const Stack& stack, const LayerBlock& block);

}  // namespace lamella
