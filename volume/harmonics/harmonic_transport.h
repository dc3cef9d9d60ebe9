#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/harmonics/block_transport.h"
#include "volume/harmonics/harmonic_resolution.h"
#include "volume/harmonics/sphere_grid.h"

namespace lamella {

/// A source function: coefficients by harmonic (rows) and node in depth (columns), and the radiance
/// that a Lambertian substrate sends up.
struct HarmonicSource {
  Eigen::MatrixXd coefficients;
  double ground = 0;
};

/// What light does between two events, for the light of one source.
struct HarmonicLight {
  HarmonicSource next;                    ///< what it becomes a source of
  double reflected = 0, transmitted = 0;  ///< flux that leaves through the top, the bottom
  double absorbed = 0;                    ///< in the layers and the substrate
};

/// Light in a stack of homogeneous layers without interfaces, of any axes, in one colour channel.
class HarmonicTransport {
 public:
  /// kernels: of this stack and this resolution's degree, shared between channels; null: its own.
  HarmonicTransport(const Stack& stack, int channel, const HarmonicResolution& resolution,
                    const LayerKernels* kernels = nullptr);
  /// The basis that belongs to a resolution.
  [[nodiscard]] static HarmonicBasis basis_of(const HarmonicResolution& resolution) {
    return HarmonicBasis(resolution.degree, resolution.is_even);
  }

  /// Bytes that a solution of one channel holds at once, its kernels included; without the sum over
  /// orders, which keeps a source per step.
  [[nodiscard]] static std::size_t bytes(const Stack& stack, int channel,
                                         const HarmonicResolution& resolution);

  /// One order from the one before it.
  [[nodiscard]] HarmonicLight follow(const HarmonicSource& source) const;
  /// Order 1 of a beam of unit irradiance from w_i, and what it becomes a source of; uncollided:
  /// the share that passes without an event.
  struct First {
    HarmonicLight light;
    /// Of `light.next`, what mirrors do not send to mirrors.
    HarmonicSource without_pairs;
    double uncollided = 0;
    double absorbed = 0;  ///< by the first event
  };
  [[nodiscard]] First first(Direction wi) const;
  /// The sum of a source and all that follows from it.
  [[nodiscard]] HarmonicSource sum(const HarmonicSource& source) const;
  /// Radiance that leaves along w_o by each of some sources: their values along that direction at
  /// the nodes, and what their ground sends up.
  void leaving(Direction wo, std::span<const double* const> values, std::span<const double> ground,
               double* radiance) const;

  [[nodiscard]] MatrixProduct product() const { return MatrixProduct(resolution_.isa); }
  [[nodiscard]] const HarmonicBasis& basis() const { return basis_; }
  [[nodiscard]] int nodes() const { return block_.nodes(); }

 private:
  [[nodiscard]] const LayeredStreams& streams() const { return block_.streams(); }
  // Whether light that arrives at the bottom meets a surface there.
  [[nodiscard]] bool is_closed() const { return stack_.substrate || streams().is_cut(); }
  [[nodiscard]] HarmonicSource scattered(const Eigen::MatrixXd& radiance, double arriving) const;

  const Stack& stack_;
  HarmonicResolution resolution_;
  HarmonicBasis basis_;
  BlockTransport block_;
  SphereGrid grid_;
  std::vector<double> prepared_;  // by direction of the grid
  double ground_albedo_ = 0;
};

}  // namespace lamella
