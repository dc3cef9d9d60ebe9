#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "compare/preview/reflected_light.h"
#include "compare/truth/lobe_table.h"
#include "phase/stack/stack_file.h"
#include "volume/harmonics/harmonic_pairs.h"
#include "volume/harmonics/harmonic_solution.h"

namespace lamella {
namespace {

// Under light from everywhere a white half space is seen as 1 from every side, whichever pixel
// looks at it: between the nodes of the table and of the integrated angles as well as on them.
TEST(WhitePreview, ShowsOneAtEveryRoughnessFromEverySide) {
  const Environment uniform;
  for (const double roughness : {0.02, 0.05, 0.2, 0.5, 1.0}) {
    TruthRequest request{
        .stack = parse_stack(
            fmt::format("[[layer]]\nmedium = \"sggx\"\nroughness = {}\nthickness = inf\n",
                        roughness),
            "test", "test")};
    request.isa = isa_from_text("auto");
    // Walks for the narrow ones, of which the solver cannot have enough modes.
    request.effort.walks = 256;
    if (roughness < 0.5) request.given = {WalkSetting::walks};
    const LobeTable table = LobeTable::make(request, nullptr);
    const ReflectedLight seen([&](Direction wo) { return table.towards(wo); }, uniform);
    double least = 2, most = 0;
    for (int k = 0; k <= 1000; ++k) {
      const double mu = std::cos((kPi / 2 - 0.02) * k / 1000);
      least = std::min(least, seen.albedo(mu).g);
      most = std::max(most, seen.albedo(mu).g);
    }
    EXPECT_GT(least, 0.995) << roughness;
    EXPECT_LT(most, 1.005) << roughness;
  }
}

TEST(LobeTable, TowardsOneViewerIsTheTable) {
  TruthRequest request{
      .stack = parse_stack("[[layer]]\nmedium = \"sggx\"\nroughness = 0.3\nthickness = 1\n", "test",
                           "test")};
  const LobeTable table = LobeTable::make(request, nullptr);
  for (const double mu_o : {1.0, 0.93, 0.4, 0.02}) {
    const Direction wo = direction_from_mu_phi(mu_o, 0.3);
    const auto f = table.towards(wo);
    for (const double mu_i : {1.0, 0.7, 0.11})
      for (const double phi : {0.3, 1.0, 3.4}) {
        const Direction wi = direction_from_mu_phi(mu_i, phi);
        EXPECT_EQ(f(wi).g, table(wi, wo).g);
        EXPECT_TRUE(std::isfinite(f(wi).g) && f(wi).g >= 0);
      }
  }
}

// Fibers in the plane: values by the table against the solver's at pairs, at sectors and between
// them, and the energy that is seen under uniform light against the solver's.
TEST(LobeTable, HasTheAzimuthOfStacksWithoutSymmetry) {
  TruthRequest request{
      .stack = parse_stack("[[layer]]\nmedium = \"sggx\"\nshape = \"fiber\"\naxis = [1, 0.5, 0.2]\n"
                           "roughness = 0.8\nalbedo = 0.9\nthickness = 1\n",
                           "test", "test")};
  request.isa = isa_from_text("auto");
  const LobeTable table = LobeTable::make(request, nullptr);
  ASSERT_TRUE(table.has_azimuth());
  std::vector<std::pair<Direction, Direction>> pairs;
  for (const double mu_o : {0.95, 0.6, 0.3})
    for (const double phi_o : {0.0, 1.1, 2.9, 5.0})
      pairs.emplace_back(direction_from_mu_phi(0.7 - mu_o / 2, 2 * phi_o + 1),
                         direction_from_mu_phi(mu_o, phi_o));
  DeterministicAccuracy accuracy;
  const auto exact = harmonic_pairs(
      request.stack, pairs, {.tolerance = 1e-3, .max_seconds = 1e9, .isa = request.isa}, accuracy);
  for (std::size_t k = 0; k < pairs.size(); ++k)
    EXPECT_NEAR(table(pairs[k].first, pairs[k].second).g / exact[k].f.g, 1, 0.01) << k;
  const Environment uniform;
  const ReflectedLight seen([&](Direction wo) { return table.towards(wo); }, uniform, {},
                            LobeTable::kSectors);
  const HarmonicTransport transport(request.stack, 0, {.degree = 24});
  for (const auto& [mu, phi] : {std::pair{0.8, 0.3}, {0.4, 2.0}, {0.4, 4.5}}) {
    const HarmonicSolution solution(transport, direction_from_mu_phi(mu, phi));
    const auto& up = solution.energies().up;
    EXPECT_NEAR(seen.albedo(mu, phi).g / (up[0] + up[1] + up[2] + up[3]), 1, 3e-3) << mu;
  }
}

// Planes that mirror fibers: two of those that lie, one of those that rise, none of two layers
// that are turned against each other.
TEST(SectorSymmetry, FindsThePlanesThatMirrorAStack) {
  const auto symmetry = [](const std::string& axes) {
    return sector_symmetry(parse_stack(axes, "test", "test"));
  };
  const auto fibers = [](const std::string& axis) {
    return "[[layer]]\nmedium = \"sggx\"\nshape = \"fiber\"\nroughness = 0.5\nthickness = 1\n"
           "axis = " +
           axis + "\n";
  };
  EXPECT_TRUE(symmetry(fibers("[1, 1, 0]")).across);
  EXPECT_TRUE(symmetry(fibers("[1, 1, 1]")).along);
  EXPECT_FALSE(symmetry(fibers("[1, 1, 1]")).across);
  EXPECT_NEAR(std::remainder(symmetry(fibers("[1, 1, 1]")).azimuth - kPi / 4, kPi), 0, 1e-6);
  EXPECT_FALSE(symmetry(fibers("[1, 0, 0]") + fibers("[1, 1, 0]")).along);
  const SectorSymmetry two{0, true, true};
  for (int k = 0; k < 16; ++k) {
    const SectorSymmetry::Image image = two.image_of(k, 16);
    EXPECT_LE(image.sector, std::min(k, 4));
    // The image's cosine and sine differ by signs alone, by one of them where it is turned over.
    const double of = 2 * kPi * k / 16, at = 2 * kPi * image.sector / 16;
    EXPECT_NEAR(std::abs(std::cos(of)), std::abs(std::cos(at)), 1e-12);
    if (k % 4 != 0) {
      EXPECT_EQ((std::cos(of) < 0) != (std::sin(of) < 0), image.turned_over) << k;
    }
  }
}

}  // namespace
}  // namespace lamella
