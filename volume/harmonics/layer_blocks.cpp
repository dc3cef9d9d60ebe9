#include "volume/harmonics/layer_blocks.h"

#include <algorithm>

namespace lamella {

std::vector<LayerBlock> layer_blocks(const Stack& stack) {
  std::vector<LayerBlock> filled, turned;
  const std::size_t size = stack.layers.size();
  std::size_t begin = 0;
  for (std::size_t k = 0; k <= size; ++k) {
    if (k < size &&
        !(stack.layers[k].interface && stack.layers[k].interface->ior != stack.index_of(k)))
      continue;
    const auto any = [&](auto&& holds) {
      return std::any_of(stack.layers.begin() + static_cast<std::ptrdiff_t>(begin),
                         stack.layers.begin() + static_cast<std::ptrdiff_t>(k),
                         [&](const Layer& layer) {
                           return !layer.interface && layer.depth() > 0 && holds(layer);
                         });
    };
    const LayerBlock block{begin, k, stack.index_of(begin)};
    if (any([](const Layer&) { return true; })) filled.push_back(block);
    if (any([](const Layer& layer) { return !traits(layer.medium).symmetric_about_z; }))
      turned.push_back(block);
    begin = k + 1;
  }
  return turned.empty() ? filled : turned;
}

Stack stack_of(const Stack& stack, const LayerBlock& block) {
  Stack inner;
  for (std::size_t k = block.begin; k < block.end; ++k)
    if (!stack.layers[k].interface) inner.layers.push_back(stack.layers[k]);
  return inner;
}

}  // namespace lamella
