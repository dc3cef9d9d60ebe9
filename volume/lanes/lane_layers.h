#pragma once

#include "phase/math/real.h"

namespace lamella {

/// Layers that a walk on lanes can have, beside a substrate.
inline constexpr int kMostLaneLayers = 16;

/// The media that have a kernel on lanes, and what stands below them.
enum class LaneMediumKind {
  lambert_sphere,
  henyey_greenstein,
  rayleigh,
  sggx_mirror,
  sggx_lambert,
  vmf_mirror,
  vmf_lambert,
  substrate
};

/// What walks know of a layer: rows of LayerNumbers.
enum LayerField {
  kKind,         ///< LaneMediumKind
  kDepth,        ///< thickness times density; infinity for a half space
  kG,            ///< henyey_greenstein
  kA,            ///< SGGX: A of S = A A^T: a00 a10 a11 a20 a21 a22; particles: the unit matrix
  kInverse = 9,  ///< SGGX: A^-1 in the same order
  kDensityScale = 15,  ///< SGGX mirrors: 1 / (4 pi det A); vMF mirrors: D(axis) / 4
  kUp,                 ///< vMF: 1 or -1, z of the mean normal
  kFront,              ///< vMF: sigma(1)
  kBack,               ///< vMF: sigma(-1)
  kSide,               ///< vMF: sigma(0)
  kKappa,              ///< vMF
  kMean,               ///< vMF: cosine of the mean normal with the axis
  kReach,              ///< vMF: beyond this |u| sigma(u) is u times the latter, or 0
  kTable,              ///< vMF: where its tables begin, in pieces
  kAlbedo,             ///< three channels
  kF0 = kAlbedo + 3,   ///< three channels; 1 where there is no Fresnel factor
  kLayerFields = kF0 + 3
};

/// The layers of a stack from the top, in float for lanes and in double for their reference.
template <class Scalar>
struct LayerNumbers {
  Scalar value[kLayerFields][kMostLaneLayers] = {};
  /// Tables of vMF layers (volume/lanes/lane_marginals.h), one after the other.
  const float* tables = nullptr;
};

/// Cubics of each of the tables of a vMF layer.
inline constexpr int kMarginalPieces = 256;
/// Tables of a vMF layer: three marginals, and sigma.
inline constexpr int kVmfTables = 4;
/// What an exponential number on lanes is at most.
inline constexpr double kLargestExponential = 22.2;

/// Numbers of one layer, the same for all lanes.
template <class Real>
struct OneLayer {
  const LayerNumbers<typename NumberTraits<Real>::Scalar>& numbers;
  int layer;
  LAMELLA_INLINE Real operator()(int field) const { return Real(numbers.value[field][layer]); }
};

/// Numbers of each lane's own layer.
template <class Real>
struct LayerPerLane {
  const LayerNumbers<typename NumberTraits<Real>::Scalar>& numbers;
  WordsOf<Real> layer;
  LAMELLA_INLINE Real operator()(int field) const { return lookup(numbers.value[field], layer); }
};

}  // namespace lamella
