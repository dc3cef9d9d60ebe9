#pragma once

#include <string_view>

#include "phase/math/vec3.h"

namespace lamella {

/// How the normals of a rough surface are distributed: a smooth surface has one normal, z.
enum class FacetShape { smooth, ggx, beckmann };

/// The words of stack files, in the order of FacetShape.
[[nodiscard]] std::string_view to_text(FacetShape shape);
[[nodiscard]] FacetShape facet_shape_from(std::string_view word);

/// How facets hide each other: the terms in use. Masking::beta is that of a Smith surface whose
/// heights both directions share.
enum class Masking {
  beta,        ///< reflection 1 / (1 + L_i + L_o), transmission B(1 + L_i, 1 + L_o)
  correlated,  ///< 1 / (1 + L_i + L_o) for both (pbrt)
  separable,   ///< 1 / ((1 + L_i) (1 + L_o)) for both (Walter et al. 2007, Mitsuba)
};
[[nodiscard]] std::string_view to_text(Masking masking);
[[nodiscard]] Masking masking_from(std::string_view word);

/// The normals of a rough surface (not FacetShape::smooth), a height field of Smith's kind: GGX or
/// Beckmann, roughness alpha along x and y, in [1e-6, 10]. w and m are unit; m.z >= 0.
struct Facets {
  FacetShape shape = FacetShape::ggx;
  double alpha_x = 1, alpha_y = 1;

  /// Projected area of the facets that face w, per unit of the macroscopic surface: w.z (1 +
  /// Lambda(w)) above the surface, |w.z| Lambda(-w) below it, so that area(w) - area(-w) = w.z.
  [[nodiscard]] double area(Direction w) const;
  /// D(m) [1/sr]: the integral of D(m) m.z dm is 1.
  [[nodiscard]] double density(Direction m) const;
  /// D(m) <w, m> / area(w) [1/sr]: the density of visible_normal.
  [[nodiscard]] double visible_density(Direction w, Direction m) const;
  /// A normal that w sees, from two uniforms in (0, 1); w above the surface or below it.
  [[nodiscard]] Direction visible_normal(Direction w, double u1, double u2) const;

  /// G_2(w_i, w_o) / (|mu_i| |mu_o|), finite where one of the cosines is 0; both above the
  /// surface: give directions below it with their z turned.
  [[nodiscard]] double shadowing(Masking masking, bool transmission, Direction wi,
                                 Direction wo) const;
  /// G_2 / G_1(w_i): the share of the light reflected along w_o at a visible facet that leaves.
  [[nodiscard]] double passes(Masking masking, bool transmission, Direction wi, Direction wo) const;

  friend bool operator==(const Facets&, const Facets&) = default;
};

}  // namespace lamella
