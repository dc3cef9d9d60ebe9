#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/harmonics/harmonic_resolution.h"
#include "volume/harmonics/layer_kernels.h"
#include "volume/harmonics/layered_streams.h"

namespace lamella {

/// Layers without boundaries between them, of any axes, in one colour channel: what they scatter
/// and absorb, in spherical harmonics and along rays. Sources and radiance have a column (or entry)
/// per node in depth.
class BlockTransport {
 public:
  /// The layers are those of the stack, which must outlive the object; what lies around them is not
  /// looked at.
  BlockTransport(const Stack& stack, int channel, const LayerKernels& kernels,
                 const HarmonicResolution& resolution);

  [[nodiscard]] const LayeredStreams& streams() const { return streams_; }
  [[nodiscard]] int nodes() const { return streams_.size(); }

  /// Coefficients of the source function that radiance with those coefficients makes.
  [[nodiscard]] Eigen::MatrixXd scattered(const Eigen::MatrixXd& radiance) const;
  /// The part of it that mirrors make.
  [[nodiscard]] Eigen::MatrixXd scattered_by_mirrors(const Eigen::MatrixXd& radiance) const;
  /// Whether a layer's flakes are mirrors; whether all are that are any.
  [[nodiscard]] bool is_mirror(std::size_t part) const { return mirrors_[part]; }
  [[nodiscard]] bool has_mirrors() const;
  [[nodiscard]] bool is_mixed() const;

  /// What radiance along v meets and does not scatter: all of what albedos tell, and, where
  /// Schlick's factor takes a share by the angle, all that it meets (see `sent_by_schlick`).
  [[nodiscard]] double collided(Direction v, const double* radiance) const;
  /// The flux that sources in layers with Schlick's factor send out.
  [[nodiscard]] double sent_by_schlick(const Eigen::MatrixXd& source) const;

  /// What a beam from w (pointing where it comes from) makes along v, given the shares of its power
  /// at the nodes. scattered: by layer, the share of what collides that goes on along v [1/sr].
  void beam_source(Direction w, Direction v, const Eigen::VectorXd& share, Eigen::VectorXd& source,
                   double* scattered) const;
  /// What the first event takes of a beam of unit power from w; scattered: `beam_source`'s,
  /// integrated over v.
  [[nodiscard]] double first_absorbed(Direction w, const std::vector<double>& scattered) const;

 private:
  [[nodiscard]] bool has_schlick(const Layer& layer) const { return layer.f0[channel_] != 1; }

  int channel_;
  LayeredStreams streams_;
  std::vector<std::shared_ptr<const HarmonicKernel>> kernels_;  // by part
  std::vector<bool> mirrors_;                                   // by part
};

}  // namespace lamella
