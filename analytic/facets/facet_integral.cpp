#include "analytic/facets/facet_integral.h"

namespace lamella {

double lost_share(const Facets& facets, Masking masking, double ratio, Direction w,
                  double tolerance) {
  return average_over_facets<double>(
      facets, w, SeenFacets::all,
      [&](Direction wi, Direction m, double cosine) {
        const Refraction<double> r =
            ratio > 0 ? refraction(cosine, ratio) : Refraction<double>{1, 0};
        const Direction up = 2 * cosine * m - wi;
        double lost = r.reflectance;
        if (up.z > 0) lost *= nonnegative(1 - facets.passes(masking, false, wi, up));
        if (!(r.cosine > 0)) return lost;
        const Direction down = refracted_ray(wi, m, cosine, r.cosine, ratio);
        const double passes =
            down.z < 0 ? facets.passes(masking, true, wi, {down.x, down.y, -down.z}) : 0;
        return lost + (1 - r.reflectance) * nonnegative(1 - passes);
      },
      tolerance, ratio > 0 ? critical_cosine(ratio) : 0, 1e-13);
}

}  // namespace lamella
