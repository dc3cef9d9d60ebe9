#include <fmt/format.h>
#include <gtest/gtest.h>

#include "analytic/layered/single_scattering_model.h"
#include "tests/statistics/statistics.h"

namespace lamella::testing {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct HardMedium {
  std::string name;
  Medium medium;
  bool costly = false;  ///< phase() is a quadrature of milliseconds
};

// Both ends of every roughness, vertical and tilted, and what lies beyond them in a stack file.
std::vector<HardMedium> hard_media() {
  std::vector<HardMedium> list;
  const Direction tilted = normalized(Direction{0.6, 0.3, -0.2});
  for (const Direction axis : {Direction{0, 0, 1}, Direction{1, 0, 0}, tilted}) {
    for (const double alpha : {0.001, 1.0}) {
      const Sggx surface(Sggx::surface_matrix(alpha, axis)), fiber(Sggx::fiber_matrix(alpha, axis));
      list.push_back({fmt::format("surface mirror {}", alpha), MirrorFlakes<Sggx>{surface}});
      list.push_back({fmt::format("fiber mirror {}", alpha), MirrorFlakes<Sggx>{fiber}});
      list.push_back(
          {fmt::format("surface lambert {}", alpha), LambertFlakes<Sggx>{surface}, true});
      list.push_back({fmt::format("fiber lambert {}", alpha), LambertFlakes<Sggx>{fiber}, true});
    }
    for (const double alpha : {0.0, 1e-160, 1e-100, 1e-9, 1e-3, 0.01, 1.0, 1e9, kInfinity}) {
      const Vmf ndf(alpha, axis);
      list.push_back({fmt::format("vmf mirror {}", alpha), MirrorFlakes<Vmf>{ndf}});
      list.push_back({fmt::format("vmf lambert {}", alpha), LambertFlakes<Vmf>{ndf}, true});
    }
  }
  for (const std::array<double, 6>& s : {std::array<double, 6>{1, 1, 1e-12, 0, 0, 0},
                                         {1e-12, 1, 1, 0, 0, 0},
                                         {1, 1, 1, 1 - 1e-9, 0, 0},
                                         {1e12, 1, 1e-12, 0, 0, 0}})
    list.push_back({"near-singular matrix", MirrorFlakes<Sggx>{Sggx(s)}});
  list.push_back({"lambert sphere", LambertSphere{}});
  list.push_back({"rayleigh", Rayleigh{}});
  for (const double g : {-0.999999, 0.0, 1e-300, 0.999999})
    list.push_back({fmt::format("henyey-greenstein {}", g), HenyeyGreenstein{g}});
  return list;
}

std::vector<Direction> hard_directions() {
  std::vector<Direction> list;
  for (const double mu : {1.0, 0.5, 1e-3, 1e-7, 0.0, -1e-7, -0.5, -1.0})
    list.push_back(direction_from_mu_phi(mu, 0.7));
  list.push_back({1, 0, 0});
  list.push_back({0.6, 0, 0.8});
  return list;
}

std::string place(const HardMedium& m, Direction wi, Direction wo) {
  return fmt::format("{} from ({}, {}, {}) to ({}, {}, {})", m.name, wi.x, wi.y, wi.z, wo.x, wo.y,
                     wo.z);
}

TEST(HardCases, SigmaIsFiniteAndWithinItsBounds) {
  for (const HardMedium& m : hard_media()) {
    const bool vmf = m.name.rfind("vmf", 0) == 0;
    for (const Direction w : hard_directions()) {
      const double s = sigma(m.medium, w);
      ASSERT_TRUE(std::isfinite(s) && s >= 0) << place(m, w, w) << ' ' << s;
      // Shapes have eigenvalues up to 1; the matrices above up to 1e12.
      ASSERT_LE(s, m.name == "near-singular matrix" ? 1e6 : 1 + 1e-15) << place(m, w, w);
      ASSERT_TRUE(vmf || s > 0) << place(m, w, w);
    }
  }
}

TEST(HardCases, PhaseFunctionIsFiniteAndNotNegativeForEveryPairOppositeAndEqualOnesToo) {
  for (const HardMedium& m : hard_media()) {
    std::vector<Direction> directions = hard_directions();
    if (m.costly) directions = {directions[0], directions[3], directions[5], directions[6]};
    for (const Direction wi : directions) {
      std::vector<Direction> outgoing = directions;
      outgoing.insert(outgoing.end(), {wi, -wi});
      for (const Direction wo : outgoing) {
        const PhaseValue p = phase(m.medium, wi, wo);
        ASSERT_TRUE(std::isfinite(p.density) && p.density >= 0) << place(m, wi, wo) << p.density;
        ASSERT_TRUE(p.schlick >= 0 && p.schlick <= 1) << place(m, wi, wo);
      }
    }
  }
}

TEST(HardCases, SamplersReturnUnitDirections) {
  for (const HardMedium& m : hard_media()) {
    std::uint64_t seed = 0;
    for (const Direction wi : hard_directions()) {
      if (sigma(m.medium, wi) == 0) continue;
      RandomStream stream(++seed, 0, StreamPurpose::test);
      for (int n = 0; n < 200; ++n) {
        const Scatter s = std::visit(
            [&](const auto& medium) { return medium.collide(wi, stream).sample(stream); },
            m.medium);
        ASSERT_NEAR(length(s.wo), 1, 1e-14) << place(m, wi, s.wo);
        ASSERT_TRUE(s.schlick >= 0 && s.schlick <= 1) << place(m, wi, s.wo);
      }
    }
  }
}

Stack stack_of(const HardMedium& m, double depth, int layers, double albedo) {
  Stack stack;
  const Layer one{.medium_name = m.name,
                  .parameters = {},
                  .medium = m.medium,
                  .albedo = Rgb(albedo),
                  .thickness = depth / layers};
  stack.layers.assign(layers, one);
  return stack;
}

TEST(HardCases, SingleScatteringIsFiniteAndNotNegativeAtEveryDepth) {
  for (const HardMedium& m : hard_media()) {
    std::vector<Direction> directions = hard_directions();
    if (m.costly) directions = {directions[0], directions[3], directions[4], directions[6]};
    for (const double depth : {0.0, 1e-9, 1.0, 1e9, 1e300, kInfinity}) {
      // A quadrature does not depend on the depth.
      if (m.costly && depth != 1e-9 && depth != kInfinity) continue;
      const Stack stack = stack_of(m, depth, 1, 1);
      for (const Direction wi : directions)
        for (const Direction wo : directions) {
          if (wi.z == 0 && wo.z == 0) continue;
          if (stack.is_half_space() && (wi.z < 0 || wo.z < 0)) continue;
          const SingleScattering f = single_scattering(stack, wi, wo);
          ASSERT_TRUE(std::isfinite(f.layers.r) && f.layers.r >= 0)
              << place(m, wi, wo) << " depth " << depth << ": " << f.layers.r;
        }
      for (const Direction wi : directions) {
        const double passed = stack.is_half_space() && wi.z < 0 ? 0 : stack.uncollided(wi);
        ASSERT_TRUE(passed >= 0 && passed <= 1) << place(m, wi, wi) << depth;
      }
    }
  }
}

TEST(HardCases, NoAlbedoScattersNothingAndAThousandLayersAreOne) {
  const std::vector<Direction> directions = hard_directions();
  for (const HardMedium& m : hard_media()) {
    if (m.costly) continue;
    const Direction wi = directions[1], wo = directions[9];
    EXPECT_EQ(single_scattering(stack_of(m, 1, 1, 0), wi, wo).layers, Rgb());
    for (const double depth : {1e-9, 1.0, 1e9}) {
      const double one = single_scattering(stack_of(m, depth, 1, 1), wi, wo).layers.r;
      const double thousand = single_scattering(stack_of(m, depth, 1000, 1), wi, wo).layers.r;
      EXPECT_NEAR(thousand, one, 1e-11 * one) << place(m, wi, wo) << depth;
    }
  }
}

TEST(HardCases, ImportanceSamplingOfAnyStackIsFinite) {
  for (const HardMedium& m : hard_media()) {
    if (m.costly) continue;
    for (const double depth : {0.0, 1e-9, 1.0, 1e9, kInfinity}) {
      const SingleScatteringModel model(stack_of(m, depth, 2, 1));
      for (const Direction wo : hard_directions()) {
        if (depth == kInfinity && wo.z < 0) continue;
        for (const double u : {0x1p-33, 0.3, 1 - 0x1p-33}) {
          const auto wi = model.sample(wo, u, 1 - u, 0.5 * u);
          if (!wi) continue;
          ASSERT_NEAR(length(*wi), 1, 1e-14) << place(m, wo, *wi);
          const double pdf = model.pdf(*wi, wo);
          ASSERT_TRUE(std::isfinite(pdf) && pdf >= 0) << place(m, wo, *wi) << depth << ' ' << pdf;
        }
      }
    }
  }
}

}  // namespace
}  // namespace lamella::testing
