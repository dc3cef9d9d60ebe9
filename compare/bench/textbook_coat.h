#pragma once

#include <cstdint>
#include <vector>

#include "phase/math/direction.h"

namespace lamella {

/// The baseline of the rows with coats: a rough GGX interface over a half space of Lambert spheres,
/// or directly over Lambert's law, written as a careful user would write it from the papers, in
/// scalar double (as textbook_walk.h). Visible normals by Heitz 2018, "Sampling the GGX
/// distribution of visible normals", Fresnel's equations and refraction by Walter et al. 2007; the
/// weight takes G_2 / G_1 = (1 + L_i) / (1 + L_i + L_o) at every facet (Masking::correlated). Media
/// by d'Eon 2021. The weight takes the albedo at each of the first three events, from the fourth on
/// survival does; counts what leaves above in 16 x 32 cells.
struct TextbookCoatCase {
  double ior = 1.5, alpha = 0.3, albedo = 0.9;
  bool spheres = true;  ///< a half space of them below; else Lambert's law
};

struct TextbookCoatResult {
  std::uint64_t walks = 0, events = 0, meetings = 0;
  double reflected = 0, reflected2 = 0;  ///< sums over walks, and of their squares
  double coat = 0;                       ///< the part of `reflected` that met the coat alone
  std::vector<double> f;                 ///< per cell, sum over walks [1/sr]
};

class TextbookCoat {
 public:
  /// Light from above along -wi.
  TextbookCoat(const TextbookCoatCase& what, Direction wi, std::uint64_t seed);
  void advance(std::uint64_t walks);
  [[nodiscard]] const TextbookCoatResult& result() const { return result_; }

 private:
  TextbookCoatCase case_;
  Direction wi_;
  std::uint64_t state_, increment_;
  TextbookCoatResult result_;
};

}  // namespace lamella
