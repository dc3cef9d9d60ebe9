#pragma once

#include <functional>
#include <vector>

#include "phase/interface/dielectric.h"
#include "phase/stack/stack.h"
#include "volume/solver/order_shares.h"

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
template <class Share>
struct StackBeamOf {
  std::vector<double> mu;                  ///< by place; 0: totally reflected before
  std::vector<Share> down, up;             ///< by place
  std::vector<double> rate_down, rate_up;  ///< by element: optical depth per depth
};
using StackBeam = StackBeamOf<double>;

/// The share that the substrate mirrors of what arrives there, by its cosine.
using MirroringGround = std::function<double(double mu)>;

/// The beam from w, which may lie on either side. reversed: light that leaves along w, run
/// backwards.
[[nodiscard]] StackBeam beam_of(
    const std::vector<StackElement>& elements, Direction w, bool reversed,
    const MirroringGround& ground = [](double) { return 0.0; });
/// The same by order: what the substrate mirrors has met one more event.
[[nodiscard]] StackBeamOf<OrderShares> beam_by_order(const std::vector<StackElement>& elements,
                                                     Direction w, const MirroringGround& ground);

/// The substrate of a stack in one channel: it mirrors where it is a smooth conductor.
[[nodiscard]] MirroringGround ground_of(const Stack& stack, int channel);

/// w of a medium of index `from` within a medium of index `to`, where its third component is z.
[[nodiscard]] inline Direction refracted_to(Direction w, double from, double to, double z) {
  const double scale = from / to;
  return renormalized(Direction{scale * w.x, scale * w.y, z});
}

}  // namespace lamella
