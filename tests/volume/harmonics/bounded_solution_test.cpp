// Stacks with boundaries in spherical harmonics: against the solver of symmetric stacks, which
// takes them mode by mode, and conservation.
#include "volume/harmonics/bounded_solution.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

const std::string kSmooth = "[[layer]]\ninterface = \"smooth\"\nior = 1.5\n";
const std::string kRough = "[[layer]]\ninterface = \"ggx\"\nior = 1.5\nroughness = 0.4\n";
const std::string kMirror =
    "[substrate]\nbsdf = \"conductor\"\neta = 0.2\nk = 3\ndistribution = \"smooth\"\n";
const std::string kWhiteMirror =
    "[substrate]\nbsdf = \"conductor\"\neta = 1\nk = 1\nfresnel = \"one\"\ndistribution = "
    "\"smooth\"\n";

// One direction at one resolution, and f along others.
struct BoundedSolved {
  Stack stack;
  std::vector<Direction> wi, wo;
  BoundedTransport transport;
  BoundedSolution solution;

  BoundedSolved(const std::string& toml, Direction in, std::vector<Direction> out, int degree)
      : stack(stack_of(toml)),
        wi{in},
        wo(std::move(out)),
        transport(stack, 0, {.degree = degree, .depth_nodes = 8, .finest = 1e-4}, asked(stack, wo),
                  wi),
        solution(transport, 0, in) {}
  [[nodiscard]] std::array<double, kHarmonicParts> f(std::size_t o) const {
    const double phi[] = {azimuth(wo[o])};
    const auto parts = solution.f(wo[o].z > 0, o, 1, phi);
    std::array<double, kHarmonicParts> f{};
    for (int k = 0; k < kHarmonicParts; ++k)
      if (parts[k].size() > 0) f[k] = parts[k](0, 0);
    return f;
  }

 private:
  static std::vector<AskedCosine> asked(const Stack& stack, const std::vector<Direction>& out) {
    std::vector<AskedCosine> list;
    for (const Direction w : out)
      list.push_back({std::abs(w.z), w.z > 0 ? 1 : stack.index_of(stack.layers.size())});
    return list;
  }
};

TEST(BoundedSolution, IsThatOfTheSymmetricSolver) {
  struct Case {
    std::string toml;
    int degree;
    double tolerance;
  };
  const std::string iso = layer(kIsotropic, 0.9, 1);
  for (const Case& c :
       {Case{kSmooth + iso, 24, 1e-6}, Case{kSmooth + iso + lambert_ground(0.5), 24, 1e-6},
        Case{kSmooth + iso + "[[layer]]\ninterface = \"smooth\"\nior = 1.2\n" +
                 layer(henyey_greenstein(0.5), 0.8, 0.5),
             24, 1e-6},
        Case{kRough + iso + lambert_ground(0.5), 24, 1e-4},
        Case{kSmooth + layer(sggx(0.6, "mirror"), 0.9, 0.7) + lambert_ground(0.3), 26, 1e-3},
        Case{kSmooth + layer(kSphere, 0.9, kInfinity), 20, 1e-5},
        Case{kSmooth + layer(vmf(0.6, "lambert"), 0.9, 1), 24, 1e-5}, Case{iso + kMirror, 16, 1e-6},
        Case{kSmooth + layer(henyey_greenstein(0.3), 0.8, 0.5) + kMirror, 16, 1e-6}}) {
    const Stack stack = stack_of(c.toml);
    const DeterministicSolution exact = solve_deterministic(stack, {.tolerance = 1e-6});
    for (const double mu : {0.7, 0.05, -0.5}) {
      if (mu < 0 && !stack.is_open_below()) continue;
      const Direction wi = direction_from_mu_phi(mu, 0.4);
      std::vector<Direction> wo{direction_from_mu_phi(0.6, 2), direction_from_mu_phi(0.3, 5)};
      if (stack.is_open_below()) wo.push_back(direction_from_mu_phi(-0.4, 1));
      const BoundedSolved solved(c.toml, wi, wo, c.degree);
      const HarmonicEnergies& e = solved.solution.energies();
      const double list[] = {mu};
      const DeterministicEnergies expected = exact.energies(list).front();
      const double bound = 2e-8 + 0.1 * c.tolerance;
      for (int order = 0; order < 4; ++order) {
        EXPECT_NEAR((mu > 0 ? e.up : e.down)[order], expected.reflected[order].r, bound)
            << c.toml << " mu " << mu << " order " << order + 1;
        EXPECT_NEAR((mu > 0 ? e.down : e.up)[order], expected.transmitted[order].r, bound)
            << c.toml << " mu " << mu << " order " << order + 1;
      }
      EXPECT_NEAR((mu > 0 ? e.zero_up : e.zero_down) + e.mirrored, expected.zero_reflected.r, bound)
          << c.toml << " mu " << mu;
      EXPECT_NEAR(mu > 0 ? e.zero_down : e.zero_up, expected.zero_transmitted.r, bound)
          << c.toml << " mu " << mu;
      EXPECT_NEAR(e.uncollided, expected.uncollided.r, 1e-12);
      EXPECT_NEAR(e.absorbed, expected.absorbed.r, 4 * bound) << c.toml << " mu " << mu;
      EXPECT_NEAR(e.lost, expected.lost.r, 4 * bound) << c.toml << " mu " << mu;
      EXPECT_NEAR(e.sum(), 1, 4 * bound) << c.toml << " mu " << mu;
      for (std::size_t o = 0; o < wo.size(); ++o) {
        const DeterministicValue f = exact.f(wi, wo[o]);
        const auto found = solved.f(o);
        const double near = c.tolerance * f.order[Order::all].r + 2 * f.error.r;
        for (int k = 0; k < kHarmonicOrders; ++k)
          EXPECT_NEAR(found[k], f.order[k + 1].r, near)
              << c.toml << " mu " << mu << " wo " << o << " order " << k + 2;
        const ClosedOrders closed = closed_orders(stack, wi, wo[o]);
        EXPECT_NEAR(found[kFirstPart] + closed.one.r, f.order[Order::one].r, near)
            << c.toml << " mu " << mu << " wo " << o;
        EXPECT_NEAR(found[kZeroPart] + closed.zero.r, f.zero.r, near)
            << c.toml << " mu " << mu << " wo " << o;
      }
    }
  }
}

TEST(BoundedSolution, KeepsAllLightBetweenSmoothBoundaries) {
  const std::string fibers = sggx(0.6, "mirror") + "\nshape = \"fiber\"\naxis = [1, 0.2, 0.3]";
  for (const std::string& toml :
       {kSmooth + layer(fibers, 1, 1) + lambert_ground(1), layer(fibers, 1, 1) + kWhiteMirror,
        kSmooth + layer(fibers, 1, 1) + kWhiteMirror,
        kSmooth + layer("medium = \"sggx\"\nmatrix = [0.5, 0.7, 1, 0.1, 0.05, 0]", 1, 1) +
            "[[layer]]\ninterface = \"smooth\"\nior = 1.2\n" + layer(kIsotropic, 1, 0.5)})
    for (const double mu : {0.9, 0.2}) {
      const BoundedSolved solved(toml, direction_from_mu_phi(mu, 1), {}, 24);
      EXPECT_NEAR(solved.solution.energies().sum(), 1, 1e-6) << toml << " mu " << mu;
    }
}

TEST(BoundedSolution, IsReciprocalAndTurnsWithTheStack) {
  const auto toml = [](double turn) {
    const double x = std::cos(turn), y = std::sin(turn);
    return kRough +
           layer(fmt::format("{}\naxis = [{}, {}, 0.5]", sggx(0.6, "lambert"), x, y), 0.9, 1) +
           "[[layer]]\ninterface = \"smooth\"\nior = 1.3\n" + layer(kSphere, 0.9, 0.5) +
           lambert_ground(0.6);
  };
  const Direction a = direction_from_mu_phi(0.8, 0.3), b = direction_from_mu_phi(0.35, 2);
  const auto sum = [](const std::array<double, kHarmonicParts>& f) {
    double all = 0;
    for (const int k : kSummedParts) all += f[k];
    return all;
  };
  const double forth = sum(BoundedSolved(toml(0), a, {b}, 20).f(0));
  const double back = sum(BoundedSolved(toml(0), b, {a}, 20).f(0));
  EXPECT_NEAR(forth / back, 1, 1e-5);
  const auto turned = [](Direction w, double turn) {
    return direction_from_mu_phi(w.z, azimuth(w) + turn);
  };
  const double other = sum(BoundedSolved(toml(0.7), turned(a, 0.7), {turned(b, 0.7)}, 20).f(0));
  EXPECT_NEAR(forth / other, 1, 1e-6);
}

}  // namespace
}  // namespace lamella
