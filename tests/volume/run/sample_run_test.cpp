#include "volume/run/sample_run.h"

#include <gtest/gtest.h>

#include <cmath>

#include "phase/stack/builtin_stacks.h"
#include "tests/volume/run/stacks.h"

namespace lamella {
namespace {

using testing::layer;
using testing::stack_from;

constexpr std::uint64_t kWalks = 20000;

WalkSamples all_of(const SampleRun& run, std::uint64_t walks) {
  WalkSamples all;
  all.channels = run.plan().channels;
  for (std::uint64_t k = 0; k < run.chunks(walks); ++k) {
    const WalkSamples s = run.take(k, walks);
    all.walks += s.walks;
    const auto add = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    add(all.wi, s.wi);
    add(all.wo, s.wo);
    add(all.weight, s.weight);
    add(all.order, s.order);
    add(all.side, s.side);
  }
  return all;
}

// Energies by slot of order, upwards and downwards, and what went straight.
struct Energies {
  std::array<std::array<double, 3>, kTallyOrders + 1> up{}, down{};
  std::array<double, 3> straight{}, specular{};
};

Energies of_samples(const WalkSamples& s) {
  Energies e;
  for (std::size_t j = 0; j < s.count(); ++j)
    for (int c = 0; c < s.channels; ++c) {
      const double w = s.weight[s.channels * j + c] / static_cast<double>(s.walks);
      const bool up = s.side[j] > 0, delta = std::abs(s.side[j]) == 2;
      const bool straight = delta && s.order[j] == 0 && up == (s.wi[3 * j + 2] < 0);
      if (straight) {
        e.straight[c] += w;
        continue;
      }
      (up ? e.up : e.down)[order_slot(s.order[j])][c] += w;
      if (delta) e.specular[c] += w;
    }
  return e;
}

Energies of_simulation(const Simulation& simulation) {
  Energies e;
  const auto add = [&](auto& to, const auto& from) {
    for (int c = 0; c < 3; ++c) to[c] += from[c] / static_cast<double>(simulation.walks());
  };
  for (const BatchTally& b : simulation.batches()) {
    for (int k = 0; k < kTallyOrders; ++k) {
      add(e.up[k], b.energy.up[k]);
      add(e.down[k], b.energy.down[k]);
    }
    add(e.up[kZeroSlot], b.energy.zero_up);
    add(e.down[kZeroSlot], b.energy.zero_down);
    add(e.straight, b.energy.uncollided);
    add(e.specular, b.energy.specular_up);
    add(e.specular, b.energy.specular_down);
  }
  return e;
}

struct SampledCase {
  std::string name;
  Stack stack;
  Direction wi;
};

std::vector<SampledCase> sampled_cases() {
  const std::string slab = layer("medium = 'sggx'\nroughness = 0.4\nthickness = 1\nalbedo = 0.8");
  const std::string spheres =
      layer("medium = 'lambert_sphere'\nthickness = 0.7\nalbedo = [0.9, 0.5, 0.2]");
  const std::string ground = "[substrate]\nbsdf = 'lambert'\nalbedo = [0.2, 0.5, 0.8]\n";
  const Direction slant = direction_from_degrees(60, 25);
  return {
      {"one medium, grey", load_stack("lambert_sphere_halfspace"), slant},
      {"colour by order", stack_from(spheres), slant},
      {"weights", stack_from(slab + spheres + ground), slant},
      {"forced first collision",
       stack_from(layer("medium = 'henyey_greenstein'\ng = 0.5\nthickness = 0.01")), slant},
      {"from below", stack_from(slab), direction_from_degrees(140, 0)},
      {"thinned", stack_from(layer("medium = 'rayleigh'\nthickness = inf\nalbedo = 0.99999")),
       slant},
      {"null collisions",
       stack_from(layer("medium = 'vmf_flake'\nroughness = 0.5\nthickness = 0.5")), slant},
      {"interfaces alone", load_stack("frosted_plate"), slant},
      {"a coat over spheres", load_stack("coated_lambert_sphere"), slant},
      {"a smooth coat in double", load_stack("coated_copper"), slant},
      {"delta flakes in double",
       stack_from(layer("medium = 'vmf_flake'\nflake = 'mirror'\nroughness = 0\nthickness = 1")),
       slant},
      {"a grid", load_stack("blotchy_layer"), slant},
  };
}

// Weights are rounded to float: each is off by 2^-24 of itself at the most, and so are sums of
// them, whose terms are positive; fixed point on lanes adds 2^-33 per weight.
TEST(WalksOneByOne, HaveTheEnergiesOfTheSimulationOfTheSameSeed) {
  for (const Isa isa : {Isa::scalar, supported_isas().back()})
    for (const SampledCase& c : sampled_cases()) {
      SCOPED_TRACE(c.name + ", " + to_text(isa));
      Plan plan = make_plan(c.stack);
      plan.isa = isa;
      const SampleRun run(c.stack, plan, c.wi, 5);
      const WalkSamples samples = all_of(run, kWalks);
      EXPECT_EQ(samples.walks, kWalks);
      Simulation counted(c.stack, plan, c.wi, Estimator::analog, CellGrid{2, 2, false}, 5);
      counted.advance(kWalks);
      const Energies got = of_samples(samples), expected = of_simulation(counted);
      const double tolerance = 0x1p-24 + 0x1p-30;
      for (int ch = 0; ch < plan.channels; ++ch) {
        for (int k = 0; k <= kTallyOrders; ++k) {
          EXPECT_NEAR(got.up[k][ch], expected.up[k][ch], tolerance) << "up, slot " << k;
          EXPECT_NEAR(got.down[k][ch], expected.down[k][ch], tolerance) << "down, slot " << k;
        }
        EXPECT_NEAR(got.straight[ch], expected.straight[ch], tolerance);
        EXPECT_NEAR(got.specular[ch], expected.specular[ch], tolerance);
      }
    }
}

TEST(WalksOneByOne, GoIntoTheCellsThatTheSimulationCounts) {
  const Stack stack = load_stack("sggx_slab");
  Plan plan = make_plan(stack);
  plan.isa = supported_isas().back();
  const Direction wi = direction_from_degrees(50, 0);
  Simulation counted(stack, plan, wi, Estimator::analog, CellGrid{4, 8, false}, 3);
  counted.advance(kWalks);
  const CellTargets& targets = counted.targets();
  std::vector<double> cells(targets.count()), expected(targets.count());
  const WalkSamples s = all_of(SampleRun(stack, plan, wi, 3), kWalks);
  for (std::size_t j = 0; j < s.count(); ++j) {
    const Direction wo{s.wo[3 * j], s.wo[3 * j + 1], s.wo[3 * j + 2]};
    EXPECT_NEAR(dot(wo, wo), 1, 4e-6);
    EXPECT_EQ(wo.z > 0, s.side[j] > 0);
    if (std::abs(s.side[j]) == 1) cells[targets.find(wo)] += s.weight[j];
  }
  for (const BatchTally& b : counted.batches())
    for (int slot = 0; slot < kTallyOrders; ++slot)
      for (int k = 0; k < targets.count(); ++k)
        expected[k] += b.f[slot * targets.count() + k] * targets.grid.projected_solid_angle();
  // A direction at a cell's edge may fall into the next one, as its azimuth is found in float or in
  // double: one walk of 10000 or so.
  for (int k = 0; k < targets.count(); ++k) EXPECT_NEAR(cells[k], expected[k], 3) << k;
}

TEST(WalksOneByOne, AreTheSameInWhateverChunksOfARun) {
  const Stack stack = load_stack("vmf_sand");
  Plan plan = make_plan(stack);
  plan.isa = supported_isas().back();
  const SampleRun run(stack, plan, direction_from_degrees(30, 0), 9);
  // The first chunk of a long run, and all of a short one.
  const std::uint64_t few = 1000;
  const WalkSamples shorter = run.take(0, few), longer = run.take(0, 100 * few);
  ASSERT_LT(shorter.count(), longer.count());
  for (std::size_t j = 0; j < shorter.count(); ++j) {
    EXPECT_EQ(shorter.order[j], longer.order[j]);
    EXPECT_EQ(shorter.wo[3 * j], longer.wo[3 * j]);
    EXPECT_EQ(shorter.weight[3 * j + 2], longer.weight[3 * j + 2]);
  }
}

// Of a law of w_i: E mu is 1/2 or 2/3, E mu^2 is 1/3 or 1/2, E of x and y is 0; and the energy is
// the law's mean of the simulation's energies.
TEST(WalksOneByOne, DrawTheirLightByTheLaw) {
  const Stack white = stack_from(layer("medium = 'rayleigh'\nthickness = 1\nalbedo = 0.5") +
                                 "[substrate]\nbsdf = 'lambert'\nalbedo = 1\n");
  for (const Isa isa : {Isa::scalar, supported_isas().back()})
    for (const IncidentLaw law : {IncidentLaw::uniform, IncidentLaw::cosine}) {
      SCOPED_TRACE(to_text(isa));
      Plan plan = make_plan(white);
      plan.isa = isa;
      const WalkSamples s = all_of(SampleRun(white, plan, law, 2), kWalks);
      double energy = 0;
      for (const float w : s.weight) energy += w / static_cast<double>(s.walks);
      // The mean over the law, by Gauss and Legendre's rule of 3 nodes in mu or in mu^2.
      const double nodes[] = {0.1127016653792583, 0.5, 0.8872983346207417};
      const double weights[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
      double mean = 0;
      for (int k = 0; k < 3; ++k) {
        const double mu = law == IncidentLaw::uniform ? nodes[k] : std::sqrt(nodes[k]);
        Simulation one(white, plan, direction_from_mu_phi(mu, 0), {}, 11);
        one.advance(4 * kWalks);
        double sum = 0;
        for (const BatchTally& b : one.batches())
          for (const auto& order : b.energy.up) sum += order[0];
        mean += weights[k] * sum / (4.0 * kWalks);
      }
      // Standard errors below 0.5 / sqrt(20000) each; the rule is off by less than 0.004, as more
      // nodes tell.
      EXPECT_NEAR(energy, mean, 0.02);
    }
  // Whether or not light scatters, a walk through white, thin layers leaves: every w_i is seen.
  const Stack open = stack_from(layer("medium = 'rayleigh'\nthickness = 0.05"));
  for (const Isa isa : {Isa::scalar, supported_isas().back()})
    for (const IncidentLaw law : {IncidentLaw::uniform, IncidentLaw::cosine}) {
      Plan plan = make_plan(open);
      plan.isa = isa;
      const WalkSamples s = all_of(SampleRun(open, plan, law, 2), kWalks);
      ASSERT_EQ(s.count(), kWalks);
      double x = 0, y = 0, mu = 0, mu2 = 0;
      for (std::size_t j = 0; j < s.count(); ++j) {
        x += s.wi[3 * j];
        y += s.wi[3 * j + 1];
        mu += s.wi[3 * j + 2];
        mu2 += s.wi[3 * j + 2] * s.wi[3 * j + 2];
      }
      const double n = kWalks, allowed = 5 / std::sqrt(n) * std::sqrt(1.0 / 3);
      const bool uniform = law == IncidentLaw::uniform;
      EXPECT_NEAR(x / n, 0, allowed);
      EXPECT_NEAR(y / n, 0, allowed);
      EXPECT_NEAR(mu / n, uniform ? 1.0 / 2 : 2.0 / 3, allowed);
      EXPECT_NEAR(mu2 / n, uniform ? 1.0 / 3 : 1.0 / 2, allowed);
    }
}

}  // namespace
}  // namespace lamella
