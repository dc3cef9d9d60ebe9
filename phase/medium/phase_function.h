#pragma once

#include <concepts>

#include "phase/math/direction.h"
#include "phase/medium/medium_traits.h"
#include "phase/random/random.h"

namespace lamella {

/// Value of a phase function: density of leaving along w_o [1/sr] and the Schlick weight
/// (1 - cos)^5 of the flake that scatters (0 where the medium has no Fresnel factor).
struct PhaseValue {
  double density = 0;
  double schlick = 0;
};

/// A sampled scattering: the direction it leaves along, and the Schlick weight of the flake.
struct Scatter {
  Direction wo;
  double schlick = 0;
};

/// One scattering event of light that arrived from w_i. `density(wo)` is the density of `sample`
/// given whatever the event has drawn already (a Lambertian flake's normal), so its expectation is
/// p(w_i -> w_o); next-event estimation and the walk's own continuation share the event.
template <class E>
concept ScatteringEvent = requires(const E event, Direction wo, RandomStream& stream) {
  { event.density(wo) } -> std::same_as<PhaseValue>;
  { event.sample(stream) } -> std::same_as<Scatter>;
};

/// An event whose density is asked for along many directions: itself, or what it prepares for that.
template <ScatteringEvent E>
[[nodiscard]] decltype(auto) lobe_of(const E& event) {
  if constexpr (requires { event.lobe(); })
    return event.lobe();
  else
    return (event);
}

/// What every medium offers.
///   sigma(w): projected area per unit of density that faces w, dimensionless.
///   phase(wi, wo): p(w_i -> w_o) [1/sr], exact (closed form or quadrature); integral over w_o
///   is 1. collide(wi, stream): an event for light that arrived from w_i; sigma(wi) must be
///   positive. is_delta(): the phase function is a delta, which `phase` and `density` leave out
/// (0). traits(): the other questions of other rooms. largest_density(): an upper bound of p
/// [1/sr],
///   within a factor of about 2 where lanes are to walk in the medium. ==: same kind, same numbers.
template <class M>
concept ScatteringMedium = std::equality_comparable<M> &&
    requires(const M medium, Direction w, RandomStream& stream) {
  { medium.sigma(w) } -> std::same_as<double>;
  { medium.phase(w, w) } -> std::same_as<PhaseValue>;
  { medium.collide(w, stream) } -> ScatteringEvent;
  { medium.is_delta() } -> std::same_as<bool>;
  { medium.traits() } -> std::same_as<MediumTraits>;
  { medium.largest_density() } -> std::same_as<double>;
};

}  // namespace lamella
