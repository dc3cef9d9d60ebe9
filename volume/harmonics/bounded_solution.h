#pragma once

#include <array>
#include <span>
#include <vector>

#include "volume/harmonics/block_beams.h"
#include "volume/harmonics/bounded_transport.h"
#include "volume/harmonics/harmonic_solution.h"

namespace lamella {

/// The light of one beam in a stack with boundaries, in one channel, at one resolution.
class BoundedSolution {
 public:
  /// The beam is number i of those that the transport was made for.
  BoundedSolution(const BoundedTransport& transport, std::size_t i, Direction wi);

  [[nodiscard]] const HarmonicEnergies& energies() const { return energies_; }
  /// f [1/sr] by part along asked cosines first ... first + count - 1 (rows) at azimuths (columns),
  /// up or down. Parts that closed forms have in full are empty.
  [[nodiscard]] std::array<Eigen::MatrixXd, kHarmonicParts> f(bool up, std::size_t first,
                                                              std::size_t count,
                                                              std::span<const double> phi) const;

 private:
  // Orders 0 to 3, and 4 and more.
  static constexpr int kOrders = OrderShares::kSize;

  void find_beams();
  // What enters of that order, and leaves the stack, by light of lower orders.
  [[nodiscard]] SurroundedLight raised(std::size_t i, int order) const;
  [[nodiscard]] BoundedSource no_source() const;
  // What one event in the blocks makes of beams, in light of that order.
  struct OfBeams {
    std::vector<FaceLight> emitted;          // that leaves the blocks before it is mirrored
    std::vector<FaceLight> mirrored;         // of it, that enters again by mirrors of its order
    std::vector<FaceLight> leaving;          // both, through the faces
    std::vector<Eigen::MatrixXd> scattered;  // of the next order; empty: there is none of all this
    double absorbed = 0;
  };
  [[nodiscard]] OfBeams of_beams(int order) const;
  void solve_order(std::size_t i, int order);
  void solve_rest(std::size_t i);
  void take_energies(std::size_t i);
  [[nodiscard]] FaceLight crossed(std::size_t b, FaceLight light) const;
  // What one direction of a block has of its own: crossing, and what leaves by order.
  struct Ray {
    double crossing;
    std::array<double, kOrders> emitted;
  };
  [[nodiscard]] Ray ray_along(std::size_t b, Direction v,
                              const std::array<const double*, kOrders>& values) const;

  const BoundedTransport& transport_;
  Direction wi_;
  bool has_rough_;
  std::vector<BlockBeams> beams_;                              // by block
  std::vector<std::vector<BlockBeams::First>> first_;          // by block and beam, at unit power
  std::array<ArrivingBeam, kOrders> arriving_;                 // by order
  std::array<std::vector<Eigen::MatrixXd>, kOrders> sources_;  // coefficients by block, or empty
  std::array<std::vector<FaceLight>, kOrders> leaving_;        // waves
  std::array<SurroundedLight, kOrders> around_;
  HarmonicEnergies energies_;
};

}  // namespace lamella
