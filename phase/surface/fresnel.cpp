#include "phase/surface/fresnel.h"

#include <boost/math/quadrature/gauss.hpp>

#include "phase/surface/fresnel_formulas.h"

namespace lamella {

double fresnel_reflectance(double cosine, double ior) {
  return refraction(cosine, ior).reflectance;
}

double mean_fresnel_reflectance(double ior) {
  // In mu = t^2: near ior = 1 the reflectance rises steeply towards grazing.
  return boost::math::quadrature::gauss<double, 60>::integrate(
      [ior](double t) { return 4 * t * t * t * fresnel_reflectance(t * t, ior); }, 0.0, 1.0);
}

}  // namespace lamella
