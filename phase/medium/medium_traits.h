#pragma once

#include "phase/math/direction.h"

namespace lamella {

/// A value that must be given: an aggregate that holds one does not compile without it.
template <class T>
struct Required {
  T value;
  Required(T given) : value(given) {}  // NOLINT: conversion is what it is for
  operator T() const { return value; }
};

/// The shape of a phase function about the direction straight on, w_o = -w_i: the deterministic
/// solver must know it before it expands the phase function.
enum class PhaseShape {
  smooth,   ///< nowhere steep beyond what mean_cosine says
  jump,     ///< bounded, but its value at w_o = -w_i depends on the way there (mirror flakes)
  diffuse,  ///< Lambertian flakes: an integral over the flakes' normals, without closed form
};

/// What the other rooms ask of a medium besides how it scatters. A medium answers every question
/// (ScatteringMedium requires `traits()`); there are no defaults.
struct MediumTraits {
  /// Whether sigma(w_i) p(w_i -> w_o) is the same at (-w_i, -w_o): particles, two-sided flakes.
  Required<bool> two_sided;
  /// Whether every rotation about z leaves the medium as it is.
  Required<bool> symmetric_about_z;
  /// Whether there is an axis that an orientation grid can turn. Particles have none.
  Required<bool> has_axis;
  /// The integral of m D(m) dm: zero for two-sided media and particles.
  Required<Direction> mean_normal;
  Required<PhaseShape> shape;
  /// Mean cosine of the deflection where the phase function has a peak, forward (> 0) or backward
  /// (< 0), to which nodes and long walks must be fitted; 0 where it has none.
  Required<double> mean_cosine;
};

}  // namespace lamella
