#include <gtest/gtest.h>

#include "analytic/model/model.h"
#include "tests/analytic/model/nested_quadrature.h"

namespace lamella {
namespace {

TEST(Lambert, DirectionalAlbedoEqualsTheIntegralOfF) {
  Parameters p;
  p.set("albedo", Rgb(0.9, 0.5, 0.2));
  const auto model = find_model("lambert")->make(p, nullptr);
  const Direction wi = direction_from_degrees(60, 20);
  const Rgb integral =
      integrate_projected_rgb([&](Direction wo) { return model->eval(wi, wo); }, 1);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(integral[c], model->albedo(wi)[c], 1e-12);
}

}  // namespace
}  // namespace lamella
