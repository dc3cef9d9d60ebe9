#pragma once

#include <functional>
#include <string>
#include <vector>

#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

/// What a formula's author would tabulate: numbers in columns, one of which is their error.
struct NumberTable {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
};

/// f(w_i, w_o), per colour channel.
using PairFunction = std::function<Rgb(Direction wi, Direction wo)>;

inline constexpr int kMostTerms = 1000;  ///< of Legendre series
inline constexpr int kMostModes = 256;   ///< of Fourier series

/// Legendre's coefficients of a phase function p [1/sr] of the deflection's cosine c,
///   chi_l = 2 pi integral from -1 to 1 of p(c) P_l(c) dc,  p = 1 / (4 pi) sum of (2 l + 1) chi_l
///   P_l,
/// l below `terms`, up to kMostTerms: columns l, chi, error. Gauss-Legendre in the angle of
/// deflection on panels that halve towards forward and backward; the error is the difference to
/// half as many points. chi_0 is 1, chi_1 the mean cosine. Throws std::invalid_argument where p
/// depends on more than the deflection.
[[nodiscard]] NumberTable legendre_table(const PairFunction& p, int terms);

/// Fourier coefficients in the azimuth phi of w_o relative to w_i,
///   f = sum over m of (2 - [m = 0]) f_m(mu_i, mu_o) cos(m phi),
/// for every pair of cosines from the lists (below 0: from below), m below `modes`, up to
/// kMostModes: columns mu_i, mu_o, m, value (or value_r, value_g, value_b), error. The trapezoidal
/// rule, doubled until it stands still at 1e-12 of f_0, or has 2^14 points; the error is the last
/// change of any mode of the pair. Throws std::invalid_argument where f is not symmetric about z,
/// or not about the plane of incidence.
[[nodiscard]] NumberTable fourier_table(const PairFunction& f, const std::vector<double>& mu_i,
                                        const std::vector<double>& mu_o, int modes, bool color);

}  // namespace lamella
