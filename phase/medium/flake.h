#pragma once

#include "phase/math/color.h"
#include "phase/math/sampling.h"
#include "phase/medium/lambert_event.h"
#include "phase/medium/phase_function.h"

namespace lamella {

/// What a flake medium needs of its distribution of normals D(m).
///   sigma(w) = integral of D(m) <w, m> dm; density_of(h): D at h / |h|, h not necessarily unit.
///   visible_normal(wi, stream): normal with density D(m) <w_i, m> / sigma(w_i).
///   diffuse_phase(wi, wo): integral of D(m) <w_i, m> <w_o, m> dm / (pi sigma(w_i)).
///   mirror_phase(wi, wo): D(h) / (4 sigma(w_i)); largest_mirror_phase(): its upper bound.
///   mirror_lobe(wi): the same for many w_o, by h = w_i + w_o and |h|^2 > 0.
///   mean_normal(): integral of m D(m) dm. is_two_sided(): D(m) = D(-m).
template <class N>
concept NormalDistribution = std::equality_comparable<N> &&
    requires(const N ndf, Direction w, RandomStream& stream) {
  { ndf.sigma(w) } -> std::same_as<double>;
  { ndf.density_of(w) } -> std::same_as<double>;
  { ndf.visible_normal(w, stream) } -> std::same_as<Direction>;
  { ndf.diffuse_phase(w, w) } -> std::same_as<double>;
  { ndf.mirror_phase(w, w) } -> std::same_as<double>;
  { ndf.mirror_lobe(w)(w, 1.0) } -> std::same_as<double>;
  { ndf.is_delta() } -> std::same_as<bool>;
  { ndf.is_two_sided() } -> std::same_as<bool>;
  { ndf.is_symmetric_about_z() } -> std::same_as<bool>;
  { ndf.mean_normal() } -> std::same_as<Direction>;
  { ndf.largest_mirror_phase() } -> std::same_as<double>;
};

/// The traits that mirror flakes and Lambertian flakes have in common.
template <class Ndf>
[[nodiscard]] MediumTraits flake_traits(const Ndf& ndf, PhaseShape shape) {
  return {.two_sided = ndf.is_two_sided(),
          .symmetric_about_z = ndf.is_symmetric_about_z(),
          .has_axis = true,
          .mean_normal = ndf.mean_normal(),
          .shape = shape,
          .mean_cosine = 0};
}

/// The half vector of two directions, not normalised: w_i + w_o. At w_o = -w_i, where it vanishes,
/// its limit within the vertical plane of w_i, on the upper side.
[[nodiscard]] inline Direction half_vector(Direction wi, Direction wo) {
  const Direction h = wi + wo;
  if (dot(h, h) > 0) return h;
  const double s = std::sqrt(wi.x * wi.x + wi.y * wi.y);
  if (s == 0) return {1, 0, 0};
  return {-wi.z * wi.x / s, -wi.z * wi.y / s, s};
}

/// Flakes that are perfect mirrors, with an optional Schlick factor applied by the layer.
/// p(w_i -> w_o) = D(h) / (4 sigma(w_i)), h the half vector (Heitz et al. 2015, eq. 16; SpongeCake
/// eq. 4). One-sided distributions need no further factor: <w_i, h> is never negative.
template <class Ndf>
struct MirrorFlakes {
  Ndf ndf;

  /// The event's density with what does not depend on w_o done once.
  struct Lobe {
    decltype(std::declval<const Ndf&>().mirror_lobe(Direction())) density_along;
    Direction wi;

    [[nodiscard]] PhaseValue density(Direction wo) const {
      const Direction h = half_vector(wi, wo);
      return {density_along(h, dot(h, h)), half_angle_schlick(wi, wo)};
    }
  };

  struct Event {
    const Ndf& ndf;
    Direction wi;

    /// For many directions: density() within a few roundings.
    [[nodiscard]] Lobe lobe() const { return {ndf.mirror_lobe(wi), wi}; }

    [[nodiscard]] PhaseValue density(Direction wo) const {
      return {ndf.mirror_phase(wi, wo), half_angle_schlick(wi, wo)};
    }
    [[nodiscard]] Scatter sample(RandomStream& stream) const {
      const Direction m = ndf.visible_normal(wi, stream);
      return {mirrored(wi, m), schlick_weight(dot(wi, m))};
    }
  };

  [[nodiscard]] double sigma(Direction w) const { return ndf.sigma(w); }
  [[nodiscard]] PhaseValue phase(Direction wi, Direction wo) const {
    return {ndf.mirror_phase(wi, wo), half_angle_schlick(wi, wo)};
  }
  [[nodiscard]] Event collide(Direction wi, RandomStream&) const { return {ndf, wi}; }
  [[nodiscard]] bool is_delta() const { return ndf.is_delta(); }
  [[nodiscard]] MediumTraits traits() const { return flake_traits(ndf, PhaseShape::jump); }
  [[nodiscard]] double largest_density() const { return ndf.largest_mirror_phase(); }

  friend bool operator==(const MirrorFlakes&, const MirrorFlakes&) = default;

 private:
  static double half_angle_schlick(Direction wi, Direction wo) {
    return schlick_weight(std::sqrt(std::fmax(0, (1 + dot(wi, wo)) / 2)));
  }
};

/// Flakes that reflect by Lambert's law to the side the light comes from.
/// p(w_i -> w_o) = integral of D(m) <w_i, m> <w_o, m> dm / (pi sigma(w_i)), by quadrature; an event
/// draws its visible normal first, given which the density is <w_o, m> / pi.
template <class Ndf>
struct LambertFlakes {
  Ndf ndf;

  using Event = LambertEvent;

  [[nodiscard]] double sigma(Direction w) const { return ndf.sigma(w); }
  [[nodiscard]] PhaseValue phase(Direction wi, Direction wo) const {
    return {ndf.diffuse_phase(wi, wo), 0};
  }
  [[nodiscard]] Event collide(Direction wi, RandomStream& stream) const {
    return {ndf.visible_normal(wi, stream)};
  }
  [[nodiscard]] bool is_delta() const { return false; }
  [[nodiscard]] MediumTraits traits() const { return flake_traits(ndf, PhaseShape::diffuse); }
  /// A mean of cosines over pi.
  [[nodiscard]] double largest_density() const { return 1; }

  friend bool operator==(const LambertFlakes&, const LambertFlakes&) = default;
};

}  // namespace lamella
