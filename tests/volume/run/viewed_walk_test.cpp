#include "volume/run/viewed_walk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tests/volume/run/stacks.h"

namespace lamella::testing {
namespace {

// What stands between light and viewer: media of both kinds, both sides, interfaces.
std::vector<std::string> viewed_stacks() {
  return {
      layer("medium = 'sggx'\nroughness = 0.3\naxis = [0.4, 0.2, 1]\nalbedo = [0.9, 0.6, "
            "0.3]\nthickness = 1.5"),
      layer("medium = 'vmf_flake'\nroughness = 0.5\nthickness = 1.2\nalbedo = 0.8"),
      layer("medium = 'henyey_greenstein'\ng = 0.5\nthickness = 1") +
          "[substrate]\nbsdf = 'lambert'\nalbedo = 0.7\n",
      "[[layer]]\ninterface = 'smooth'\nior = 1.5\n" +
          layer("medium = 'lambert_sphere'\nthickness = 1\nalbedo = 0.9") +
          "[substrate]\nbsdf = 'lambert'\nalbedo = 0.5\n",
      "[[layer]]\ninterface = 'ggx'\nroughness = 0.4\nior = 1.4\n" +
          layer("medium = 'henyey_greenstein'\nthickness = 2\nalbedo = 0.7") +
          "[substrate]\nbsdf = 'conductor'\nroughness = 0.5\ndistribution = 'ggx'\neta = 0.2\nk = "
          "3\n",
  };
}

struct Mean {
  double sum = 0, square = 0, count = 0;
  void add(double x) {
    sum += x;
    square += x * x;
    ++count;
  }
  [[nodiscard]] double value() const { return sum / count; }
  [[nodiscard]] double variance() const {
    return (square / count - value() * value()) / (count - 1);
  }
};

// f(w_i, w_o) by walks of light from w_i, the way that the viewer's walks do not go.
Estimate f_of_light(const Stack& stack, Direction wi, Direction wo, std::uint64_t walks) {
  Simulation simulation(stack, general_plan(stack), wi, {wo}, 7);
  simulation.advance(walks);
  const auto slots = static_cast<std::size_t>(simulation.plan().order_slots());
  return batch_estimate(simulation.batches(), [&](const BatchTally& b) {
    double sum = 0;
    for (std::size_t slot = 0; slot < slots; ++slot) sum += b.f[3 * slot];
    return sum;
  });
}

}  // namespace

TEST(ViewedWalk, SeesTheBsdfThatWalksOfLightHave) {
  const std::uint64_t walks = soaked(20000);
  const double allowed = normal_quantile(test_level());
  for (const std::string& toml : viewed_stacks()) {
    const Stack stack = stack_from(toml);
    const ViewedStack viewed(stack);
    const Direction wi = direction_from_degrees(40, 20);
    std::vector<Direction> viewers{direction_from_degrees(30, 150), direction_from_degrees(70, 20)};
    if (viewed.transmits()) viewers.push_back(direction_from_degrees(130, 60));
    for (const Direction wo : viewers) {
      const LightAim aim{wi};
      Mean f;
      for (std::uint64_t n = 0; n < walks; ++n) f.add(viewed.follow(wo, &aim, 3, n).f.r);
      const Estimate light = f_of_light(stack, wi, wo, walks);
      const double error = std::sqrt(f.variance() + light.standard_error * light.standard_error);
      EXPECT_NEAR(f.value(), light.value, allowed * error) << toml << wo.z;
      EXPECT_GT(f.value(), 0) << toml << wo.z;
      EXPECT_LT(error, 0.2 * f.value()) << toml << wo.z;
    }
  }
}

// Flakes that lean, by walks of light: f from above and below, reflected and transmitted, with and
// without a rough face, is that of simulations with other random numbers.
TEST(LitWalk, HasTheBsdfOfWhatIsNotReciprocal) {
  const std::uint64_t walks = soaked(20000);
  const double allowed = normal_quantile(test_level());
  const std::string leaning = layer(
      "medium = 'vmf_flake'\nroughness = 0.4\naxis = [0.5, 0.3, 1]\nalbedo = [0.9, 0.6, 0.3]\n"
      "thickness = 1.2");
  const std::string face = "[[layer]]\ninterface = 'ggx'\nroughness = 0.4\nior = 1.4\n";
  for (const std::string& toml :
       {leaning, face + leaning + "[substrate]\nbsdf = 'lambert'\nalbedo = 0.7\n"}) {
    const Stack stack = stack_from(toml);
    EXPECT_THROW(ViewedStack{stack}, std::invalid_argument);
    EXPECT_TRUE(has_leaning_flakes(stack));
    const LitStack lit(stack);
    std::vector<Direction> sides{direction_from_degrees(40, 20)};
    if (lit.transmits()) sides.push_back(direction_from_degrees(130, 60));
    for (const Direction wi : sides)
      for (Direction wo : sides) {
        std::swap(wo.x, wo.y);
        Mean f;
        for (std::uint64_t n = 0; n < walks; ++n) f.add(lit.f(wi, wo, 3, n).r);
        const Estimate light = f_of_light(stack, wi, wo, walks);
        const double error = std::sqrt(f.variance() + light.standard_error * light.standard_error);
        EXPECT_NEAR(f.value(), light.value, allowed * error) << toml << wi.z << ' ' << wo.z;
        EXPECT_LT(error, 0.1 * f.value()) << toml << wi.z << ' ' << wo.z;
      }
  }
  EXPECT_GT(LitStack(stack_from(leaning)).uncollided({0, 0, 1}), 0);
  EXPECT_THROW(LitStack{stack_from("[[layer]]\ninterface = 'smooth'\nior = 1.4\n" + leaning)},
               std::invalid_argument);
}

// What leaves has the density that is aimed: the energy in two ways, deltas apart.
TEST(ViewedWalk, DeparturesCarryTheSameEnergyAsWhatIsAimed) {
  const std::uint64_t walks = soaked(20000);
  const double allowed = normal_quantile(test_level());
  for (const std::string& toml : viewed_stacks()) {
    const ViewedStack viewed(stack_from(toml));
    const Direction wo = direction_from_degrees(35, 10);
    Mean left, aimed;
    for (std::uint64_t n = 0; n < walks; ++n) {
      RandomStream stream(5, n, StreamPurpose::test);
      // Uniform over the sphere, or the upper hemisphere.
      const double z = viewed.transmits() ? 2 * stream.uniform() - 1 : stream.uniform();
      const double r = std::sqrt(1 - z * z), phi = 2 * kPi * stream.uniform();
      const Direction wi{r * std::cos(phi), r * std::sin(phi), z};
      const LightAim aim{wi};
      const ViewedLight light = viewed.follow(wo, &aim, 9, n);
      aimed.add(light.f.g * std::abs(z) * (viewed.transmits() ? 4 : 2) * kPi);
      left.add(light.departure && light.departure->density ? light.departure->weight.g : 0);
    }
    const double error = std::sqrt(left.variance() + aimed.variance());
    EXPECT_NEAR(left.value(), aimed.value(), allowed * error) << toml;
    EXPECT_LT(error, 0.1 * left.value()) << toml;
  }
}

// Coats from wide to as narrow as a mirror, plates of two such faces, narrow flakes and metals.
std::vector<std::string> peaked_stacks() {
  std::vector<std::string> stacks;
  const auto ggx = [](double alpha) {
    return fmt::format("[[layer]]\ninterface = 'ggx'\nior = 1.5\nroughness = {}\n", alpha);
  };
  const std::string haze = layer("medium = 'henyey_greenstein'\ng = 0.9\nthickness = 1");
  for (const double alpha : {0.0025, 0.05})
    stacks.push_back(ggx(alpha) + haze + "[substrate]\nbsdf = 'lambert'\nalbedo = 1\n");
  stacks.push_back(ggx(0.01) + haze + "[[layer]]\ninterface = 'ggx'\nior = 1\nroughness = 0.003\n");
  stacks.push_back(layer("medium = 'sggx'\nroughness = 0.01\nthickness = 1"));
  stacks.push_back("[[layer]]\ninterface = 'smooth'\nior = 1.5\n" + haze +
                   "[substrate]\nbsdf = 'conductor'\nroughness = 0.01\ndistribution = 'ggx'\neta = "
                   "0.2\nk = 3\n");
  return stacks;
}

// However narrow the peaks are: light that is aimed and light that walks find are all of it, and
// neither has a sample that stands out.
TEST(ViewedWalk, AimedAndFoundLightTogetherAreAllOfItWithoutLargeSamples) {
  const std::uint64_t walks = soaked(20000);
  const double allowed = normal_quantile(test_level());
  for (const std::string& toml : peaked_stacks()) {
    const ViewedStack viewed(stack_from(toml));
    const double density = 1 / ((viewed.transmits() ? 4 : 2) * kPi);
    for (const double theta : {35.0, 80.0}) {
      const Direction wo = direction_from_degrees(theta, 10);
      Mean left, both;
      double largest = 0;
      for (std::uint64_t n = 0; n < walks; ++n) {
        RandomStream stream(5, n, StreamPurpose::test);
        const double z = viewed.transmits() ? 2 * stream.uniform() - 1 : stream.uniform();
        const double r = std::sqrt(1 - z * z), phi = 2 * kPi * stream.uniform();
        const LightAim aim{{r * std::cos(phi), r * std::sin(phi), z}, density};
        const ViewedLight light = viewed.follow(wo, &aim, 9, n);
        double sum = light.f.g * std::abs(z) / density;
        largest = std::max(largest, sum);
        if (light.departure) {
          const std::optional<double>& d = light.departure->density;
          sum += (d ? *d / (*d + density) : 1) * light.departure->weight.g;
          left.add(light.departure->weight.g);
        } else {
          left.add(0);
        }
        both.add(sum);
      }
      // Both have the same departures: the difference has less than the sum of their noise.
      const double error = std::sqrt(left.variance() + both.variance());
      EXPECT_NEAR(both.value(), left.value(), allowed * error) << toml << theta;
      EXPECT_LT(error, 0.01) << toml << theta;
      // Each event's aimed share is at most what it scatters, times a square of the index, and
      // few events of a walk aim at a peak: the largest was 1.4.
      EXPECT_LT(largest, 4) << toml << theta;
    }
  }
}

// A lamp of 10 degrees about the mirror image in a narrow coat: with all of it aimed, which seldom
// meets the peak, and with the part that its density leaves to aiming.
TEST(ViewedWalk, SeesALampByBothWaysAsByAimingAlone) {
  const std::uint64_t walks = soaked(100000);
  const double height = 1 - std::cos(5 * kPi / 180), density = 1 / (2 * kPi * height);
  const Direction wo = direction_from_degrees(30, 0), lamp = direction_from_degrees(30, 180);
  const Frame<double> frame = frame_around(lamp);
  const ViewedStack viewed(stack_from(peaked_stacks()[0]));
  Mean alone, both;
  for (std::uint64_t n = 0; n < walks; ++n) {
    RandomStream stream(5, n, StreamPurpose::test);
    const double z = 1 - height * stream.uniform(), phi = 2 * kPi * stream.uniform();
    const double r = std::sqrt(1 - z * z);
    const Direction wi = frame.to_world({r * std::cos(phi), r * std::sin(phi), z});
    const LightAim all{wi}, part{wi, density};
    alone.add(viewed.follow(wo, &all, 9, n).f.g * wi.z / density);
    const ViewedLight light = viewed.follow(wo, &part, 10, n);
    double sum = light.f.g * wi.z / density;
    if (light.departure && 1 - dot(light.departure->wi, lamp) < height) {
      const double d = light.departure->density.value();
      sum += d / (d + density) * light.departure->weight.g;
    }
    both.add(sum);
  }
  const double error = std::sqrt(alone.variance() + both.variance());
  EXPECT_NEAR(both.value(), alone.value(), normal_quantile(test_level()) * error);
  EXPECT_LT(error, 0.1 * alone.value());
  EXPECT_LT(both.variance(), 0.2 * alone.variance());
}

TEST(ViewedWalk, PassesStraightAsOftenAsLightIsUncollided) {
  const std::uint64_t walks = soaked(20000);
  for (const std::string& toml : viewed_stacks()) {
    const ViewedStack viewed(stack_from(toml));
    const Direction wo = direction_from_degrees(35, 10);
    Mean passed;
    for (std::uint64_t n = 0; n < walks; ++n) {
      const ViewedLight light = viewed.follow(wo, nullptr, 11, n);
      passed.add(light.departure && light.departure->straight ? light.departure->weight.g : 0);
    }
    // Light that comes from where the viewer looks to.
    const double share = viewed.uncollided(-wo);
    EXPECT_EQ(share > 0, viewed.transmits());
    EXPECT_NEAR(passed.value(), share,
                normal_quantile(test_level()) * std::sqrt(passed.variance()) + 1e-15)
        << toml;
  }
}

TEST(ViewedWalk, RefusesWhatItCannotSee) {
  for (const char* toml :
       {"[[layer]]\nmedium = 'vmf_flake'\nroughness = 0.3\naxis = [0.5, 0.2, 1]\nthickness = 1\n",
        "[[layer]]\ninterface = 'smooth'\nior = 1.5\n"})
    EXPECT_THROW(ViewedStack{stack_from(toml)}, std::invalid_argument) << toml;
}

}  // namespace lamella::testing
