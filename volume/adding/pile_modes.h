#pragma once

#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "volume/adding/rough_boundary.h"
#include "volume/adding/rough_crossing.h"
#include "volume/adding/stack_modes.h"

namespace lamella {

/// Entries [begin, end) of a stack's layers, and whether its substrate lies below them.
struct PileRange {
  std::size_t begin, end;
  bool has_ground;
};

/// The operator of a stack with boundaries (Stack::has_boundaries), mode by mode: layers by
/// doubling, each on the nodes of its medium, and boundaries between them.
class PileModes : public StackSolver {
 public:
  /// asked: cosines above the stack and below it, each with the index of its medium. orders: how
  /// many of the orders 1 to 3 to keep apart.
  PileModes(const Stack& stack, int channel, int nodes, std::span<const AskedCosine> asked_out,
            std::span<const AskedCosine> asked_in, int orders, Isa isa);
  /// Of a part of a stack alone, on the directions that serve all of it. A part that is empty has a
  /// ground.
  PileModes(const Stack& stack, int channel, int nodes, std::span<const AskedCosine> asked_out,
            std::span<const AskedCosine> asked_in, int orders, Isa isa, PileRange range);

  void prepare(int modes) override;
  bool prepare_more(std::size_t max_bytes) override;
  [[nodiscard]] int ready() const override { return ready_; }
  [[nodiscard]] std::size_t bytes() const override { return bytes_of(ready_); }
  [[nodiscard]] AskedMode asked_mode(int m) const override;
  /// One mode between all directions, nodes and those that were asked for.
  [[nodiscard]] PileOperator operator_at(int m) const { return pile(m); }
  /// Gives the memory of the kernels back; the sets of directions stay. `prepare` makes them again.
  void forget_kernels();

 private:
  // A medium at one albedo in one index of refraction.
  struct Kind {
    const Layer* layer;
    const DirectionSets* sets;
    std::optional<LayerScattering> scattering;
  };
  struct Slab {
    std::size_t kind;
    double depth;
  };
  // From the top: a layer (slab), or a boundary between two media.
  struct Element {
    std::optional<std::size_t> slab;
    const Interface* interface = nullptr;
    const DirectionSets *above, *below;
    const Layer* layer = nullptr;  // of a slab
    std::optional<RoughBoundary> rough{};
  };

  void make_kernels(int modes);
  [[nodiscard]] std::size_t bytes_of(int modes) const;
  [[nodiscard]] const DirectionSets& sets_of(double index) const;
  [[nodiscard]] PileOperator element(const Element& e, int m) const;
  [[nodiscard]] PileOperator ground(int m) const;
  [[nodiscard]] PileOperator pile(int m) const;
  // Whether the stack is layers between two rough boundaries.
  [[nodiscard]] bool is_rough_plate() const;
  // Puts what RoughCrossing has in the place of the sum over nodes.
  void correct_crossing(AskedMode& mode, int m) const;

  const Stack& stack_;
  int channel_, orders_;
  Isa isa_;
  PileRange range_;
  int ready_ = 0;
  std::deque<DirectionSets> sets_;  // by index of refraction
  const DirectionSets *top_, *bottom_;
  std::vector<Kind> kinds_;
  std::vector<Slab> slabs_;
  std::vector<Element> elements_;
  std::optional<Ground> ground_;  // a law's
  std::optional<RoughCrossing> crossing_;
};

/// The indices of refraction of a stack's media, distinct and ascending.
[[nodiscard]] std::vector<double> indices_of(const Stack& stack);

}  // namespace lamella
