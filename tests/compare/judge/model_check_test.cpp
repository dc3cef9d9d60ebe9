#include "compare/judge/model_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "analytic/model/batched_model.h"
#include "compare/judge/density_cells.h"
#include "compare/judge/model_configurations.h"
#include "compare/judge/sampler_statistics.h"
#include "compare/judge/value_checks.h"
#include "compare/judge/value_noise.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

// A model of one function of both directions, with the cosine law for a sampler unless told
// otherwise.
class FunctionForm : public Model {
 public:
  using Value = std::function<double(Direction, Direction)>;
  explicit FunctionForm(Value f) : Model(1), f_(std::move(f)) {}
  [[nodiscard]] Rgb eval_lobe(int, Direction wi, Direction wo) const override {
    return Rgb(f_(wi, wo));
  }
  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    return pdf_scale * Model::pdf(wi, wo);
  }
  double pdf_scale = 1;

 private:
  Value f_;
};

double lambert(Direction wi, Direction wo) { return (wi.z < 0) == (wo.z < 0) ? 0.5 / kPi : 0; }

// The same, asked for many pairs at a time, and counting how many.
class BatchedForm : public BatchedModel {
 public:
  using BatchedModel::eval;
  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values, Isa) const override {
    calls.push_back(pairs.size());
    for (std::size_t k = 0; k < pairs.size(); ++k)
      values[k] = Rgb(lambert(pairs[k].wi, pairs[k].wo) + (pairs.size() == 1 ? alone : 0));
  }
  mutable std::vector<std::size_t> calls{};
  double alone = 0;  ///< what a pair alone has more
};

CheckedModel checked(const Model& model) { return {.model = model, .request = "form"}; }

CheckLine values_of(const Model& model) {
  CheckLine line{"values", ""};
  check_values(checked(model), checked_pairs(1), line);
  return line;
}

TEST(CheckLine, KeepsTheWorstCaseAndItsVerdict) {
  CheckLine line;
  EXPECT_EQ(line.verdict(), CheckVerdict::skipped);
  const auto named = [](const char* name) { return [name] { return CheckCase{.text = name}; }; };
  line.offer(0.5, 1, named("half"));
  line.offer(0.2, 1, named("less"));
  EXPECT_EQ(line.verdict(), CheckVerdict::pass);
  EXPECT_EQ(line.worst->text, "half");
  line.undecided = 2;
  EXPECT_EQ(line.verdict(), CheckVerdict::undecided);
  line.offer(std::numeric_limits<double>::quiet_NaN(), 1, named("nan"));
  line.offer(2, 1, named("twice"));
  EXPECT_EQ(line.verdict(), CheckVerdict::fail);
  EXPECT_EQ(line.worst->text, "nan");  // worse than any number
  EXPECT_EQ(line.cases, 4u);
}

TEST(CheckedPairs, HaveTheHardCases) {
  const std::vector<DirectionPair> pairs = checked_pairs(1);
  bool retro = false, straight = false, mirror = false, grazing = false, below = false;
  for (const auto& [wi, wo] : pairs) {
    EXPECT_NEAR(wi.x * wi.x + wi.y * wi.y + wi.z * wi.z, 1, 1e-12);
    retro = retro || wi == wo;
    straight = straight || wo == -wi;
    mirror = mirror || (std::hypot(wi.x + wo.x, wi.y + wo.y) < 1e-12 && wi.z == wo.z && wi.z < 0.9);
    grazing = grazing || (wi.z > 0 && wi.z < 1e-6);
    below = below || (wi.z < 0 && wo.z < 0);
    EXPECT_FALSE(wi.z == 0 && wo.z == 0);
  }
  EXPECT_TRUE(retro && straight && mirror && grazing && below);
}

TEST(ValueChecks, FindWhatIsNegativeNotFiniteOrOnTheOtherSide) {
  EXPECT_EQ(values_of(FunctionForm(lambert)).verdict(), CheckVerdict::pass);
  const CheckLine negative = values_of(
      FunctionForm([](Direction wi, Direction wo) { return lambert(wi, wo) * (wi.z - 1e-4); }));
  EXPECT_EQ(negative.verdict(), CheckVerdict::fail);
  EXPECT_LT(negative.worst->wi->z, 1e-4);
  const CheckLine nan = values_of(FunctionForm([](Direction wi, Direction wo) {
    return wi == wo ? std::numeric_limits<double>::quiet_NaN() : lambert(wi, wo);
  }));
  EXPECT_EQ(nan.verdict(), CheckVerdict::fail);
  EXPECT_EQ(*nan.worst->wi, *nan.worst->wo);
  const CheckLine through = values_of(FunctionForm([](Direction, Direction) { return 0.5 / kPi; }));
  EXPECT_EQ(through.verdict(), CheckVerdict::fail);
  EXPECT_THAT(through.worst->text, HasSubstr("pass through"));
}

TEST(ValueChecks, FindWhatIsNotReciprocalBeyondItsOwnRounding) {
  const auto line_of = [](const Model& model, bool single) {
    CheckLine line{"reciprocity", ""};
    CheckedModel m = checked(model);
    m.single_precision = single;
    check_reciprocity(m, checked_pairs(1), 5, line);
    return line;
  };
  EXPECT_EQ(line_of(FunctionForm(lambert), false).verdict(), CheckVerdict::pass);
  // Off by a millionth: wrong in double, less than a float of these sums resolves.
  const auto lopsided = [](Direction wi, Direction wo) {
    return lambert(wi, wo) * (1 + 1e-6 * wi.z);
  };
  EXPECT_EQ(line_of(FunctionForm(lopsided), false).verdict(), CheckVerdict::fail);
  // Three terms in another order with the directions swapped: off by a float's rounding.
  const auto rounded = [](Direction wi, Direction wo) {
    const auto a = static_cast<float>(wi.z), b = static_cast<float>(wo.z);
    const float sum = (a + 0.7f) + b;
    return lambert(wi, wo) > 0 ? static_cast<double>(sum * 0.1f) : 0.0;
  };
  EXPECT_EQ(line_of(FunctionForm(rounded), true).verdict(), CheckVerdict::pass);
  EXPECT_EQ(line_of(FunctionForm([&](Direction wi, Direction wo) {
                      return rounded(wi, wo) * (1 + 1e-3 * std::max(wi.z, 0.0));
                    }),
                    true)
                .verdict(),
            CheckVerdict::fail);
}

TEST(ValueChecks, AskABatchedModelForManyPairsAtATime) {
  BatchedForm model;
  CheckLine values{"values", ""}, reciprocity{"reciprocity", ""}, batches{"batches", ""};
  const std::vector<DirectionPair> pairs = checked_pairs(1);
  check_values(checked(model), pairs, values);
  check_reciprocity(checked(model), pairs, 5, reciprocity);
  EXPECT_THAT(model.calls, ::testing::Each(pairs.size()));
  check_batches(checked(model), pairs, batches);
  EXPECT_LT(std::count(model.calls.begin(), model.calls.end(), 1u), 64);
  for (const CheckLine& line : {values, reciprocity, batches})
    EXPECT_EQ(line.verdict(), CheckVerdict::pass) << line.name;
  model.alone = 1e-6;
  CheckLine odd{"batches", ""};
  check_batches(checked(model), pairs, odd);
  EXPECT_EQ(odd.verdict(), CheckVerdict::fail);
  EXPECT_THAT(odd.worst->text, HasSubstr("alone"));
}

TEST(ValueNoise, IsTheRoundingOfTheValues) {
  const Direction wi = direction_from_mu_phi(0.6, 0.3), wo = direction_from_mu_phi(0.7, 2);
  const auto smooth = [](Direction i, Direction o) { return 1 + std::sin(3 * i.z) * o.z; };
  EXPECT_LT(value_noise(FunctionForm(smooth), wi, wo).r, 1e-14);
  const FunctionForm rounded(
      [&](Direction i, Direction o) { return static_cast<float>(smooth(i, o)); });
  // A float rounds to steps of 2^-23 of 1 to 2: the deviation is that over the root of 12, which
  // few differences tell within a factor 3.
  const double expected = 0x1p-23 / std::sqrt(12.0);
  EXPECT_GT(value_noise(rounded, wi, wo).r, expected / 3);
  EXPECT_LT(value_noise(rounded, wi, wo).r, expected * 3);
  EXPECT_TRUE(is_single_precision(rounded, 1, checked_pairs(1)));
  EXPECT_FALSE(is_single_precision(FunctionForm(smooth), 1, checked_pairs(1)));
}

TEST(DensityCells, TileTheSphereAndIntegrateToOne) {
  std::vector<Direction> pilot;
  RandomStream stream(3, 0, StreamPurpose::test);
  // The cosine law.
  for (int k = 0; k < 1000; ++k) {
    const double mu = std::sqrt(stream.uniform());
    pilot.push_back(direction_from_mu_phi(mu, 2 * kPi * stream.uniform()));
  }
  const DensityCells cells(pilot);
  const DensityCells::Shares shares = cells.integrate(
      [](Direction w) { return std::max(w.z, 0.0) / kPi; }, 1e-6, [] { return false; });
  double sum = 0, error = 0;
  for (std::size_t k = 0; k < cells.count(); ++k) sum += shares.value[k], error += shares.error[k];
  EXPECT_NEAR(sum, 1, error + 1e-12);
  EXPECT_LT(error, 1e-4);
  // Counts of other draws are those shares: chi-square with a chance of 1e-6 by Wilson and
  // Hilferty's cube root.
  constexpr int kDraws = 200000;
  std::vector<double> counts(cells.count());
  for (int k = 0; k < kDraws; ++k) {
    const double mu = std::sqrt(stream.uniform());
    counts[cells.cell_of(direction_from_mu_phi(mu, 2 * kPi * stream.uniform()))] += 1;
  }
  double chi = 0, degrees = -1;
  for (std::size_t k = 0; k < cells.count(); ++k) {
    const double expected = kDraws * shares.value[k];
    if (expected < 5) continue;
    chi += (counts[k] - expected) * (counts[k] - expected) / expected;
    degrees += 1;
  }
  const double z =
      (std::cbrt(chi / degrees) - (1 - 2 / (9 * degrees))) / std::sqrt(2 / (9 * degrees));
  EXPECT_LT(z, 4.75);
}

TEST(SamplerChecks, FindDensitiesThatDoNotBelongToTheirDraws) {
  const SamplerCheckSettings settings{
      .samples = 4000, .seed = 1, .level = 1e-6, .seconds = 1, .stop = [] { return false; }};
  const Direction wo = direction_from_mu_phi(0.6, 0);
  const auto lines_of = [&](double scale) {
    FunctionForm model(lambert);
    model.pdf_scale = scale;
    SamplerLines lines;
    check_sampler(checked(model), wo, settings, lines);
    return lines;
  };
  const SamplerLines right = lines_of(1);
  for (const CheckLine* line : {&right.density, &right.samples, &right.weights})
    EXPECT_EQ(line->verdict(), CheckVerdict::pass);
  // f |mu| / pdf of Lambert's law under the cosine law is the albedo, always.
  EXPECT_NEAR(right.extremes.max_weight, 0.5, 1e-12);
  EXPECT_NEAR(right.extremes.variance, 0, 1e-12);
  const SamplerLines wrong = lines_of(1.1);
  for (const CheckLine* line : {&wrong.density, &wrong.weights})
    EXPECT_EQ(line->verdict(), CheckVerdict::fail);
  EXPECT_NEAR(wrong.density.worst->found, 0.1, 1e-6);
}

TEST(SamplerStatistics, AreThoseOfBatchesToo) {
  const Direction wo = direction_from_mu_phi(0.6, 0);
  // More samples than a block has.
  const SamplerStatistics one = sampler_statistics(FunctionForm(lambert), wo, 5000, 1);
  const BatchedForm batched;
  const SamplerStatistics many = sampler_statistics(batched, wo, 5000, 1);
  EXPECT_EQ(one.mean, many.mean);
  EXPECT_EQ(one.max_weight, many.max_weight);
  EXPECT_EQ(batched.calls.size(), 2u);
}

TEST(ModelConfigurations, VaryWhatIsNotGiven) {
  const ModelInfo& eon = *find_model("eon");
  const std::vector<ModelRequest> all = configurations_of(eon, {"eon", {}}, 24, 1);
  EXPECT_LE(all.size(), 24u);
  EXPECT_EQ(to_request(all.front()), "eon");
  std::set<std::string> texts, roughnesses;
  for (const ModelRequest& request : all) {
    texts.insert(to_request(request));
    for (const auto& [key, value] : request.values)
      if (key == "roughness") roughnesses.insert(value);
  }
  EXPECT_EQ(texts.size(), all.size());
  EXPECT_THAT(roughnesses, ::testing::ElementsAre("0", "0.5", "1"));
  roughnesses.clear();
  for (const ModelRequest& request : configurations_of(eon, {"eon", {{"roughness", "0.3"}}}, 24, 1))
    for (const auto& [key, value] : request.values)
      if (key == "roughness") roughnesses.insert(value);
  EXPECT_THAT(roughnesses, ::testing::ElementsAre("0.3"));
  EXPECT_EQ(configurations_of(eon, {"eon", {}}, 3, 1).size(), 3u);
}

TEST(ModelChecks, EndWhenTheyAreStoppedAndSayWhatIsMissing) {
  int asked = 0;
  const CheckConfiguration configuration{"form",
                                         [] { return std::make_shared<FunctionForm>(lambert); }};
  const ModelCheck check = check_model(
      {configuration, {"refused", [] { return nullptr; }}, configuration},
      {.samples = 256, .seconds = 20, .few_angles = true, .stop = [&] { return ++asked > 0; }});
  // The first configuration is always begun; none follows.
  EXPECT_EQ(check.configurations, 1);
  EXPECT_FALSE(check.failed());
  EXPECT_FALSE(check.ended_by_time);
  const ModelCheck whole = check_model({configuration, {"refused", [] { return nullptr; }}},
                                       {.samples = 256, .few_angles = true});
  EXPECT_EQ(whole.refused, 1);
  EXPECT_EQ(whole.lines.size(), 8u);
  EXPECT_FALSE(whole.failed());
}

}  // namespace
}  // namespace lamella
