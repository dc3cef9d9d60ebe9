// Beams between smooth boundaries over a smooth conductor, by the number of times that it mirrored
// them.
#include "volume/solver/stack_beams.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/adding/smooth_boundary.h"

namespace lamella {
namespace {

const std::string kFace = "[[layer]]\ninterface = \"smooth\"\nior = 1.5\n";
const std::string kMirror =
    "[substrate]\nbsdf = \"conductor\"\neta = 0.2\nk = 3\ndistribution = \"smooth\"\n";

// Once more mirrored is once more through the ground and back from the interface's inside.
TEST(StackBeams, CountTheConductorsReflections) {
  const Stack stack = stack_of(kFace + kMirror);
  const MirroringGround ground = ground_of(stack, 0);
  const Direction wi = direction_from_mu_phi(0.6, 1);
  const StackBeamOf<OrderShares> beam = beam_by_order(elements_of(stack), wi, ground);
  const SmoothShares face = smooth_shares(1, 0.6, 1.5, beam.mu[1]);
  const double mirrored = ground(beam.mu[1]), round = face.reflected * mirrored;
  const double first = face.transmitted * face.transmitted * mirrored;
  const OrderShares& up = beam.up.front();
  EXPECT_NEAR(up.of[0], face.reflected, 1e-15);
  for (int k = 1; k < OrderShares::kLast; ++k)
    EXPECT_NEAR(up.of[k], first * std::pow(round, k - 1), 1e-15) << k;
  EXPECT_NEAR(up.of[OrderShares::kLast], first * std::pow(round, 3) / (1 - round), 1e-15);
}

TEST(StackBeams, HaveOrdersThatSumToThem) {
  const Stack stack = stack_of(kFace + layer(kIsotropic, 0.9, 0.3) +
                               "[[layer]]\ninterface = \"smooth\"\nior = 1.2\n" +
                               layer(kSphere, 0.9, 0.2) + kMirror);
  const MirroringGround ground = ground_of(stack, 0);
  for (const double mu : {1.0, 0.4, 1e-3}) {
    const Direction wi = direction_from_mu_phi(mu, 0);
    const StackBeam all = beam_of(elements_of(stack), wi, false, ground);
    const StackBeamOf<OrderShares> orders = beam_by_order(elements_of(stack), wi, ground);
    for (std::size_t p = 0; p < all.mu.size(); ++p) {
      EXPECT_NEAR(orders.down[p].sum(), all.down[p], 1e-15) << mu << ' ' << p;
      EXPECT_NEAR(orders.up[p].sum(), all.up[p], 1e-15) << mu << ' ' << p;
    }
  }
}

}  // namespace
}  // namespace lamella
