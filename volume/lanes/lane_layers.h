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
  kFront = 9,    ///< vMF by null collisions: sigma(1), sigma(-1), sigma(0), in SGGX's rows
  kBack,
  kSide,
  kDensityScale = 15,    ///< SGGX mirrors: 1 / (4 pi det A); vMF mirrors: D(axis) / 4
  kAxis,                 ///< vMF: the mean normal
  kAcross = kAxis + 3,   ///< vMF: a direction perpendicular to it
  kKappa = kAcross + 3,  ///< vMF
  kWidth,                ///< vMF: 1 / sqrt(kappa + 1); 0 for other media
  kReach,                ///< vMF: 1 / min(1, kLargestBehind width)
  kMean,                 ///< vMF: cosine of the mean normal with the axis
  kTable,                ///< vMF: where its tables begin, in patches, or in marginals' pieces
  kFacing,               ///< vMF: u from which on narrow flakes face the light; 2 for wide ones
  kHidden,               ///< vMF: -u from which on light sees none of them; 2 for wide ones
  kTilt,                 ///< vMF, narrow: TiltSeries (volume/lanes/lane_narrow_normals.h)
  kAlbedo = kTilt + 3,   ///< three channels
  kF0 = kAlbedo + 3,     ///< three channels; 1 where there is no Fresnel factor
  kLayerFields = kF0 + 3
};

/// The layers of a stack from the top, in float for lanes and in double for their reference.
template <class Scalar>
struct LayerNumbers {
  Scalar value[kLayerFields][kMostLaneLayers] = {};
  /// Tables of vMF layers (volume/lanes/lane_normals.h), those of all layers first.
  const float* tables = nullptr;
};

/// Cubics of each of the tables of volume/lanes/lane_marginals.h.
inline constexpr int kMarginalPieces = 256;
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
