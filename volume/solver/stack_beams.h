#pragma once

#include <functional>
#include <vector>

#include "phase/interface/dielectric.h"
#include "phase/stack/stack.h"

namespace lamella {

/// From the top: a layer, or a boundary where there is none.
struct StackElement {
  const Layer* layer;          ///< of the stack, which must outlive the element
  const Interface* interface;  ///< of the stack
  double above, below;         ///< indices of refraction

  [[nodiscard]] bool is_rough() const {
    return interface && interface->facets.shape != FacetShape::smooth;
  }
};

/// Layers of some depth, and interfaces that change the index.
[[nodiscard]] std::vector<StackElement> elements_of(const Stack& stack);
/// Those among the entries [begin, end) of its layers.
[[nodiscard]] std::vector<StackElement> elements_between(const Stack& stack, std::size_t begin,
                                                         std::size_t end);

/// A beam and all its reflections at smooth boundaries: shares of the power that arrives, at the
/// places between elements: before the first, ... after the last. Beams end at rough boundaries.
struct StackBeam {
  std::vector<double> mu;                  ///< by place; 0: totally reflected before
  std::vector<double> down, up;            ///< by place
  std::vector<double> rate_down, rate_up;  ///< by element: optical depth per depth
};

/// The beam from w, which may lie on either side. reversed: light that leaves along w, run
/// backwards. ground: the share that the substrate mirrors of what arrives there, by its cosine.
[[nodiscard]] StackBeam beam_of(
    const std::vector<StackElement>& elements, Direction w, bool reversed,
    const std::function<double(double mu)>& ground = [](double) { return 0.0; });

/// w of a medium of index `from` within a medium of index `to`, where its third component is z.
[[nodiscard]] inline Direction refracted_to(Direction w, double from, double to, double z) {
  const double scale = from / to;
  return renormalized(Direction{scale * w.x, scale * w.y, z});
}

}  // namespace lamella
