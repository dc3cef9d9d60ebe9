#include "volume/run/viewed_walk.h"

#include <cmath>

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
      Mean f;
      for (std::uint64_t n = 0; n < walks; ++n) f.add(viewed.follow(wo, &wi, 3, n).f.r);
      const Estimate light = f_of_light(stack, wi, wo, walks);
      const double error = std::sqrt(f.variance() + light.standard_error * light.standard_error);
      EXPECT_NEAR(f.value(), light.value, allowed * error) << toml << wo.z;
      EXPECT_GT(f.value(), 0) << toml << wo.z;
      EXPECT_LT(error, 0.2 * f.value()) << toml << wo.z;
    }
  }
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
      const ViewedLight light = viewed.follow(wo, &wi, 9, n);
      aimed.add(light.f.g * std::abs(z) * (viewed.transmits() ? 4 : 2) * kPi);
      left.add(light.departure && !light.departure->unaimed ? light.departure->weight.g : 0);
    }
    const double error = std::sqrt(left.variance() + aimed.variance());
    EXPECT_NEAR(left.value(), aimed.value(), allowed * error) << toml;
    EXPECT_LT(error, 0.1 * left.value()) << toml;
  }
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
