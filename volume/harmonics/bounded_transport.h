#pragma once

#include <Eigen/Core>
#include <deque>
#include <span>
#include <vector>

#include "volume/harmonics/block_surroundings.h"
#include "volume/harmonics/block_transport.h"
#include "volume/harmonics/sphere_grid.h"

namespace lamella {

/// Light within the blocks and through their faces: coefficients of the source functions, by block,
/// and what enters (grid: rows nodes, columns azimuths).
struct BoundedSource {
  std::vector<Eigen::MatrixXd> coefficients;
  std::vector<FaceLight> entering;
};

/// What light does between two events.
struct BoundedStep {
  std::vector<Eigen::MatrixXd> scattered;  ///< coefficients of what it becomes a source of
  std::vector<FaceLight> leaving;          ///< through the faces of the blocks (grid)
  double absorbed = 0;                     ///< in the blocks
};

/// Light in a stack with boundaries, in one colour channel: blocks of layers of any axes, in
/// spherical harmonics, and between them piles that are symmetric about the normal.
class BoundedTransport {
 public:
  /// asked: cosines outside along which light is asked for; incident: of beams. kernels: as
  /// HarmonicTransport has them. shared: as BlockSurroundings has them.
  BoundedTransport(const Stack& stack, int channel, const HarmonicResolution& resolution,
                   std::span<const AskedCosine> asked, std::span<const Direction> incident,
                   const LayerKernels* kernels = nullptr, SharedBoundaries* shared = nullptr);

  [[nodiscard]] const HarmonicBasis& basis() const { return basis_; }
  [[nodiscard]] const HarmonicResolution& resolution() const { return resolution_; }
  [[nodiscard]] MatrixProduct product() const { return MatrixProduct(resolution_.isa); }
  [[nodiscard]] const BlockSurroundings& surroundings() const { return surroundings_; }
  [[nodiscard]] std::size_t blocks() const { return blocks_.size(); }
  [[nodiscard]] const BlockTransport& block(std::size_t b) const { return blocks_[b].transport; }
  /// Its layers alone.
  [[nodiscard]] const Stack& layers(std::size_t b) const { return blocks_[b].stack; }
  [[nodiscard]] const SphereGrid& grid(std::size_t b) const { return blocks_[b].grid; }
  [[nodiscard]] int azimuths() const { return azimuths_; }
  [[nodiscard]] const std::vector<StackElement>& elements() const { return elements_; }
  [[nodiscard]] const MirroringGround& ground() const { return ground_; }
  /// Places of StackBeam above and below a block.
  [[nodiscard]] std::size_t place_above(std::size_t b) const { return blocks_[b].above; }
  [[nodiscard]] std::size_t place_below(std::size_t b) const { return blocks_[b].below; }

  /// One step of a source; with_scattered: else `scattered` stays empty and nothing is absorbed.
  [[nodiscard]] BoundedStep follow(const BoundedSource& source, bool with_scattered) const;
  /// Share of light along direction k of a block's grid that crosses the block.
  [[nodiscard]] double crossing(std::size_t b, int k) const { return blocks_[b].crossing[k]; }
  /// What enters the blocks at last where `first` does and light may be reflected and refracted
  /// between them (order 0) while it crosses them; emitted: that leaves them of itself.
  [[nodiscard]] std::vector<FaceLight> settled(const std::vector<FaceLight>& first,
                                               const std::vector<FaceLight>& emitted) const;

  /// Between azimuths and waves.
  [[nodiscard]] std::vector<FaceLight> waves_of(const std::vector<FaceLight>& grid) const;
  [[nodiscard]] std::vector<FaceLight> grid_of(const std::vector<FaceLight>& waves) const;
  [[nodiscard]] FaceLight grid_of(std::size_t b, const FaceLight& waves) const;
  /// Values of the waves at azimuths (rows); of rows of waves at azimuths (columns).
  [[nodiscard]] static Eigen::MatrixXd waves_at(Eigen::Index waves, std::span<const double> phi);
  [[nodiscard]] static Eigen::MatrixXd values_at(const Eigen::MatrixXd& waves,
                                                 std::span<const double> phi);

  [[nodiscard]] std::vector<FaceLight> no_light() const;

 private:
  struct Block {
    Block(Stack inner, const DirectionSets& sets, int channel, const LayerKernels& kernels,
          const HarmonicResolution& resolution, int azimuths);
    Block(const Block&) = delete;
    Block& operator=(const Block&) = delete;
    Stack stack;
    BlockTransport transport;
    SphereGrid grid;
    std::size_t above = 0, below = 0;
    std::vector<double> prepared;  // by direction of the grid
    Eigen::VectorXd crossing;      // by direction of the grid
  };

  HarmonicResolution resolution_;
  HarmonicBasis basis_;
  int azimuths_;
  BlockSurroundings surroundings_;
  std::vector<StackElement> elements_;
  MirroringGround ground_;
  std::deque<Block> blocks_;
  Eigen::MatrixXd waves_;  // rows: azimuths
};

}  // namespace lamella
