#include <gtest/gtest.h>

#include <cmath>

#include "phase/stack/single_scattering.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/solver/deterministic.h"

// The solver against a plain random walk in one slab, written here for that purpose alone: it
// shares only the media with the solver.

namespace lamella {
namespace {

struct Tally {
  double sum = 0, squares = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
  }
};
constexpr int kWalks = 100000;

// Per order 1, 2, 3, 4+: f towards each target, then reflected and transmitted energy.
struct Walk {
  std::vector<std::array<Tally, 4>> f;
  std::array<Tally, 4> reflected, transmitted;
};

Walk walk_slab(const Layer& layer, Direction wi, const std::vector<Direction>& targets) {
  Walk result;
  result.f.resize(targets.size());
  const double thickness = layer.depth();
  std::visit(
      [&](const auto& medium) {
        for (int n = 0; n < kWalks; ++n) {
          RandomStream stream(11, n, StreamPurpose::test);
          std::vector<std::array<double, 4>> seen(targets.size(), std::array<double, 4>{});
          Direction w = wi;
          double depth = wi.z > 0 ? 0 : thickness;
          for (int order = 1;; ++order) {
            const double area = medium.sigma(w);
            depth += area > 0 ? w.z * stream.exponential() / area : w.z * 1e300;
            if (!(depth > 0 && depth < thickness)) {
              if (order > 1)
                (depth <= 0 ? result.reflected : result.transmitted)[std::min(order - 2, 3)].add(1);
              break;
            }
            const auto event = medium.collide(w, stream);
            for (std::size_t k = 0; k < targets.size(); ++k) {
              const Direction wo = targets[k];
              const double rest = wo.z > 0 ? depth : thickness - depth;
              seen[k][std::min(order - 1, 3)] +=
                  layer.albedo.r * event.density(wo).density *
                  std::exp(-medium.sigma(-wo) * rest / std::abs(wo.z)) / std::abs(wo.z);
            }
            if (stream.uniform() >= layer.albedo.r) break;
            w = -event.sample(stream).wo;
          }
          for (std::size_t k = 0; k < targets.size(); ++k)
            for (int o = 0; o < 4; ++o) result.f[k][o].add(seen[k][o]);
        }
      },
      layer.medium);
  return result;
}

void expect_agrees(const Tally& tally, double exact, const std::string& what) {
  const double mean = tally.sum / kWalks;
  const double variance = tally.squares / kWalks - mean * mean;
  const double error = std::sqrt(variance / kWalks);
  // About 200 comparisons at 4.5 standard errors: a false alarm once in 700 runs of other seeds.
  EXPECT_NEAR(mean, exact, 4.5 * error + 1e-12) << what;
}

TEST(DeterministicAgainstWalk, SlabsAgreeOrderByOrder) {
  for (const std::string& medium : {sggx(0.5, "mirror"), fiber(0.4, "lambert"), vmf(0.5, "lambert"),
                                    vmf(0.5, "mirror"), henyey_greenstein(0.6)}) {
    const Stack stack = stack_of(layer(medium, 0.9, 1.8));
    const DeterministicSolution s =
        solve_deterministic(stack, {.tolerance = 1e-5, .max_nodes = 16});
    const std::vector<Direction> targets{direction_from_mu_phi(0.8, 0.5),
                                         direction_from_mu_phi(0.25, 2.5),
                                         direction_from_mu_phi(-0.6, 1.2)};
    for (const double mu : {0.7, -0.35}) {
      const Direction wi = direction_from_mu_phi(mu, 0);
      const Walk walk = walk_slab(stack.layers[0], wi, targets);
      const double list[] = {mu}, mu_o[] = {targets[0].z, targets[1].z, targets[2].z};
      const DeterministicField field = s.field(list, mu_o);
      const auto f = [&](std::size_t k, int order) {
        return order == 0 ? single_scattering(stack, wi, targets[k]).layers.r
                          : field.multiple(0, k, kPi - azimuth(targets[k])).order[order].r;
      };
      const DeterministicEnergies e = s.energies(list)[0];
      for (int order = 0; order < 4; ++order) {
        const std::string what = fmt::format("{} mu {} order {}", medium, mu, order + 1);
        for (std::size_t k = 0; k < targets.size(); ++k)
          expect_agrees(walk.f[k][order], f(k, order), what + fmt::format(" target {}", k));
        const bool above = mu > 0;  // the walk's 'reflected' is what leaves at the top
        expect_agrees(walk.reflected[order], (above ? e.reflected : e.transmitted)[order].r,
                      what + " up");
        expect_agrees(walk.transmitted[order], (above ? e.transmitted : e.reflected)[order].r,
                      what + " down");
      }
    }
  }
}

}  // namespace
}  // namespace lamella
