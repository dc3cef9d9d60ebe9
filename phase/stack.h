#pragma once

#include <optional>
#include <string>
#include <vector>

#include "phase/medium.h"

namespace lamella {

/// One plane-parallel layer. Only depth() counts for the light.
struct Layer {
  std::string medium_name;
  Parameters parameters;  ///< the medium's own, complete: for echo
  Medium medium;          ///< built from them
  Rgb albedo{1};          ///< of a flake or particle, in [0, 1]
  Rgb f0{1};              ///< Schlick's f0 of mirror flakes; 1: no Fresnel factor
  double thickness = 1;   ///< [mm], in [0, infinity]
  double density = 1;     ///< [1/mm], in [0, infinity)

  /// thickness times density, dimensionless; infinity for a half space.
  [[nodiscard]] double depth() const { return thickness * density; }
};

/// An opaque surface below the last layer: Lambertian, or black at albedo 0.
struct Substrate {
  Rgb albedo{0};
};

/// Layers from the top down, and what lies below.
struct Stack {
  std::string name;
  std::vector<Layer> layers;
  std::optional<Substrate> substrate;

  [[nodiscard]] bool is_half_space() const;
  /// Whether light can come from below, and leave there.
  [[nodiscard]] bool is_open_below() const { return !substrate && !is_half_space(); }
  /// Whether no albedo, f0 or substrate differs between the channels.
  [[nodiscard]] bool is_grey() const;
  /// Whether every rotation about z leaves the stack as it is.
  [[nodiscard]] bool is_symmetric_about_z() const;
  /// Whether global reciprocity holds: every one-sided layer has a vertical mean normal.
  [[nodiscard]] bool is_reciprocal() const;
  /// Sum over layers of depth times the z part of the mean normal: transmission from above is
  /// exp(-this) times transmission from below along the reversed pair.
  [[nodiscard]] double one_sidedness() const;
  /// Fraction of the light that arrives from w (a unit vector that points away from the stack) and
  /// crosses all layers without a collision; 0 through a half space.
  [[nodiscard]] double uncollided(Direction w) const;
};

/// Same layers with every albedo, substrate albedo and f0 at 1: what a white furnace wants.
[[nodiscard]] Stack whitened(Stack stack);

}  // namespace lamella
