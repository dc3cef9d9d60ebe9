#include "compare/preview/reflected_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace lamella {
namespace {

// A mirror lobe whose energy is known: f mu_i dw_i = D(h) h.z dh, with GGX's distribution of half
// vectors D, so that what it sends is the share of half vectors that leads above the horizon.
double ggx(double roughness, Direction h) {
  const double a2 = roughness * roughness, q = h.z * h.z * (a2 - 1) + 1;
  return a2 / (kPi * q * q);
}

Reflection mirror_lobe(double roughness) {
  return [roughness](Direction wi, Direction wo) {
    const Direction h = normalized(wi + wo);
    return Rgb(ggx(roughness, h) * h.z / (4 * wi.z * dot(wo, h)));
  };
}

// The same energy by quadrature over the half vectors themselves, in which nothing is narrow:
// the distribution's own variable u in tan^2 = r^2 u / (1 - u), and the azimuth.
double lobe_energy(double roughness, double mu_o) {
  constexpr int kRadial = 2000, kAround = 400;
  const Direction wo = direction_from_mu_phi(mu_o, 0);
  double sum = 0;
  for (int k = 0; k < kRadial; ++k) {
    const double u = (k + 0.5) / kRadial, tangent = roughness * std::sqrt(u / (1 - u));
    const double z = 1 / std::sqrt(1 + tangent * tangent);
    for (int j = 0; j < kAround; ++j) {
      const Direction h = direction_from_mu_phi(z, kPi * (j + 0.5) / kAround);
      if (2 * dot(wo, h) * h.z - mu_o > 0) sum += 1;
    }
  }
  return sum / (kRadial * kAround);
}

Direction viewer_at(double mu_o) { return direction_from_mu_phi(mu_o, 0.7); }
constexpr Direction kNormal{0, 0, 1};

const double kRoughnesses[] = {0.02, 0.05, 0.1, 0.3, 1};
const double kCosines[] = {1, 0.95, 0.7, 0.4, 0.15};

TEST(ReflectedLight, OfUniformLightIsTheLobesEnergyAtEveryRoughness) {
  const Environment uniform;
  for (const double roughness : kRoughnesses) {
    const ReflectedLight reflected(mirror_lobe(roughness), uniform);
    for (const double mu : kCosines)
      EXPECT_NEAR(reflected(kNormal, viewer_at(mu)).r / lobe_energy(roughness, mu), 1, 1e-3)
          << "roughness " << roughness << ", mu_o " << mu;
  }
}

// A black texel below the horizon makes a tree of a picture that shines like uniform light.
TEST(ReflectedLight, OfAPictureIsTheSameSumByItsTree) {
  for (const auto& [width, height] : {std::pair{16, 8}, {512, 256}}) {
    std::vector<Rgb> texels(static_cast<std::size_t>(width) * height, Rgb(1));
    texels[static_cast<std::size_t>(height / 2) * width + width / 2] = Rgb(0);
    const Environment picture(width, height, texels);
    ASSERT_FALSE(picture.is_uniform());
    ASSERT_EQ(picture.uniform().r, 0);
    for (const double roughness : kRoughnesses) {
      const ReflectedLight reflected(mirror_lobe(roughness), picture);
      for (const double mu : kCosines)
        EXPECT_NEAR(reflected(kNormal, viewer_at(mu)).r / lobe_energy(roughness, mu), 1, 4e-3)
            << "roughness " << roughness << ", mu_o " << mu << ", " << width << " columns";
    }
  }
}

TEST(ReflectedLight, OfASmallSunIsFTimesCosineTimesIrradiance) {
  constexpr int kWidth = 2048, kHeight = 1024;
  const Direction n = normalized(Direction{0.3, 0.5, 0.6});
  for (const auto& [column, row] : {std::pair{1500, 300}, {1800, 480}, {1290, 200}}) {
    std::vector<Rgb> texels(static_cast<std::size_t>(kWidth) * kHeight, Rgb(0));
    texels[static_cast<std::size_t>(row) * kWidth + column] = Rgb(3000, 2000, 1000);
    const Environment picture(kWidth, kHeight, texels);
    const double top = kPi * row / kHeight, bottom = kPi * (row + 1) / kHeight;
    const double solid_angle = 2 * kPi / kWidth * (std::cos(top) - std::cos(bottom));
    const Direction sun =
        lat_long_direction(kPi * (2 * (column + 0.5) / kWidth - 1), (top + bottom) / 2);
    const double cosine = dot(sun, n);
    ASSERT_GT(cosine, 0);
    for (const double roughness : kRoughnesses) {
      const Reflection f = mirror_lobe(roughness);
      const ReflectedLight reflected(f, picture);
      for (const double tilt : {0.0, 0.02, 0.3}) {
        // Viewers about the sun's mirror image.
        const Direction mirror = 2 * cosine * n - sun;
        const Direction viewer = normalized(mirror + tilt * n);
        const Frame<double> frame = frame_around(n);
        const double expected = f(frame.to_local(sun), frame.to_local(viewer)).r * cosine;
        const Rgb seen = reflected(n, viewer);
        // The texel is 0.18 degrees wide: beside a lobe of roughness 0.02 a hundredth.
        EXPECT_NEAR(seen.r / (3000 * solid_angle * expected), 1, 5e-3)
            << "roughness " << roughness << ", tilt " << tilt;
        EXPECT_NEAR(seen.b / seen.r, 1.0 / 3, 1e-6);
      }
    }
  }
}

TEST(ReflectedLight, OfAWideLightAddsUpOverASphereAsItsLobesDo) {
  // White Lambert under any picture: irradiance / pi, here of a sky of radiance 1 above y = 0 on a
  // surface that is tilted from up by theta: (1 + cos theta) / 2.
  constexpr int kWidth = 64, kHeight = 32;
  std::vector<Rgb> texels(kWidth * kHeight, Rgb(0));
  for (int k = 0; k < kWidth * kHeight / 2; ++k) texels[k] = Rgb(1);
  const Environment sky(kWidth, kHeight, texels);
  const ReflectedLight reflected([](Direction, Direction) { return Rgb(1 / kPi); }, sky);
  for (const double theta : {0.0, 0.5, 1.2, 2.0, 3.0}) {
    const Direction n{std::sin(theta) * 0.6, std::cos(theta), std::sin(theta) * 0.8};
    EXPECT_NEAR(reflected(n, n).r, (1 + std::cos(theta)) / 2, 3e-3) << theta;
  }
}

}  // namespace
}  // namespace lamella
