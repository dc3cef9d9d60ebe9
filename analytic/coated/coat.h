#pragma once

#include <array>

#include "analytic/facets/cosine_table.h"
#include "phase/interface/dielectric.h"
#include "phase/math/color.h"

namespace lamella {

/// While one of these lives, the coats that its thread makes have quick tables: E and <E> of rough
/// ones within 1e-4 (absolute), T and the internal mean within 1e-3, in a twentieth of the time.
/// For searches over parameters, whose last step is exact.
class QuickCoats {
 public:
  QuickCoats();
  ~QuickCoats();
  QuickCoats(const QuickCoats&) = delete;
  QuickCoats& operator=(const QuickCoats&) = delete;

 private:
  bool before_;
};

/// A dielectric interface with air above it and, below, a coat of index n that absorbs. The members
/// are the quantities of layering formulas, as functions of cosines in air. Smooth: in closed form;
/// rough: single scattering, tabulated when the coat is made: E and <E> within 1e-6 of their value
/// (2e-5 next to index 1), T and the internal mean within 2e-6 (T of mu below 1e-6 within 1e-3: the
/// Beta masking goes to its limit like small powers of mu).
class Coat {
 public:
  /// interface: index above 1, below n in [1, 4]; the same roughness along x and y. color: the
  /// share of the light that two passes along the normal leave. through: whether transmitted() and
  /// internal_mean() will be asked for. An interface of n = 1 does nothing, whatever its roughness.
  Coat(const Dielectric& interface, Rgb color, bool through);

  [[nodiscard]] const Dielectric& interface() const { return interface_; }
  /// Whether the interface's reflection is a delta, or none.
  [[nodiscard]] bool is_delta() const { return interface_.is_smooth(); }
  [[nodiscard]] double index() const { return interface_.below; }

  /// E(mu), the share of light from outside that the interface reflects.
  [[nodiscard]] double reflected(double mu) const;
  /// Its mean over the hemisphere, 2 integral of E mu dmu.
  [[nodiscard]] double reflected_mean() const { return reflected_mean_; }
  /// Fresnel's reflectance of a smooth interface, and its mean.
  [[nodiscard]] double fresnel(double mu) const;
  [[nodiscard]] double fresnel_mean() const { return fresnel_mean_; }

  /// The cosine in the coat of a direction in air, by Snell's law at the smooth interface.
  [[nodiscard]] double refracted(double mu) const;
  /// The share of light that absorption leaves on the way in and out: color^((1/mu_i' + 1/mu_o') /
  /// 2), mu' the refracted cosines.
  [[nodiscard]] Rgb absorption(double mu_i, double mu_o) const;

  /// T(mu): the share of light from outside that arrives at the bottom of the coat.
  [[nodiscard]] Rgb transmitted(double mu) const;
  /// Of light that leaves the bottom of the coat by Lambert's law, the share that comes back to it.
  [[nodiscard]] Rgb internal_mean() const { return internal_mean_; }

 private:
  void make_tables(bool through);
  [[nodiscard]] double internal_mean_of(double color) const;

  Dielectric interface_;
  Rgb color_;
  CosineTable reflected_;
  std::array<CosineTable, 3> transmitted_;  // the first alone if the colour is grey
  double reflected_mean_ = 0, fresnel_mean_ = 0;
  Rgb internal_mean_;
};

}  // namespace lamella
