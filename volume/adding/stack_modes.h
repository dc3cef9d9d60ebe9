#pragma once

#include <optional>
#include <span>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/adding/layer_operator.h"
#include "volume/adding/modal_layer.h"
#include "volume/adding/stack_solver.h"

namespace lamella {

/// The map of nodes that a stack converges fastest with: a knee where particles have a narrow peak.
[[nodiscard]] GrazingMap grazing_map(const Stack& stack);

/// The operator of a whole stack, mode by mode, for one colour channel on fixed directions. Equal
/// layers are solved once.
class StackModes : public StackSolver {
 public:
  /// orders: how many of the orders 1 to 3 to keep apart. isa: of products of matrices.
  StackModes(const Stack& stack, int channel, DirectionSets sets, int orders, Isa isa);

  void prepare(int modes) override;
  bool prepare_more(std::size_t max_bytes) override;
  [[nodiscard]] int ready() const override { return ready_; }
  /// One mode between all directions; several may be asked for at once.
  [[nodiscard]] LayerOperator mode(int m) const;
  [[nodiscard]] AskedMode asked_mode(int m) const override;
  [[nodiscard]] AskedMode asked_series(int m) const override;
  [[nodiscard]] const DirectionSets& sets() const { return sets_; }
  /// Largest relative correction of a node's kernel that conservation of energy asked for.
  [[nodiscard]] double correction() const;
  /// Bytes held by the kernels' modes; what they would be for that many.
  [[nodiscard]] std::size_t bytes() const override { return bytes_of(ready_); }
  [[nodiscard]] std::size_t bytes_of(int modes) const;

 private:
  struct Kind {
    const Layer* layer;
    std::vector<LayerScattering> scattering;  // none until asked for
  };
  struct Slab {
    std::size_t kind;
    double depth;
  };

  void make_kernels(int modes);
  // The layers one over another; solved: by slab.
  [[nodiscard]] LayerOperator pile(std::span<const LayerOperator> solved,
                                   const OperatorRules& rules) const;
  // By the eigenmodes of the layers, where all have them, without energies.
  [[nodiscard]] std::optional<AskedMode> asked_by_eigenmodes(int m) const;

  const Stack& stack_;
  int channel_;
  DirectionSets sets_;
  int orders_;
  Isa isa_;
  int ready_ = 0;  // modes that the kernels hold
  std::vector<Kind> kinds_;
  std::vector<Slab> slabs_;          // distinct pairs of kind and depth
  std::vector<std::size_t> layers_;  // index into slabs_, top down
  std::vector<ModalLayer> modal_;    // by slab; none where a medium has no eigenmodes
};

}  // namespace lamella
