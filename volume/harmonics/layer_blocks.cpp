#include "volume/harmonics/layer_blocks.h"

#include <algorithm>

namespace lamella {

bool has_anisotropic_boundaries(const Stack& stack) {
  return (stack.substrate && stack.substrate->law &&
          !stack.substrate->law->is_symmetric_about_z()) ||
         std::any_of(stack.layers.begin(), stack.layers.end(), [](const Layer& layer) {
           return layer.interface &&
                  layer.interface->facets.alpha_x != layer.interface->facets.alpha_y;
         });
}

std::vector<LayerBlock> layer_blocks(const Stack& stack) {
  std::vector<LayerBlock> filled, turned;
  const std::size_t size = stack.layers.size();
  const auto is_anisotropic = [&](std::size_t k) {
    return k < size &&
           stack.layers[k].interface->facets.alpha_x != stack.layers[k].interface->facets.alpha_y;
  };
  const bool has_anisotropic_ground =
      stack.substrate && stack.substrate->law && !stack.substrate->law->is_symmetric_about_z();
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
    const bool is_filled = any([](const Layer&) { return true; });
    if (is_filled) filled.push_back(block);
    const bool is_inner = begin > 0 && (k < size || stack.substrate);
    const bool is_beside = (begin > 0 && is_anisotropic(begin - 1)) || is_anisotropic(k);
    if (any([](const Layer& layer) { return !traits(layer.medium).symmetric_about_z; }) ||
        (is_beside && (is_filled || is_inner)) || (k == size && has_anisotropic_ground))
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
