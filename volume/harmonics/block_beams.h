#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/harmonics/bounded_transport.h"

namespace lamella {

/// The beams that cross a block, from above and from below, and their order 1.
class BlockBeams {
 public:
  struct Beam {
    Direction w;   ///< where it comes from, in the block
    double power;  ///< that enters the block
  };
  BlockBeams(const BoundedTransport& transport, std::size_t block, std::vector<Beam> beams);

  [[nodiscard]] bool is_empty() const { return beams_.empty(); }

  struct First {
    /// Coefficients of what order 1 becomes a source of, its mirror images within the block
    /// included.
    Eigen::MatrixXd scattered;
    FaceLight emitted;    ///< that leaves the block before it is mirrored (grid)
    double absorbed = 0;  ///< by the first event, and by the second
  };
  [[nodiscard]] First first() const;
  /// What enters again of light that leaves (grid), by mirrors at the block's faces alone.
  [[nodiscard]] FaceLight mirrored(const FaceLight& emitted) const;
  /// Radiance of order 1 that leaves along v, where nothing is mirrored; prepared: of the streams.
  [[nodiscard]] double leaving(Direction v, const double* prepared) const;

 private:
  // The same light along the grid's directions, where it is smooth.
  [[nodiscard]] FaceLight emitted_at_nodes() const;

  const BoundedTransport& transport_;
  std::size_t block_;
  std::vector<Beam> beams_;
  std::vector<Eigen::VectorXd> shares_;  // of each beam's power at the nodes
};

}  // namespace lamella
