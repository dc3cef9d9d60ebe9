#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/harmonics/bounded_transport.h"
#include "volume/solver/order_shares.h"

namespace lamella {

/// The beams that cross a block, from above and from below, and what one event in the block makes
/// of them.
class BlockBeams {
 public:
  struct Beam {
    Direction w;        ///< where it comes from, in the block
    OrderShares power;  ///< that enters the block
  };
  BlockBeams(const BoundedTransport& transport, std::size_t block, std::vector<Beam> beams);

  [[nodiscard]] bool is_empty() const { return beams_.empty(); }
  [[nodiscard]] const std::vector<Beam>& beams() const { return beams_; }

  struct First {
    /// Coefficients of what the light of that event becomes a source of, its mirror images of the
    /// same order within the block included.
    Eigen::MatrixXd scattered;
    FaceLight emitted;    ///< that leaves the block before it is mirrored (grid)
    double absorbed = 0;  ///< by the event, and by the next one
  };
  /// Of beam n at unit power.
  [[nodiscard]] First first(std::size_t n) const;
  /// What enters again of light that leaves (grid), by mirrors at the block's faces alone.
  [[nodiscard]] FaceLight mirrored(const FaceLight& emitted) const;
  /// Radiance that leaves along v, where nothing is mirrored, of beam n at unit power; prepared: of
  /// the streams.
  [[nodiscard]] double leaving(std::size_t n, Direction v, const double* prepared) const;

 private:
  // The same light along the grid's directions, where it is smooth.
  [[nodiscard]] FaceLight emitted_at_nodes(std::size_t n) const;

  const BoundedTransport& transport_;
  std::size_t block_;
  std::vector<Beam> beams_;
  std::vector<Eigen::VectorXd> shares_;  // of each beam at the nodes
};

}  // namespace lamella
