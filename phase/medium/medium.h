#pragma once

#include <variant>

#include "phase/medium/flake.h"
#include "phase/medium/henyey_greenstein.h"
#include "phase/medium/lambert_sphere.h"
#include "phase/medium/rayleigh.h"
#include "phase/medium/sggx.h"
#include "phase/medium/vmf.h"

namespace lamella {

/// The closed set of media. A new one is a file pair that meets ScatteringMedium, a name here and
/// an entry in media() (media.cpp). Two media are equal if they are of one kind with equal numbers.
using Medium = std::variant<MirrorFlakes<Sggx>, LambertFlakes<Sggx>, MirrorFlakes<Vmf>,
                            LambertFlakes<Vmf>, LambertSphere, HenyeyGreenstein, Rayleigh>;

static_assert(NormalDistribution<Sggx> && NormalDistribution<Vmf>);
static_assert(ScatteringMedium<MirrorFlakes<Sggx>> && ScatteringMedium<LambertFlakes<Sggx>>);
static_assert(ScatteringMedium<MirrorFlakes<Vmf>> && ScatteringMedium<LambertFlakes<Vmf>>);
static_assert(ScatteringMedium<LambertSphere> && ScatteringMedium<HenyeyGreenstein>);
static_assert(ScatteringMedium<Rayleigh>);

/// Projected area per unit of density that faces w.
[[nodiscard]] double sigma(const Medium& medium, Direction w);
/// p(w_i -> w_o) and the Schlick weight.
[[nodiscard]] PhaseValue phase(const Medium& medium, Direction wi, Direction wo);
[[nodiscard]] bool is_delta(const Medium& medium);
/// What other rooms ask of a medium besides how it scatters.
[[nodiscard]] MediumTraits traits(const Medium& medium);
/// An upper bound of p [1/sr].
[[nodiscard]] double largest_density(const Medium& medium);

}  // namespace lamella
