#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "phase/stack/single_scattering.h"
#include "tests/volume/run/draw.h"
#include "tests/volume/run/stacks.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/solver/deterministic.h"

// The random walk against the solver on random stacks: they share the media only.

namespace lamella {
namespace {

using testing::Draw;

std::string random_stack(Draw& draw) {
  const auto medium = [&] {
    switch (draw.below(7)) {
      case 0:
        return kSphere;
      case 1:
        return henyey_greenstein(draw.rounded(-0.6, 0.7));
      case 2:
        return sggx(draw.rounded(0.4, 1), "mirror");
      case 3:
        return sggx(draw.rounded(0.1, 1), "lambert");
      case 4:
        return vmf(draw.rounded(0.4, 1), "mirror");
      case 5:
        return vmf(draw.rounded(0.05, 1), "lambert");
      default:
        return fiber(draw.rounded(0.3, 1), draw.below(2) ? "mirror" : "lambert");
    }
  };
  std::string toml;
  const std::size_t layers = 1 + draw.below(3);
  for (std::size_t k = 0; k < layers; ++k)
    toml += layer(medium(), draw.rounded(0.3, 1),
                  std::round(100 * std::exp(draw.between(-2.5, 1))) / 100);
  if (draw.below(3) == 0) toml += lambert_ground(draw.rounded(0, 1));
  return toml;
}

TEST(DeterministicAgainstWalk, RandomStacksAgreeAtPoints) {
  for (int n = 0; n < 20; ++n) {
    Draw draw{RandomStream(29, n, StreamPurpose::test)};
    const std::string toml = random_stack(draw);
    const Stack stack = stack_of(toml);
    const bool open = stack.is_open_below();
    const double mu = draw.between(0.05, 1) * (open && draw.below(2) ? -1 : 1);
    std::vector<Direction> points;  // those that go up first
    std::vector<double> mu_o;
    for (const double side : {1.0, -1.0})
      for (int k = 0; k < (open ? 2 : 4) && (open || side > 0); ++k) {
        mu_o.push_back(side * draw.between(0.05, 1));
        points.push_back(direction_from_mu_phi(mu_o.back(), draw.between(0, kPi)));
      }
    const Direction wi = direction_from_mu_phi(mu, 0);
    const DeterministicSolution s = solve_deterministic(
        stack, {.tolerance = 1e-4, .min_nodes = 12, .max_nodes = 24, .max_modes = 64});
    const double mu_i[] = {mu};
    const DeterministicField field = s.field(mu_i, mu_o);
    for (const Isa isa : {Isa::scalar, supported_isas().back()}) {
      Plan plan = make_plan(stack);
      plan.isa = isa;
      Simulation walk(stack, plan, wi, points, 7);
      walk.advance(std::getenv("LAMELLA_SOAK") ? 100000000 : 1000000);
      for (std::size_t k = 0; k < points.size(); ++k) {
        const SingleScattering single = single_scattering(stack, wi, points[k]);
        DeterministicValue f = field.multiple_refined(0, k, kPi - azimuth(points[k]));
        f.order[0] = single.layers + single.substrate;
        f.order[Order::all] += f.order[0];
        for (int order = 0; order < kSolvedOrders; ++order) {
          const Estimate e = testing::point_estimate(walk, order, static_cast<int>(k),
                                                     static_cast<int>(points.size()));
          EXPECT_NEAR(e.value, f.order[order].r,
                      testing::allowed_z() * e.standard_error + f.error.r + 1e-12)
              << to_text(isa) << '\n'
              << toml << "mu_i " << mu << " mu_o " << mu_o[k] << " order " << order + 1;
        }
        EXPECT_LT(f.error.r, 2e-3 * field.mean(0, 0, k)) << toml;
      }
    }
  }
}

}  // namespace
}  // namespace lamella
