// Walks on lanes in one layer at a time are those of lanes each in its own layer: what the two
// differ by is rounding.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/volume/run/stacks.h"
#include "volume/lanes/lane_setting.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

using testing::lane_isas;
using testing::layer;
using testing::stack_from;

struct TurnsCase {
  const char* what;
  std::string toml;
  double theta;
};

const std::vector<TurnsCase>& turns_cases() {
  const std::string spheres = "medium = 'lambert_sphere'\n",
                    hg = "medium = 'henyey_greenstein'\n"
                         "g = 0.7\n",
                    upright = "medium = 'sggx'\nroughness = 0.5\n",
                    tilted = "medium = 'sggx'\nroughness = 0.3\naxis = [0.6, 0, 0.8]\n",
                    diffuse = "medium = 'sggx'\nflake = 'lambert'\nroughness = 0.4\n",
                    vmf = "medium = 'vmf_flake'\nroughness = 0.5\n",
                    vmf_mirror =
                        "medium = 'vmf_flake'\nflake = 'mirror'\nroughness = 0.3\n"
                        "axis = [0.3, 0, 1]\n",
                    rayleigh = "medium = 'rayleigh'\n";
  const auto thick = [](const std::string& medium, const char* depth) {
    return layer(medium + "albedo = 0.9\nthickness = " + depth);
  };
  std::string thin;
  for (int k = 0; k < 16; ++k) thin += thick(k % 2 ? hg : spheres, "0.06");
  static const std::vector<TurnsCase> list{
      {"two media", thick(spheres, "1") + thick(hg, "1"), 60},
      {"the same from below", thick(spheres, "1") + thick(hg, "1"), 120},
      {"every medium",
       thick(spheres, "0.4") + thick(hg, "0.3") + thick(tilted, "0.4") + thick(diffuse, "0.2") +
           thick(vmf, "0.3") + thick(vmf_mirror, "0.4") + thick(rayleigh, "0.5"),
       40},
      {"upright flakes over a half space", thick(upright, "1") + thick(diffuse, "inf"), 75},
      {"flakes over a substrate",
       thick(vmf, "0.7") + thick(upright, "0.5") + "[substrate]\nalbedo = 0.8\n", 20},
      {"colours over a coloured substrate",
       layer(tilted + "albedo = [0.9, 0.5, 0.2]\nf0 = [0.9, 0.5, 0.3]\nthickness = 0.4") +
           layer(spheres + "albedo = [0.5, 0.9, 0.8]\nthickness = 1") +
           "[substrate]\nalbedo = [0.3, 0.6, 0.9]\n",
       40},
      {"one colour",
       layer(spheres + "albedo = [0.9, 0.6, 0]\nthickness = 1") +
           layer(hg + "albedo = [0.9, 0.6, 0]\nthickness = 1"),
       125},
      {"sixteen thin layers", thin, 30},
      {"collisions that are forced", thick(spheres, "0.01") + thick(hg, "0.02"), 10},
      {"white and deep",
       layer(spheres + "albedo = 1\nthickness = 3") + layer(hg + "albedo = 1\nthickness = 30"), 0},
  };
  return list;
}

enum class Way { counted, cells, points };

Simulation walks_of(const TurnsCase& c, Isa isa, Way way, LayerTurns turns, Thinning thinning,
                    Sampling sampling) {
  const Stack stack = stack_from(c.toml);
  Plan plan = make_plan(stack, {.thinning = thinning, .sampling = sampling});
  plan.isa = isa;
  plan.layer_turns = turns;
  const Direction wi = direction_from_degrees(c.theta, 25);
  if (way != Way::points)
    return {stack,
            plan,
            wi,
            way == Way::counted ? Estimator::analog : Estimator::next_event,
            CellGrid{3, 4, false},
            5};
  std::vector<Direction> points;
  for (const double mu : {0.9, 0.2, -0.6})
    if (mu > 0 || stack.is_open_below()) points.push_back(direction_from_mu_phi(mu, 1.1));
  return {stack, plan, wi, points, 5};
}

class LayerTurnsOnLanes : public ::testing::TestWithParam<Isa> {};

TEST_P(LayerTurnsOnLanes, AreTheSameWalks) {
  for (const TurnsCase& c : turns_cases())
    for (const Way way : {Way::counted, Way::cells, Way::points})
      for (const Thinning thinning : {Thinning{0}, Thinning{2}})
        for (const std::uint64_t walks : {std::uint64_t{500}, std::uint64_t{20000}}) {
          if (way != Way::counted && walks > 500) continue;
          const Sampling sampling = thinning.is_on() ? Sampling::rqmc : Sampling::random;
          Simulation own = walks_of(c, GetParam(), way, LayerTurns::never, thinning, sampling);
          Simulation turns = walks_of(c, GetParam(), way, LayerTurns::always, thinning, sampling);
          ASSERT_EQ(turns.isa(), GetParam()) << c.what;
          own.advance(walks);
          turns.advance(walks);
          double sum = 0, difference = 0;
          for (int k = 0; k < kBatches; ++k) {
            const BatchTally &a = own.batches()[k], &b = turns.batches()[k];
            ASSERT_EQ(a.walks, b.walks) << c.what;
            ASSERT_EQ(a.f.size(), b.f.size()) << c.what;
            for (std::size_t j = 0; j < a.f.size(); ++j) {
              sum += std::abs(a.f[j]);
              difference += std::abs(a.f[j] - b.f[j]);
            }
          }
          const double events = static_cast<double>(own.collisions());
          ASSERT_GT(sum, 0) << c.what;
          // Places and directions are rounded to 1e-6 at the coarsest: an event takes another turn
          // in one of 1e5, and a walk that took one is another walk from there on.
          const double others = 3 + 1e-5 * events;
          EXPECT_LT(std::abs(static_cast<double>(turns.collisions()) - events),
                    others * (events / static_cast<double>(walks) + 10))
              << c.what;
          EXPECT_LT(difference / sum, 2 * others / static_cast<double>(walks) + 1e-5)
              << c.what << " way " << static_cast<int>(way) << " walks " << walks;
        }
}

INSTANTIATE_TEST_SUITE_P(Isas, LayerTurnsOnLanes, ::testing::ValuesIn(lane_isas()),
                         [](const auto& test) { return to_text(test.param); });

TEST(LayerTurns, ArePlannedWhereTheyAreFaster) {
  const auto planned = [](const std::string& toml) {
    const Stack stack = stack_from(toml);
    return LaneSetting<float>(stack, make_plan(stack), direction_from_degrees(30, 0), 1)
        .walk.by_layer;
  };
  const std::string spheres = "medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = ",
                    hg = "medium = 'henyey_greenstein'\ng = 0.5\nalbedo = 0.9\nthickness = ",
                    vmf = "medium = 'vmf_flake'\nroughness = 0.5\nalbedo = 0.9\nthickness = ";
  EXPECT_TRUE(planned(layer(spheres + "1") + layer(hg + "1")));
  EXPECT_FALSE(planned(layer(spheres + "0.1") + layer(hg + "0.1")));
  EXPECT_TRUE(planned(layer(spheres + "0.1") + layer(vmf + "0.1")));
  EXPECT_TRUE(planned(layer(spheres + "0.1") + layer(spheres + "inf")));
  EXPECT_FALSE(planned(layer(spheres + "0.7") + layer(spheres + "0.7")));
  EXPECT_TRUE(planned(layer(hg + "1000")));  // which lanes cut into three
  EXPECT_FALSE(planned(layer(spheres + "inf")));
}

}  // namespace
}  // namespace lamella
