#pragma once

#include <atomic>

#include "phase/lanes/isa.h"

namespace lamella {

/// How finely directions and depths are resolved.
struct HarmonicResolution {
  int degree = 16;          ///< of the source function's spherical harmonics
  int depth_nodes = 7;      ///< per panel
  double finest = 1e-4;     ///< optical depth of the panels next to boundaries
  double residual = 1e-10;  ///< of the sum over all orders
  bool is_even = false;     ///< stack and light are the same at y and -y: even harmonics alone
  Isa isa = Isa::scalar;    ///< of products of matrices
  const std::atomic<bool>* stop = nullptr;  ///< once set, work ends with HarmonicStopped

  /// Throws HarmonicStopped where `stop` is set.
  void check_stop() const;
};

/// Thrown where HarmonicResolution::stop is set, at the latest after the light between two events
/// or the kernel of a layer.
struct HarmonicStopped {};

inline void HarmonicResolution::check_stop() const {
  if (stop && *stop) throw HarmonicStopped();
}

}  // namespace lamella
