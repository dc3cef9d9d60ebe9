#include "phase/surface/microfacet.h"

#include <array>
#include <boost/math/policies/policy.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "phase/math/direction.h"
#include "phase/surface/microfacet_formulas.h"

namespace lamella {
namespace {

constexpr std::array<std::string_view, 3> kShapes{"smooth", "ggx", "beckmann"};
constexpr std::array<std::string_view, 3> kMaskings{"beta", "correlated", "separable"};

// Boost would go to long double and back, which takes ten times as long.
using InDouble = boost::math::policies::policy<boost::math::policies::promote_double<false>>;

template <class Enum>
Enum from_word(std::string_view word, const std::array<std::string_view, 3>& words) {
  for (std::size_t k = 0; k < words.size(); ++k)
    if (words[k] == word) return static_cast<Enum>(k);
  throw std::invalid_argument("unknown word \"" + std::string(word) + '"');
}

/// The integral of (z - x s) exp(-x^2) / sqrt(pi) over slopes below x: Beckmann's facets, in the
/// space where alpha is 1, that a direction with cosine z and sine s sees.
double beckmann_area_up_to(double x, double z, double s) {
  constexpr double kInverseRootPi = 0.56418958354775628695;
  return 0.5 * (z * std::erfc(-x) + s * kInverseRootPi * std::exp(-x * x));
}

double beckmann_area(Direction w, double ax, double ay) {
  const double s = std::hypot(ax * w.x, ay * w.y);
  if (s == 0) return w.z > 0 ? w.z : 0;
  return std::fmax(beckmann_area_up_to(w.z / s, w.z, s), 0);
}

// The slope against the direction's azimuth by its cumulative density, Newton's method within a
// bracket that shrinks.
double beckmann_slope(double z, double s, double u) {
  const double end = s > 0 ? z / s : std::numeric_limits<double>::infinity();
  // Beyond 6 there is less than 1e-16 of the slopes; a direction deep below sees them near `end`.
  double high = std::fmin(end, 6.5), low = std::fmin(-6.5, high - 3);
  const double whole = beckmann_area_up_to(high, z, s);
  if (!(whole > 0)) return high;
  const double wanted = u * whole;
  double x = std::fmax(low, std::fmin(high, 0.0));
  for (int k = 0; k < 60; ++k) {
    const double error = beckmann_area_up_to(x, z, s) - wanted;
    (error > 0 ? high : low) = x;
    const double slope = (z - x * s) * 0.56418958354775628695 * std::exp(-x * x);
    double next = slope > 0 ? x - error / slope : low;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - x) <= 1e-15 * (1 + std::abs(x))) return next;
    x = next;
  }
  return x;
}

// A normal standard deviation of 1 / sqrt(2), by inversion.
double gaussian_slope(double u) {
  double low = -6.5, high = 6.5, x = 0;
  for (int k = 0; k < 60; ++k) {
    const double error = 0.5 * std::erfc(-x) - u;
    (error > 0 ? high : low) = x;
    double next = x - error / (0.56418958354775628695 * std::exp(-x * x));
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - x) <= 1e-15 * (1 + std::abs(x))) return next;
    x = next;
  }
  return x;
}

Direction beckmann_normal(Direction w, double ax, double ay, double u1, double u2) {
  const double x = ax * w.x, y = ay * w.y, s = std::hypot(x, y);
  const double along = beckmann_slope(w.z, s, u1), across = gaussian_slope(u2);
  // Slopes in the space of alpha 1: along the direction's azimuth and across it.
  const double c = s > 0 ? x / s : 1, d = s > 0 ? y / s : 0;
  // The slope that the sign of `along` counts faces away from w: (z - x s).
  return normalized(Direction{-(c * along - d * across) * ax, -(d * along + c * across) * ay, 1.0});
}

}  // namespace

std::string_view to_text(FacetShape shape) { return kShapes[static_cast<std::size_t>(shape)]; }
FacetShape facet_shape_from(std::string_view word) { return from_word<FacetShape>(word, kShapes); }
std::string_view to_text(Masking masking) { return kMaskings[static_cast<std::size_t>(masking)]; }
Masking masking_from(std::string_view word) { return from_word<Masking>(word, kMaskings); }

double Facets::area(Direction w) const {
  return shape == FacetShape::ggx ? GgxFacets<double>{alpha_x, alpha_y}.area(w)
                                  : beckmann_area(w, alpha_x, alpha_y);
}

double Facets::density(Direction m) const {
  if (shape == FacetShape::ggx) return GgxFacets<double>{alpha_x, alpha_y}.density(m);
  if (!(m.z > 0)) return 0;
  const double x = m.x / (alpha_x * m.z), y = m.y / (alpha_y * m.z), z2 = m.z * m.z;
  if (!(x * x + y * y < 745)) return 0;  // where m.z is far below what squares hold, too
  return std::exp(-x * x - y * y) / (kPi * alpha_x * alpha_y * z2 * z2);
}

double Facets::visible_density(Direction w, Direction m) const {
  const double cosine = dot(w, m);
  if (!(cosine > 0)) return 0;
  const double shown = area(w);
  return shown > 0 ? density(m) * cosine / shown : 0;
}

Direction Facets::visible_normal(Direction w, double u1, double u2) const {
  return shape == FacetShape::ggx ? GgxFacets<double>{alpha_x, alpha_y}.visible_normal(w, u1, u2)
                                  : beckmann_normal(w, alpha_x, alpha_y, u1, u2);
}

double Facets::shadowing(Masking masking, bool transmission, Direction wi, Direction wo) const {
  const double area_i = area(wi), area_o = area(wo);
  if (masking == Masking::separable) return 1 / (area_i * area_o);
  if (masking == Masking::correlated || !transmission)
    return 1 / (wo.z * area_i + wi.z * area_o - wi.z * wo.z);
  // Of one direction far below grazing, B(a, b) is Gamma(b) a^-b up to b^2 / (2 a).
  const double a = area_i / wi.z, b = area_o / wo.z;
  const double large = std::fmax(a, b), small = std::fmin(a, b);
  if (large > 1e15)
    return small > 100 ? 0
                       : std::tgamma(small) * std::pow(large, 1 - small) /
                             (a > b ? area_i * wo.z : area_o * wi.z);
  return boost::math::beta(a, b, InDouble()) / (wi.z * wo.z);
}

double Facets::passes(Masking masking, bool transmission, Direction wi, Direction wo) const {
  return shadowing(masking, transmission, wi, wo) * area(wi) * wo.z;
}

}  // namespace lamella
