#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "compare/preview/reflected_light.h"
#include "compare/truth/lobe_table.h"
#include "phase/stack/stack_file.h"

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

}  // namespace
}  // namespace lamella
