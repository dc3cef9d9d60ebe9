#include "compare/preview/environment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace lamella {
namespace {

Direction centroid(const Environment::Node& node) {
  return {node.centroid[0], node.centroid[1], node.centroid[2]};
}

TEST(Environment, OfOneRadianceIsUniform) {
  const Environment grey(8, 4, std::vector<Rgb>(32, Rgb(2, 3, 4)));
  EXPECT_TRUE(grey.is_uniform());
  EXPECT_EQ(grey.uniform(), Rgb(2, 3, 4));
  EXPECT_TRUE(Environment().is_uniform());
  EXPECT_EQ(Environment().uniform(), Rgb(1));
}

TEST(Environment, HasTheFluxAboveItsLeastRadianceInEveryNode) {
  constexpr int kWidth = 12, kHeight = 6;
  std::vector<Rgb> texels(kWidth * kHeight, Rgb(1));
  texels[2 * kWidth + 5] = Rgb(11, 5, 1);
  const Environment picture(kWidth, kHeight, texels);
  ASSERT_FALSE(picture.is_uniform());
  EXPECT_EQ(picture.uniform(), Rgb(1));
  const double top = kPi * 2 / kHeight, bottom = kPi * 3 / kHeight;
  const double solid_angle = 2 * kPi / kWidth * (std::cos(top) - std::cos(bottom));
  const auto& root = picture.nodes().front();
  EXPECT_NEAR(root.flux[0], 10 * solid_angle, 1e-6);
  EXPECT_NEAR(root.flux[1], 4 * solid_angle, 1e-6);
  EXPECT_EQ(root.flux[2], 0);
  // One way down leads to the light; the other children have none.
  const Environment::Node* node = &root;
  while (node->children >= 0) {
    const auto& first = picture.nodes()[static_cast<std::size_t>(node->children)];
    const auto& second = picture.nodes()[static_cast<std::size_t>(node->children) + 1];
    EXPECT_NEAR(first.flux[0] + second.flux[0], node->flux[0], 1e-6);
    node = first.flux[0] > 0 ? &first : &second;
  }
  EXPECT_EQ(node->column, 5);
  EXPECT_EQ(node->row, 2);
}

// Light of one texel of a picture that is kept in blocks of several stays where it is.
TEST(Environment, OfManyTexelsKeepsTheCentroidOfItsLight) {
  constexpr int kWidth = 4096, kHeight = 2048;
  std::vector<Rgb> texels(static_cast<std::size_t>(kWidth) * kHeight, Rgb(0));
  const int column = 1001, row = 702;
  texels[static_cast<std::size_t>(row) * kWidth + column] = Rgb(1e4);
  const Environment picture(kWidth, kHeight, texels);
  const Direction sun =
      lat_long_direction(kPi * (2 * (column + 0.5) / kWidth - 1), kPi * (row + 0.5) / kHeight);
  const Direction found = centroid(picture.nodes().front());
  EXPECT_NEAR(found.x, sun.x, 1e-6);
  EXPECT_NEAR(found.y, sun.y, 1e-6);
  EXPECT_NEAR(found.z, sun.z, 1e-6);
}

TEST(Environment, HasUpAboveAndTheMiddleColumnAwayFromTheViewer) {
  constexpr int kWidth = 9, kHeight = 5;
  const auto light_at = [&](int column, int row) {
    std::vector<Rgb> texels(kWidth * kHeight, Rgb(0));
    texels[row * kWidth + column] = Rgb(1);
    return normalized(centroid(Environment(kWidth, kHeight, texels).nodes().front()));
  };
  EXPECT_NEAR(light_at(4, 2).z, -1, 1e-6);
  EXPECT_NEAR(light_at(6, 2).x, std::sin(2 * kPi * 2 / 9), 1e-6);
  EXPECT_GT(light_at(4, 0).y, 0.9);
  EXPECT_LT(light_at(4, 4).y, -0.9);
}

}  // namespace
}  // namespace lamella
