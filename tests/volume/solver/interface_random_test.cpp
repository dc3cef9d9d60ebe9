#include <gtest/gtest.h>

#include <cmath>

#include "phase/stack/single_scattering.h"
#include "tests/volume/run/draw.h"
#include "tests/volume/run/stacks.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/solver/deterministic.h"

// Walks against the solver at points of random stacks with interfaces and metals: the solver knows
// no ways out, the walks know no modes.

namespace lamella {
namespace {

using testing::Draw;

std::string random_interface(Draw& draw, bool may_be_rough) {
  const double ior = std::exp(draw.between(-0.3, 0.7));
  std::string toml = fmt::format("[[layer]]\nior = {:.2f}\n", ior);
  if (!may_be_rough || draw.below(2)) return toml + "interface = \"smooth\"\n";
  const char* masking[] = {"beta", "correlated", "separable"};
  return toml + fmt::format("interface = \"{}\"\nroughness = {}\nmasking = \"{}\"\n",
                            draw.below(2) ? "ggx" : "beckmann", draw.rounded(0.3, 0.8),
                            masking[draw.below(3)]);
}

std::string random_medium(Draw& draw) {
  switch (draw.below(6)) {
    case 0:
      return kSphere;
    case 1:
      return henyey_greenstein(draw.rounded(-0.5, 0.6));
    case 2:
      return sggx(draw.rounded(0.5, 1), "mirror");
    case 3:
      return sggx(draw.rounded(0.2, 1), "lambert");
    case 4:
      return vmf(draw.rounded(0.3, 1), "lambert");
    default:
      return fiber(draw.rounded(0.5, 1), "lambert");
  }
}

std::string random_ground(Draw& draw) {
  const std::string metal = fmt::format("[substrate]\nbsdf = \"conductor\"\neta = {}\nk = {}\n",
                                        draw.rounded(0.1, 2), draw.rounded(0, 4));
  switch (draw.below(4)) {
    case 0:
      return lambert_ground(draw.rounded(0, 1));
    case 1:
      return metal;
    case 2:
      return metal + fmt::format("distribution = \"{}\"\nroughness = {}\n",
                                 draw.below(2) ? "ggx" : "beckmann", draw.rounded(0.3, 0.8));
    default:
      return "";
  }
}

// At most one rough interface: two take the solver a minute.
std::string random_stack(Draw& draw) {
  std::string toml;
  bool rough = false;
  const std::size_t parts = 2 + draw.below(3);
  for (std::size_t k = 0; k < parts; ++k) {
    const bool interface = k == 0 || draw.below(2);
    const std::string part =
        interface ? random_interface(draw, !rough)
                  : layer(random_medium(draw), draw.rounded(0.3, 1), draw.rounded(0.1, 1.5));
    rough = rough || part.find("masking") != std::string::npos;
    toml += part;
  }
  toml += layer(random_medium(draw), draw.rounded(0.3, 1), draw.rounded(0.1, 1.5));
  return toml + random_ground(draw);
}

TEST(InterfaceSolver, RandomStacksAgreeWithWalksAtPoints) {
  const int stacks = is_soak() ? 400 : 20;
  for (int n = 0; n < stacks; ++n) {
    Draw draw{RandomStream(31, n, StreamPurpose::test)};
    const std::string toml = random_stack(draw);
    const Stack stack = stack_of(toml);
    const bool open = stack.is_open_below();
    const double mu = draw.between(0.1, 1) * (open && draw.below(2) ? -1 : 1);
    const Direction wi = direction_from_mu_phi(mu, 0);
    std::vector<Direction> points;  // those that go up first
    for (const double side : {1.0, -1.0})
      for (int k = 0; k < 2 && (open || side > 0); ++k)
        points.push_back(
            direction_from_mu_phi(side * draw.between(0.1, 1), draw.between(0.2, kPi)));
    const int count = static_cast<int>(points.size());
    const DeterministicSolution s = solve_deterministic(
        stack, {.tolerance = 1e-3, .max_nodes = 24, .max_modes = 48, .max_seconds = 1});
    for (const Isa isa : {Isa::scalar, supported_isas().back()}) {
      Plan plan = make_plan(stack);
      plan.isa = isa;
      Simulation walks(stack, plan, wi, points, 7);
      walks.advance(is_soak() ? 2000000 : 40000);
      for (int k = 0; k < count; ++k) {
        const DeterministicValue v = s.f(wi, points[k]);
        const auto agree = [&](const Estimate& e, double value, const std::string& what) {
          EXPECT_NEAR(e.value, value, testing::allowed_z() * e.standard_error + v.error.r + 1e-12)
              << to_text(isa) << ' ' << what << " mu_i " << mu << " mu_o " << points[k].z << '\n'
              << n << '\n'
              << toml;
        };
        for (int order = 0; order < kTallyOrders; ++order)
          agree(testing::point_estimate(walks, order, k, count), v.order[order].r,
                "order " + std::to_string(order + 1));
        const Estimate scattered = testing::point_estimate(walks, kTallyOrders, k, count);
        agree(scattered, v.order[Order::all].r - v.zero.r, "orders 1 and up");
        if (!plan.boundaries) continue;
        agree(batch_estimate(walks.batches(),
                             [&](const BatchTally& b) { return b.f[kZeroSlot * count + k]; }),
              v.zero.r, "order 0");
      }
    }
  }
}

}  // namespace
}  // namespace lamella
