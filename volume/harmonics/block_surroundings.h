#pragma once

#include <Eigen/Core>
#include <deque>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "volume/adding/pile_modes.h"
#include "volume/harmonics/anisotropic_boundary.h"
#include "volume/harmonics/layer_blocks.h"
#include "volume/solver/stack_beams.h"

namespace lamella {

/// What meets light of one order: events that raise the order by `raise`, or by more than that
/// (`beyond`), or by any number.
struct OrderStep {
  enum class Kind { by, beyond, any } kind = Kind::by;
  int raise = 0;
};

/// What light becomes between blocks and outside, as waves. Rows: the nodes of the medium, then the
/// cosines that were asked for.
struct SurroundedLight {
  std::vector<FaceLight> entering;  ///< by block: down at its top, up at its bottom
  FaceLight outside;                ///< that leaves: up above the stack, down below it

  SurroundedLight& operator+=(const SurroundedLight& other);
};

/// A beam of one order that arrives, by block: the shares of its power at the faces. Where there is
/// no block above or below, the outside.
struct ArrivingBeam {
  double azimuth = 0;        ///< of the way that it goes
  std::vector<double> down;  ///< by pile: that arrives from above, reflections included
  std::vector<double> up;    ///< by pile: that arrives from below
};

/// Operators of interfaces that are not symmetric, which colour channels share at one resolution
/// and for the same asked cosines: by pile, once they are made.
using SharedBoundaries =
    std::map<std::size_t, std::shared_ptr<const AnisotropicBoundary::Operators>>;

/// What lies around the blocks of a stack in one colour channel: piles of boundaries and of layers
/// that are symmetric about the normal, as operators by azimuthal mode (volume/adding), or one
/// boundary alone that is not. Pile k lies above block k; the last one, below them all, may be
/// closed.
class BlockSurroundings {
 public:
  /// modes: of the azimuth; degree: the highest wave of boundaries that are not symmetric.
  /// asked_out, asked_in: cosines outside, each with the index of its medium. shared: or nothing.
  BlockSurroundings(const Stack& stack, int channel, std::vector<LayerBlock> blocks, int nodes,
                    int modes, int degree, std::span<const AskedCosine> asked_out,
                    std::span<const AskedCosine> asked_in, Isa isa,
                    SharedBoundaries* shared = nullptr);

  [[nodiscard]] const std::vector<LayerBlock>& blocks() const { return blocks_; }
  /// The directions within a block; of the media above and below the stack.
  [[nodiscard]] const DirectionSets& sets(std::size_t block) const;
  [[nodiscard]] const DirectionSets& top() const { return *piles_.front().front().top; }
  [[nodiscard]] const DirectionSets& bottom() const { return *piles_.back().front().bottom; }
  [[nodiscard]] bool is_closed() const { return !piles_.back().front().is_open; }
  [[nodiscard]] int waves() const { return 2 * static_cast<int>(piles_.front().size()) - 1; }

  /// Bytes that the operators hold.
  [[nodiscard]] std::size_t bytes() const;

  /// What becomes of light that leaves the blocks (waves at the nodes).
  [[nodiscard]] SurroundedLight from_blocks(const std::vector<FaceLight>& leaving,
                                            OrderStep step) const;
  /// And of a beam along the asked cosine `in`, beams apart.
  [[nodiscard]] SurroundedLight from_beam(const ArrivingBeam& beam, std::size_t in,
                                          OrderStep step) const;
  /// What boundaries that are not symmetric send along asked cosines: adds to `around` by order,
  /// given what leaves the blocks; step: from one order to another.
  void add_asked(std::span<const std::vector<FaceLight>> leaving, std::span<SurroundedLight> around,
                 const std::function<OrderStep(int from, int to)>& step) const;
  /// Shares of the light that leaves the blocks, and of a beam, which the piles take.
  struct Taken {
    double absorbed = 0, lost = 0;
  };
  [[nodiscard]] Taken taken(const std::vector<FaceLight>& leaving) const;
  [[nodiscard]] Taken taken(const ArrivingBeam& beam, std::size_t in) const;

  /// Share of light that leaves a block through its top (else its bottom) that is mirrored back
  /// there: at a row of its sets; at any cosine, by smooth boundaries, which keep its order.
  [[nodiscard]] double mirror(std::size_t block, bool at_top, Eigen::Index row,
                              OrderStep step = {}) const;
  [[nodiscard]] double mirror_at(std::size_t block, bool at_top, double mu) const;
  /// Radiance that goes straight on from a block through the pile above it (else below it), over
  /// what arrives at a row of its sets.
  [[nodiscard]] double through(std::size_t block, bool up, Eigen::Index row) const;

 private:
  using Pile = std::vector<PileOperator>;  // by mode
  std::vector<LayerBlock> blocks_;
  std::deque<PileModes> modes_;      // keep the sets of directions
  std::deque<DirectionSets> plain_;  // where a pile is nothing
  // What arrives at a pile.
  [[nodiscard]] FaceLight arriving_at(std::size_t pile,
                                      const std::vector<FaceLight>& leaving) const;

  std::vector<Pile> piles_;
  std::vector<std::unique_ptr<AnisotropicBoundary>> anisotropic_;  // by pile, or nothing
  std::vector<std::vector<StackElement>> elements_;                // by pile
};

}  // namespace lamella
