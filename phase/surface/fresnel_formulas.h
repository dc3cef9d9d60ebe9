#pragma once

#include "phase/math/vec3.h"

namespace lamella {

/// Reflectance of unpolarised light at a smooth boundary, and the cosine of the refracted
/// direction; reflectance 1 and cosine 0 at total reflection.
template <class Real>
struct Refraction {
  Real reflectance, cosine;
};

/// Fresnel's equations and Snell's law for light that arrives at a cosine in [0, 1]. ratio: the
/// index of refraction beyond the boundary over that on this side, > 0. Neither a ratio near 1 nor
/// an angle near the critical one loses digits to a difference: in double the error is that of the
/// cosine, 2e-16 absolute, times the derivative of Fresnel's equations.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Refraction<Real> refraction(Real cosine, Real ratio) {
  using std::sqrt;
  // ratio^2 - 1 + cosine^2, so that a small cosine and a ratio near 1 keep their digits
  const Real below = multiply_add(ratio - Real(1), ratio + Real(1), cosine * cosine);
  const Real through = sqrt(nonnegative(below));  // ratio times the refracted cosine
  const Real refracted = divide(through, ratio);
  const Real s = divide(cosine - through, max(cosine + through, Real(1e-30)));
  const Real p = divide(refracted - ratio * cosine, max(refracted + ratio * cosine, Real(1e-30)));
  const Real reflectance = Real(0.5) * multiply_add(s, s, p * p);
  return {select(through > Real(0), min(reflectance, Real(1)), Real(1)), refracted};
}

/// The same in a form without differences, for numbers of few digits: inverse is 1 / ratio, excess
/// ratio^2 - 1 (not 0), as exact as the caller has it: they tell whether the boundary does
/// anything.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Refraction<Real> refraction(Real cosine, Real ratio,
                                                                     Real inverse, Real excess) {
  using std::sqrt;
  const Real below = multiply_add(cosine, cosine, excess);
  const Real through = sqrt(nonnegative(below));  // ratio times the refracted cosine
  // s = (cosine - through) / sum = -excess / sum^2, and through - ratio^2 cosine in the same way:
  // p = excess (1 - cosine sum) / (sum t). Where sum is small nothing is refracted.
  const Real sum = cosine + through, t = multiply_add(ratio * ratio, cosine, through);
  const Real q = multiply_add(-cosine, sum, Real(1)) * sum;
  const Real scale = divide(excess, max(sum * sum * t, Real(1e-30)));
  const Real reflectance = Real(0.5) * scale * scale * multiply_add(t, t, q * q);
  return {select(below > Real(0), min(reflectance, Real(1)), Real(1)), through * inverse};
}

/// Fresnel's reflectance of unpolarised light at a conductor of complex index eta + i k relative to
/// the medium on it; cosine of incidence in [0, 1], eta > 0, k >= 0. Born and Wolf, Principles of
/// Optics, chapter 14.2.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real conductor_reflectance(Real cosine, Real eta, Real k) {
  using std::sqrt;
  const Real c2 = cosine * cosine, s2 = nonnegative(Real(1) - c2);
  // (a + i b)^2 = (eta + i k)^2 - 1 + c2; of a and b the larger one first, the other by their
  // product
  const Real real = multiply_add(eta - Real(1), eta + Real(1), c2 - k * k), product = eta * k;
  const Real size = sqrt(multiply_add(real, real, Real(4) * product * product));
  const Real larger = sqrt(nonnegative(Real(0.5) * (size + select(real > Real(0), real, -real))));
  const Real smaller = divide(product, max(larger, Real(1e-30)));
  const Real a = select(real > Real(0), larger, smaller);
  const Real t = Real(2) * a * cosine;
  const Real s = divide(size + c2 - t, max(size + c2 + t, Real(1e-30)));
  const Real q = multiply_add(c2, size, s2 * s2);
  const Real p = s * divide(q - t * s2, max(q + t * s2, Real(1e-30)));
  return Real(0.5) * (s + p);
}

/// The direction of the ray that a facet with unit normal m (on the side of w, w . m > 0) refracts:
/// w points back to where the light came from, the result along the refracted light; ratio as
/// above, refracted the cosine that refraction(w . m, ratio) gives.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Vec3<Real> refracted_ray(Vec3<Real> w, Vec3<Real> m,
                                                                  Real cosine, Real refracted,
                                                                  Real ratio) {
  const Real inverse = reciprocal(ratio);
  return renormalized(multiply_add(inverse, cosine, -refracted) * m - inverse * w);
}

}  // namespace lamella
