// Batches on lanes of double, on every instruction set that the machine has, against single pairs
// in double.
#include <gtest/gtest.h>

#include <cmath>

#include "phase/random/random.h"
#include "tests/analytic/model/model_checks.h"

namespace lamella {
namespace {

using testing::make_model;

struct Case {
  const char* model;
  std::vector<std::pair<std::string, ParameterValue>> values;
};

// Every model with a formula on lanes; all three ranges of VMF Diffuse's projected area.
std::vector<Case> cases() {
  std::vector<Case> list;
  for (const Rgb albedo : {Rgb(1), Rgb(0.7), Rgb(0.9, 0.5, 0)}) {
    for (const double r : {0.0, 0.3, 1.0}) {
      for (const char* name : {"fon", "eon", "eon_approx"})
        list.push_back({name, {{"albedo", albedo}, {"roughness", r}}});
      for (const char* name :
           {"oren_nayar", "oren_nayar_footnote", "fujii_qualitative", "oren_nayar_full"})
        list.push_back({name, {{"albedo", albedo}, {"sigma", r}}});
    }
    for (const char* name : {"lambert", "chandrasekhar", "lambert_sphere", "lambert_sphere_fast",
                             "hapke_lambert_sphere"})
      list.push_back({name, {{"albedo", albedo}}});
    for (const char* name : {"vmf_diffuse", "vmf_diffuse_printed"})
      for (const double r : {0.0, 0.001, 0.04, 0.06, 0.3, 0.5, 1.0})
        list.push_back({name, {{"albedo", albedo}, {"roughness", r}}});
  }
  return list;
}

// Pairs of every kind: inside, at mu = 1, mu = 0 and next to them, in one azimuth, and below.
std::vector<DirectionPair> pairs_of_every_kind() {
  std::vector<Direction> special{{0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 0, -1}};
  for (const double mu : {1 - 1e-15, 1 - 1e-8, 0.5, 1e-3, 1e-8, 1e-100, -0.5})
    for (const double phi : {0.0, 2.0, kPi}) special.push_back(direction_from_mu_phi(mu, phi));
  std::vector<DirectionPair> pairs;
  for (const Direction wi : special)
    for (const Direction wo : special)
      if (wi.z != 0 || wo.z != 0) pairs.push_back({wi, wo});
  RandomStream stream(1, 0, StreamPurpose::test);
  const auto draw = [&] {
    const double mu = stream.uniform();
    return direction_from_mu_phi(mu, 2 * kPi * stream.uniform());
  };
  for (int k = 0; k < 2000; ++k) {
    const Direction wi = draw();
    pairs.push_back({wi, draw()});
  }
  return pairs;
}

class Batch : public ::testing::TestWithParam<Isa> {};

TEST_P(Batch, LanesDifferFromDoubleByNoMoreThanStated) {
  const std::vector<DirectionPair> pairs = pairs_of_every_kind();
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.model);
    const auto model = make_model(c.model, c.values);
    const int lobes = static_cast<int>(find_model(c.model)->lobes.size());
    std::vector<Rgb> values(pairs.size());
    model->eval(pairs, values, GetParam());
    double worst = 0;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto [wi, wo] = pairs[k];
      const Rgb single = model->eval(wi, wo);
      Rgb size;
      for (int lobe = 0; lobe < lobes; ++lobe) {
        const Rgb part = model->eval_lobe(lobe, wi, wo);
        for (int channel = 0; channel < 3; ++channel) size[channel] += std::abs(part[channel]);
      }
      for (int channel = 0; channel < 3; ++channel) {
        const double difference = std::abs(values[k][channel] - single[channel]);
        EXPECT_LE(difference, testing::lane_error(size[channel], wi, wo))
            << wi.z << ' ' << wo.z << ' ' << single[channel];
        worst = std::max(worst, difference / testing::lane_error(size[channel], wi, wo));
      }
    }
    RecordProperty(c.model, std::to_string(worst));
  }
}

TEST_P(Batch, AnyLengthIsWrittenAndNothingBeyondIt) {
  const auto model = make_model("eon", {{"albedo", Rgb(0.9, 0.5, 0.1)}});
  const std::vector<DirectionPair> all = pairs_of_every_kind();
  for (std::size_t count = 0; count <= 35; ++count) {
    const std::span<const DirectionPair> pairs(all.data() + 700, count);
    std::vector<Rgb> values(count + 1, Rgb(-1));
    model->eval(pairs, std::span(values).first(count), GetParam());
    for (std::size_t k = 0; k < count; ++k)
      for (int c = 0; c < 3; ++c) {
        const double single = model->eval(pairs[k].wi, pairs[k].wo)[c];
        EXPECT_NEAR(values[k][c], single, testing::lane_error(single, pairs[k].wi, pairs[k].wo))
            << count << ' ' << k;
      }
    EXPECT_EQ(values[count], Rgb(-1)) << count;
  }
}

INSTANTIATE_TEST_SUITE_P(AllSets, Batch, ::testing::ValuesIn(supported_isas()),
                         [](const auto& isa) { return to_text(isa.param); });

}  // namespace
}  // namespace lamella
