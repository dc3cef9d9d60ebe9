#include "analytic/spongecake_network/spongecake_network.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "analytic/spongecake_network/spongecake_ranges.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

double between(const double (&range)[2], double u) { return range[0] + u * (range[1] - range[0]); }

NetworkLayer random_layer(RandomStream& stream) {
  NetworkLayer layer;
  layer.fiber = stream.uniform() < 0.5;
  layer.roughness = between(SpongecakeRanges::kRoughness, stream.uniform());
  layer.axis = direction_from_mu_phi(2 * stream.uniform() - 1, 2 * kPi * stream.uniform());
  layer.depth = between(SpongecakeRanges::kDepth, stream.uniform());
  for (int c = 0; c < 3; ++c) {
    layer.albedo[c] = between(SpongecakeRanges::kAlbedo, stream.uniform());
    layer.f0[c] = between(SpongecakeRanges::kF0, stream.uniform());
  }
  return layer;
}

std::vector<NetworkLayer> random_layers(int count, RandomStream& stream) {
  std::vector<NetworkLayer> layers;
  for (int k = 0; k < count; ++k) layers.push_back(random_layer(stream));
  return layers;
}

Rgb turned(Rgb c) { return {c.g, c.b, c.r}; }

void expect_near(const PredictedLobes& a, const PredictedLobes& b, int layers, double within) {
  const auto near = [&](double x, double y) { EXPECT_NEAR(x, y, within * std::abs(y) + 1e-9); };
  for (int c = 0; c < 3; ++c) {
    near(a.reflect[c], b.reflect[c]);
    near(a.transmit[c], b.transmit[c]);
  }
  for (int k = 0; k < layers; ++k) {
    near(a.layers[k].roughness, b.layers[k].roughness);
    near(a.layers[k].depth, b.layers[k].depth);
    for (int c = 0; c < 3; ++c) {
      near(a.layers[k].albedo[c], b.layers[k].albedo[c]);
      near(a.layers[k].f0[c], b.layers[k].f0[c]);
    }
  }
}

// Floats are added in another order.
constexpr double kRounding = 2e-4;

TEST(SpongecakeNetwork, PredictsLobesThatAreOnes) {
  RandomStream stream(1, 0, StreamPurpose::test);
  for (const int count : {1, 2})
    for (int n = 0; n < 500; ++n) {
      const PredictedLobes lobes = spongecake_network(count).predict(random_layers(count, stream));
      for (int k = 0; k < count; ++k) {
        const NetworkLayer& layer = lobes.layers[k];
        EXPECT_GT(layer.roughness, 0);
        EXPECT_LT(layer.roughness, 1);
        EXPECT_GT(layer.depth, 0);
        for (int c = 0; c < 3; ++c) {
          EXPECT_GT(layer.albedo[c], 0);
          EXPECT_GE(layer.f0[c], 0);
          EXPECT_LE(layer.f0[c], 1);
          EXPECT_GE(lobes.reflect[c], 0);
          EXPECT_GE(lobes.transmit[c], 0);
        }
      }
    }
}

TEST(SpongecakeNetwork, GivesGreyStacksGreyLobesAndExchangesChannels) {
  RandomStream stream(2, 0, StreamPurpose::test);
  for (const int count : {1, 2}) {
    const SpongecakeNetwork& network = spongecake_network(count);
    for (int n = 0; n < 50; ++n) {
      std::vector<NetworkLayer> layers = random_layers(count, stream);
      const PredictedLobes before = network.predict(layers);
      for (NetworkLayer& layer : layers) {
        layer.albedo = turned(layer.albedo);
        layer.f0 = turned(layer.f0);
      }
      PredictedLobes expected = before;
      expected.reflect = turned(before.reflect);
      expected.transmit = turned(before.transmit);
      for (NetworkLayer& layer : expected.layers) {
        layer.albedo = turned(layer.albedo);
        layer.f0 = turned(layer.f0);
      }
      expect_near(network.predict(layers), expected, count, kRounding);
      for (NetworkLayer& layer : layers) {
        layer.albedo = Rgb(layer.albedo.r);
        layer.f0 = Rgb(layer.f0.r);
      }
      const PredictedLobes grey = network.predict(layers);
      EXPECT_TRUE(grey.reflect.is_grey() && grey.transmit.is_grey());
      for (int k = 0; k < count; ++k)
        EXPECT_TRUE(grey.layers[k].albedo.is_grey() && grey.layers[k].f0.is_grey());
    }
  }
}

TEST(SpongecakeNetwork, KnowsNoTurnsAboutTheNormalAndNoSignsOfAxes) {
  RandomStream stream(3, 0, StreamPurpose::test);
  for (const int count : {1, 2})
    for (int n = 0; n < 50; ++n) {
      const std::vector<NetworkLayer> layers = random_layers(count, stream);
      std::vector<NetworkLayer> other = layers;
      const double turn = 2 * kPi * stream.uniform();
      for (NetworkLayer& layer : other) {
        layer.axis = direction_from_mu_phi(layer.axis.z, azimuth(layer.axis) + turn);
        if (stream.uniform() < 0.5) layer.axis = -layer.axis;
      }
      const SpongecakeNetwork& network = spongecake_network(count);
      expect_near(network.predict(other), network.predict(layers), count, kRounding);
    }
}

// The file beside the weights has what PyTorch predicts for some stacks.
TEST(SpongecakeNetwork, EqualsThatOfTheTrainingScript) {
  for (const int count : {1, 2}) {
    std::ifstream in(std::string(LAMELLA_NETWORK_FOLDER) + "/spongecake_" + std::to_string(count) +
                     ".json");
    const auto made = nlohmann::json::parse(in);
    ASSERT_GE(made.at("examples").size(), 3u);
    const auto color = [](const nlohmann::json& list) {
      return Rgb(list.at(0), list.at(1), list.at(2));
    };
    for (const auto& example : made.at("examples")) {
      std::vector<NetworkLayer> layers;
      for (const auto& p : example.at("parameters")) {
        NetworkLayer layer;
        layer.roughness = p.at(0);
        layer.albedo = Rgb(p.at(1), p.at(2), p.at(3));
        layer.depth = p.at(4);
        layer.f0 = Rgb(p.at(5), p.at(6), p.at(7));
        layer.fiber = p.at(8) == 1.0;
        layer.axis = {p.at(9), p.at(10), p.at(11)};
        layers.push_back(layer);
      }
      PredictedLobes expected;
      for (int k = 0; k < count; ++k) {
        expected.layers[k].roughness = example.at("roughness").at(k);
        expected.layers[k].depth = example.at("depth").at(k);
        expected.layers[k].albedo = color(example.at("albedo").at(k));
        expected.layers[k].f0 = color(example.at("f0").at(k));
      }
      for (int c = 0; c < 3; ++c) {
        expected.reflect[c] = example.at("constant").at(c).at(0);
        expected.transmit[c] = example.at("constant").at(c).at(1);
      }
      expect_near(spongecake_network(count).predict(layers), expected, count, 2e-3);
    }
  }
}

TEST(SpongecakeNetwork, RefusesFilesThatAreNone) {
  for (const int count : {1, 2}) {
    const std::string whole(spongecake_weights(count));
    EXPECT_LT(whole.size(), 500000u);
    EXPECT_EQ(SpongecakeNetwork(whole).layers(), count);
    for (const std::size_t size : {std::size_t{0}, std::size_t{3}, std::size_t{4}, std::size_t{15},
                                   std::size_t{16}, std::size_t{100}, whole.size() - 1})
      EXPECT_THROW(SpongecakeNetwork(whole.substr(0, size)), std::invalid_argument) << size;
    EXPECT_THROW(SpongecakeNetwork(whole + "x"), std::invalid_argument);
    RandomStream stream(4, 0, StreamPurpose::test);
    for (int n = 0; n < 100; ++n) {
      std::string damaged = whole;
      const auto at = n < 40 ? static_cast<std::size_t>(n)
                             : static_cast<std::size_t>(stream.uniform() * whole.size());
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << (n % 8)));
      EXPECT_THROW((void)SpongecakeNetwork(damaged), std::invalid_argument) << at;
    }
  }
  EXPECT_THROW((void)spongecake_network(1).predict(std::vector<NetworkLayer>(2)),
               std::invalid_argument);
  EXPECT_THROW((void)spongecake_network(2).predict(std::vector<NetworkLayer>(1)),
               std::invalid_argument);
  EXPECT_THROW((void)spongecake_network(0), std::invalid_argument);
  EXPECT_THROW((void)spongecake_network(3), std::invalid_argument);
}

}  // namespace
}  // namespace lamella
