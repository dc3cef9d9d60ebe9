#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "compare/request/substrate_model.h"
#include "phase/stack/stack_file.h"
#include "tests/volume/run/draw.h"
#include "tests/volume/run/stacks.h"
#include "volume/solver/answer_check.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/deterministic.h"

// The solver against walks where interfaces bend the light: random stacks of every kind that the
// solver takes, and the ends of what a rough boundary may be. They share media and facets, no more.

namespace lamella {
namespace {

using testing::Draw;

std::string random_color(Draw& draw, double low, double high) {
  const double r = draw.rounded(low, high), g = draw.rounded(low, high),
               b = draw.rounded(low, high);
  return fmt::format("[{}, {}, {}]", r, g, b);
}

std::string random_interface(Draw& draw, double ior) {
  const std::string head = "[[layer]]\ninterface = ";
  if (draw.below(2) == 0) return fmt::format("{}\"smooth\"\nior = {}\n", head, ior);
  return fmt::format("{}\"{}\"\nior = {}\nroughness = {}\nmasking = \"{}\"\n", head,
                     draw.below(2) ? "ggx" : "beckmann", ior, draw.rounded(0.25, 0.8),
                     draw.below(3) == 0 ? "separable" : "beta");
}

std::string random_medium(Draw& draw) {
  std::string keys;
  switch (draw.below(9)) {
    case 0:
      keys = "medium = \"lambert_sphere\"";
      break;
    case 1:
      keys = fmt::format("medium = \"henyey_greenstein\"\ng = {}", draw.rounded(-0.6, 0.7));
      break;
    case 2:
      keys = fmt::format("medium = \"sggx\"\nroughness = {}", draw.rounded(0.4, 1));
      break;
    case 3:
      keys = fmt::format("medium = \"sggx\"\nroughness = {}\nflake = \"lambert\"",
                         draw.rounded(0.2, 1));
      break;
    case 4:
      keys = fmt::format("medium = \"vmf_flake\"\nroughness = {}\nflake = \"mirror\"",
                         draw.rounded(0.4, 1));
      break;
    case 5:
      keys = fmt::format("medium = \"vmf_flake\"\nroughness = {}", draw.rounded(0.1, 1));
      break;
    case 6:
      keys = fmt::format("medium = \"sggx\"\nshape = \"fiber\"\naxis = [0, 0, 1]\nroughness = {}",
                         draw.rounded(0.3, 1));
      break;
    case 7:
      keys = "medium = \"rayleigh\"";
      break;
    default:
      keys = "medium = \"henyey_greenstein\"\ng = 0";  // absorbs alone, see below
      return fmt::format("[[layer]]\n{}\nalbedo = 0\nthickness = {}\n", keys,
                         draw.rounded(0.05, 0.5));
  }
  return fmt::format(
      "[[layer]]\n{}\nalbedo = {}\nthickness = {}\n", keys,
      draw.below(3) == 0 ? random_color(draw, 0.3, 1) : to_text(draw.rounded(0.3, 1)),
      std::round(100 * std::exp(draw.between(-2.5, 0.7))) / 100);
}

std::string random_substrate(Draw& draw) {
  switch (draw.below(6)) {
    case 0:
      return fmt::format(
          "[substrate]\nbsdf = \"conductor\"\neta = {}\nk = {}\ndistribution = \"ggx\"\n"
          "roughness = {}\n",
          random_color(draw, 0.2, 2), random_color(draw, 1, 5), draw.rounded(0.3, 0.8));
    case 1:
      return fmt::format("[substrate]\nbsdf = \"lambert\"\nalbedo = {}\n", draw.rounded(0, 1));
    case 2:
      return fmt::format("[substrate]\nbsdf = \"eon\"\nalbedo = {}\nroughness = {}\n",
                         random_color(draw, 0.1, 1), draw.rounded(0, 1));
    default:
      return "";
  }
}

Stack stack_of(const std::string& toml) {
  return with_surface_model(parse_stack(toml, "test", "test"));
}

// The first interface stands on top, below a medium, or below nothing but air.
std::string random_stack(Draw& draw) {
  const double iors[] = {1.5, 1.33, 0.75, 2.2, 1.1, 1};
  std::string toml;
  if (draw.below(4) == 0) toml += random_medium(draw);
  const std::size_t interfaces = 1 + draw.below(2);
  for (std::size_t k = 0; k < interfaces; ++k) {
    toml += random_interface(draw, iors[draw.below(k == 0 ? 5 : 6)]);
    if (draw.below(4) != 0) toml += random_medium(draw);
  }
  return toml + random_substrate(draw);
}

// f at points and the ledger, by both.
void expect_agreement(const std::string& toml, const Stack& stack, Direction wi,
                      const DeterministicSolution& solution, const std::vector<Direction>& points,
                      std::uint64_t walks) {
  Simulation walk(stack, make_plan(stack), wi, points, 7);
  walk.advance(testing::soaked(walks));
  const int channels = walk.plan().channels;
  const double mu[] = {wi.z};
  const DeterministicEnergies solved = solution.energies(mu)[0];
  const double bound = solution.accuracy().error;
  const auto compare = [&](const std::string& what, const Estimate& e, double expected,
                           double error) {
    // 1e-7: shares of narrow facets, by quadrature.
    EXPECT_NEAR(e.value, expected, testing::allowed_z() * e.standard_error + error + 1e-7)
        << what << " mu_i " << wi.z << " bound " << error << '\n'
        << toml;
  };
  for (int c = 0; c < channels; ++c) {
    const auto energy = [&](const auto& of) {
      return batch_estimate(walk.batches(), [&](const BatchTally& b) { return of(b.energy); });
    };
    const auto side = [&](const std::array<EnergySums::Channels, kTallyOrders>& orders,
                          const EnergySums::Channels& zero) {
      double sum = zero[c];
      for (const auto& order : orders) sum += order[c];
      return sum;
    };
    const bool above = wi.z > 0;
    const double up = (above ? solved.reflected : solved.transmitted)[4][c];
    const double down = (above ? solved.transmitted : solved.reflected)[4][c];
    compare("up", energy([&](const EnergySums& s) { return side(s.up, s.zero_up); }), up, bound);
    compare("down", energy([&](const EnergySums& s) { return side(s.down, s.zero_down); }), down,
            bound);
    compare("absorbed", energy([&](const EnergySums& s) { return s.absorbed[c]; }),
            solved.absorbed[c], bound);
    compare("lost", energy([&](const EnergySums& s) { return s.lost[c]; }), solved.lost[c], bound);
    compare("uncollided", energy([&](const EnergySums& s) { return s.uncollided[c]; }),
            solved.uncollided[c], 1e-12);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Estimate e = batch_estimate(walk.batches(), [&](const BatchTally& b) {
        double sum = 0;
        for (int o = 0; o < walk.plan().order_slots(); ++o)
          sum += b.f[static_cast<std::size_t>(o * channels + c) * points.size() + k];
        return sum;
      });
      const DeterministicValue v = solution.f(wi, points[k]);
      compare(fmt::format("f channel {} mu_o {} phi {}", c, points[k].z, azimuth(points[k])), e,
              v.order[Order::all][c], v.error[c]);
    }
  }
}

TEST(InterfaceTruth, RandomStacksAgreeWithWalks) {
  int rough = 0, open = 0, below = 0, accurate = 0;
  for (int n = 0; n < 20; ++n) {
    Draw draw{RandomStream(31, n, StreamPurpose::test)};
    const std::string toml = random_stack(draw);
    const Stack stack = stack_of(toml);
    ASSERT_FALSE(why_not_deterministic(stack)) << toml;
    const bool is_open = stack.is_open_below();
    const double mu = draw.between(0.1, 1) * (is_open && draw.below(2) ? -1 : 1);
    std::vector<Direction> points;  // those that go up first
    for (const double side : {1.0, -1.0})
      for (int k = 0; k < (is_open ? 2 : 3) && (is_open || side > 0); ++k)
        points.push_back(direction_from_mu_phi(side * draw.between(0.1, 1), draw.between(0, kPi)));
    const DeterministicSolution s = solve_deterministic(stack, {.tolerance = 1e-2,
                                                                .min_nodes = 8,
                                                                .max_nodes = 12,
                                                                .max_modes = 32,
                                                                .isa = supported_isas().back()});
    EXPECT_FALSE(why_no_answer(s.accuracy())) << toml;
    accurate += s.accuracy().error < 2e-2;
    const double list[] = {mu};
    const Rgb sum = s.energies(list)[0].sum();
    EXPECT_NEAR(sum.g, 1, 1e-8) << toml;
    expect_agreement(toml, stack, direction_from_mu_phi(mu, 0), s, points, 20000);
    rough += stack.has_rough_interfaces();
    open += is_open;
    below += mu < 0;
  }
  // The bounds, which the comparison allows for, are small: the few nodes and modes are too few for
  // lobes that a low index refracts.
  EXPECT_GE(accurate, 12) << accurate;
  // All kinds were among them.
  EXPECT_GT(rough, 5);
  EXPECT_LT(rough, 16);
  EXPECT_GT(open, 4);
  EXPECT_GT(below, 2);
}

// Every one is answered within the bound that the solver tells, or refused in words.
TEST(InterfaceTruth, RoughEndsAreAnsweredWithinTheirBoundsOrSaidToBeNoAnswer) {
  const auto interface = [](const std::string& shape, double ior, double alpha) {
    return fmt::format("[[layer]]\ninterface = \"{}\"\nior = {}\nroughness = {}\n", shape, ior,
                       alpha);
  };
  const auto conductor = [](const std::string& shape, double eta, double k, double alpha) {
    return fmt::format(
        "[substrate]\nbsdf = \"conductor\"\neta = {}\nk = {}\ndistribution = \"{}\"\n"
        "roughness = {}\n",
        eta, k, shape, alpha);
  };
  const std::string fog =
      "[[layer]]\nmedium = \"henyey_greenstein\"\ng = 0.3\nalbedo = 0.9\nthickness = 0.5\n";
  const std::string ground = "[substrate]\nbsdf = \"lambert\"\nalbedo = 0.7\n";
  int answers = 0;
  const bool soak = std::getenv("LAMELLA_SOAK") != nullptr;
  for (const std::string shape : {"ggx", "beckmann"}) {
    if (shape == "beckmann" && !soak) continue;
    std::vector<std::string> cases;
    for (const double alpha : {1e-4, 1.0})
      for (const double ior : {1.0001, 0.7, 3.0})
        cases.push_back(interface(shape, ior, alpha) + fog + ground);
    for (const double alpha : {1e-4, 1.0})
      cases.push_back(interface(shape, 1.5, alpha) + fog + interface(shape, 1, alpha));
    for (const double alpha : {1e-4, 0.3, 1.0})
      for (const double k : {0.0, 20.0}) {
        cases.push_back(conductor(shape, 1.5, k, alpha));
        cases.push_back(interface(shape, 1.5, 0.3) + fog + conductor(shape, 0.2, k, alpha));
      }
    for (const std::string& toml : cases) {
      const Stack stack = stack_of(toml);
      const DeterministicSolution s = solve_deterministic(stack, {.tolerance = 1e-3,
                                                                  .max_nodes = 12,
                                                                  .max_modes = 24,
                                                                  .max_seconds = 600,
                                                                  .isa = supported_isas().back()});
      const bool open = stack.is_open_below();
      // An error of 1 claims nothing either: coarser nodes, which would tell, were all there were.
      if (why_no_answer(s.accuracy()) || s.accuracy().error >= 1) {
        EXPECT_FALSE(s.accuracy().reached) << toml;
        continue;
      }
      ++answers;
      for (const double mu : {1.0, open ? -0.5 : 0.3}) {
        const double list[] = {mu};
        const DeterministicEnergies e = s.energies(list)[0];
        EXPECT_NEAR(e.sum().g, 1, std::max(1e-8, 2 * s.accuracy().error)) << toml << mu;
        std::vector<Direction> points{direction_from_mu_phi(0.8, 2), direction_from_mu_phi(0.2, 1)};
        if (open) points.push_back(direction_from_mu_phi(-0.6, 2.5));
        for (const Direction& wo : points) {
          const DeterministicValue v = s.f(direction_from_mu_phi(mu, 0), wo);
          EXPECT_TRUE(std::isfinite(v.order[Order::all].g) && std::isfinite(v.error.g)) << toml;
          EXPECT_GE(v.order[Order::all].g, -v.error.g - 1e-12) << toml;
        }
        expect_agreement(toml, stack, direction_from_mu_phi(mu, 0), s, points, 8000);
      }
    }
  }
  EXPECT_GT(answers, soak ? 20 : 10);
}

// A closed form below that tells x from y is not solved as if it did not.
TEST(InterfaceTruth, KnowsGroundsThatDifferAlongXAndY) {
  const auto ground = [](const std::string& keys) {
    return with_surface_model(
        parse_stack("[[layer]]\nmedium = \"henyey_greenstein\"\nalbedo = 0.9\nthickness = 0.5\n"
                    "[substrate]\nbsdf = \"microfacet\"\nroughness = 0.6\n" +
                        keys,
                    "test", "test"));
  };
  EXPECT_TRUE(ground("").is_symmetric_about_z());
  EXPECT_TRUE(ground("roughness_y = 0.6\n").is_symmetric_about_z());
  EXPECT_FALSE(ground("roughness_y = 0.3\n").is_symmetric_about_z());
}

}  // namespace
}  // namespace lamella
