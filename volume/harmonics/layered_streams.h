#pragma once

#include <Eigen/Core>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/harmonics/depth_panels.h"

namespace lamella {

/// The layers of a stack that hold anything, on nodes in their depths: what a ray gathers of a
/// source function on its way through all of them. Nodes are numbered from the top down.
class LayeredStreams {
 public:
  /// finest: optical depth of the panels next to boundaries.
  LayeredStreams(const Stack& stack, int channel, double finest, int nodes_per_panel);

  struct Part {
    const Layer* layer;
    DepthPanels panels;
    int first;  ///< its first node
  };
  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  [[nodiscard]] int size() const { return size_; }  ///< nodes in all
  /// Below a half space's nodes lies what sends back all that arrives: where nothing changes any
  /// more in depth, that is what the depth does. Not below flakes of one side that face down: light
  /// that gets there is lost to the depth.
  [[nodiscard]] bool is_cut() const { return is_cut_; }

  /// What the integrals of one ray take, and the same for its end alone.
  [[nodiscard]] std::size_t block_size() const { return block_size_; }
  /// v: where the light goes. within: for radiance at the nodes, too, not only where it leaves.
  void prepare(Direction v, double* block, bool within = true) const;
  /// The radiance along v at every node, and where it leaves; begin: where it enters. source: at
  /// the nodes, per depth. radiance may be null.
  double march(Direction v, const double* block, const double* source, double begin,
               double* radiance) const;

  /// The share of light along v that crosses all layers.
  [[nodiscard]] double crossing(Direction v) const;
  /// The share of a beam from w (which points away from the stack) that reaches each node, and the
  /// far side.
  double beam(Direction w, double* share) const;

 private:
  std::vector<Part> parts_;
  PanelIntegrals integrals_;
  int size_ = 0, nodes_;
  bool is_cut_ = false;
  std::size_t block_size_ = 0;
};

}  // namespace lamella
