#include "compare/nearest/model_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "compare/exchange/measured_comparison.h"
#include "compare/fit/least_squares.h"
#include "compare/nearest/nearest_models.h"
#include "compare/request/errors.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

constexpr CellGrid kCells{8, 16, false};

// The lobes of a closed form as a target, in the default directions.
std::vector<Truth> truths_of_form(const std::string& request, int channels = 3) {
  const BoundModel model = bind_model(parse_model_request(request), nullptr);
  std::vector<Truth> truths;
  for (const Direction wi : default_directions())
    truths.push_back(projected_truth(*model.model, *model.info, wi, kCells, channels));
  return truths;
}

ParametricModel open_model(const std::string& request, int channels = 3) {
  return parametric_models({parse_model_request(request)}, channels).front();
}

ModelFit fit_to(const std::vector<Truth>& truths, const std::string& request,
                FitNorm norm = FitNorm::relative) {
  const int channels = truths.front().run.channels;
  return fit_model(open_model(request, channels), fit_target(truths, true), norm, Isa::scalar,
                   nullptr);
}

double value_of(const ModelFit& fit, const std::string& name) {
  for (const FittedNumber& n : fit.numbers)
    if (n.number.name() == name) return n.value;
  ADD_FAILURE() << "no " << name;
  return 0;
}

class ModelFits : public ::testing::Test {
  void SetUp() override {
    if (!has_least_squares()) GTEST_SKIP() << "built without Ceres";
  }
};

TEST_F(ModelFits, FindTheParametersOfAFormsOwnLobes) {
  struct Case {
    std::string name, keys;
    std::vector<std::pair<std::string, double>> numbers;
  };
  const std::vector<Case> cases{
      {"eon",
       "albedo=0.8,0.4,0.2,roughness=0.4",
       {{"albedo.r", 0.8}, {"albedo.g", 0.4}, {"albedo.b", 0.2}, {"roughness", 0.4}}},
      {"oren_nayar", "albedo=0.7,0.5,0.3,sigma=0.35", {{"albedo.g", 0.5}, {"sigma", 0.35}}},
      {"vmf_diffuse", "albedo=0.9,0.7,0.4,roughness=0.6", {{"albedo.b", 0.4}, {"roughness", 0.6}}},
      {"lambert_sphere", "albedo=0.9,0.6,0.3", {{"albedo.r", 0.9}, {"albedo.b", 0.3}}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    for (const FitNorm norm : {FitNorm::relative, FitNorm::logarithmic}) {
      const ModelFit fit = fit_to(truths_of_form(c.name + "," + c.keys), c.name, norm);
      for (const auto& [name, truth] : c.numbers)
        for (const FittedNumber& n : fit.numbers)
          if (n.number.name() == name) {
            EXPECT_EQ(n.state, FreeState::found) << name;
            // The target's cells are known within kProjectionTolerance, which `of_truth` is the
            // effect of; the rule of the fit is the projection's first one, within as much again.
            EXPECT_NEAR(n.value, truth, 2 * n.of_truth) << name;
            EXPECT_LT(n.of_truth, 0.01) << name;
          }
      EXPECT_LT(fit.relative_rmse, 2 * kProjectionTolerance);
      EXPECT_EQ(fit.relative_rmse_without_noise, fit.relative_rmse);
    }
  }
}

TEST_F(ModelFits, AreOffByTheNoiseThatTheyTell) {
  std::vector<Truth> truths = truths_of_form("eon,albedo=0.6,roughness=0.5", 1);
  RandomStream stream(7, 0, StreamPurpose::test);
  constexpr double kNoise = 0.05;
  for (Truth& truth : truths) {
    truth.run.accuracy.reset();
    LobeEstimate& lobe = truth.run.reflected.lobes[Order::all];
    for (std::size_t k = 0; k < lobe.value.size(); ++k) {
      const double u = stream.uniform(), v = stream.uniform();
      lobe.standard_error[k] = kNoise * lobe.value[k];
      // Box and Muller 1958.
      lobe.value[k] += lobe.standard_error[k] * std::sqrt(-2 * std::log(u)) * std::cos(2 * kPi * v);
    }
  }
  const ModelFit fit = fit_to(truths, "eon");
  ASSERT_EQ(fit.numbers.size(), 2u);
  for (const FittedNumber& n : fit.numbers) {
    const double truth = n.number.key == "albedo" ? 0.6 : 0.5;
    // One in 1.7 million true fits is farther off than 5 standard errors.
    EXPECT_LT(std::abs(n.value - truth), 5 * n.of_truth) << n.number.key;
    EXPECT_GT(n.of_truth, 1e-4) << n.number.key;
    // What is left over is the noise alone, so both say the same, but that the cells' noise is
    // proportional to f and weighs bright cells more.
    EXPECT_NEAR(n.deviation / n.of_truth, 1, 0.4) << n.number.key;
  }
  EXPECT_NEAR(fit.relative_rmse, fit.noise, 0.15 * fit.noise);
  EXPECT_LT(fit.relative_rmse_without_noise, 0.5 * fit.noise);
}

TEST_F(ModelFits, TellWhatTheTargetDoesNotDetermine) {
  // A form whose light is first * second, and that has a third parameter without effect.
  class Product : public Model {
   public:
    explicit Product(double f) : Model(1), f_(f) {}
    [[nodiscard]] Rgb eval_lobe(int, Direction wi, Direction wo) const override {
      return Rgb(wi.z > 0 && wo.z > 0 ? f_ : 0);
    }

   private:
    double f_;
  };
  ModelInfo info;
  info.name = "product";
  info.lobes = {{"f", "", Order::all}};
  for (const char* name : {"first", "second", "third"})
    info.parameters.push_back(
        {.name = name, .unit = "1", .doc = "", .default_value = "0.5", .min = 0.1, .max = 1});
  info.make = [](const Parameters& p, const Stack*) {
    return std::make_unique<Product>(p.number("first") * p.number("second") / kPi);
  };
  const std::vector<Truth> truths = truths_of_form("lambert,albedo=0.36", 1);
  const FitTarget target = fit_target(truths, false);
  const ModelFit both = fit_model(parametric_model(info, {"product", {}}, 1), target,
                                  FitNorm::relative, Isa::scalar, nullptr);
  EXPECT_EQ(both.numbers[0].state, FreeState::undetermined);
  EXPECT_EQ(both.numbers[1].state, FreeState::undetermined);
  EXPECT_EQ(both.numbers[2].state, FreeState::without_effect);
  EXPECT_TRUE(std::isinf(both.numbers[0].deviation));
  EXPECT_NEAR(both.numbers[0].value * both.numbers[1].value, 0.36, 1e-4);
  const ModelFit one = fit_model(parametric_model(info, {"product", {{"first", "0.5"}}}, 1), target,
                                 FitNorm::relative, Isa::scalar, nullptr);
  EXPECT_EQ(one.numbers[0].state, FreeState::found);
  EXPECT_NEAR(one.numbers[0].value, 0.72, 1e-4);
  const ModelFit end = fit_model(parametric_model(info, {"product", {{"first", "0.2"}}}, 1), target,
                                 FitNorm::relative, Isa::scalar, nullptr);
  EXPECT_EQ(end.numbers[0].state, FreeState::at_high);
  EXPECT_EQ(end.numbers[0].value, 1);
}

TEST_F(ModelFits, RankModelsByWhatTheyLeaveOver) {
  const BoundModel eon = bind_model(parse_model_request("eon,albedo=0.8,roughness=0.7"), nullptr);
  TruthRequest request;
  request.cells = kCells;
  const TargetTruths target = truths_of(*eon.model, *eon.info, 1, request, {});
  const NearestModels nearest =
      nearest_models(target, parametric_models(models_to_fit({"lambert,fon,eon", "oren_nayar"}), 1),
                     FitNorm::relative, FitSides::all, {});
  ASSERT_EQ(nearest.fits.size(), 4u);
  EXPECT_EQ(nearest.fits[0].request.name, "eon");
  EXPECT_EQ(nearest.fits[3].request.name, "lambert");
  for (std::size_t k = 1; k < nearest.fits.size(); ++k)
    EXPECT_GE(nearest.fits[k].misfit, nearest.fits[k - 1].misfit);
  EXPECT_GT(nearest.fits[1].misfit, 10 * nearest.fits[0].misfit);
  // Lambert's law: least squares of a constant, by hand. Every direction counts by its own squares.
  double numerator = 0, denominator = 0;
  for (const Truth& truth : target.truths) {
    const std::vector<double>& f = truth.run.reflected.lobes[Order::all].value;
    double square = 0, sum = 0;
    for (const double x : f) square += x * x, sum += x;
    numerator += sum / square;
    denominator += static_cast<double>(f.size()) / square;
  }
  EXPECT_NEAR(value_of(nearest.fits[3], "albedo"), kPi * numerator / denominator, 1e-6);
  EXPECT_NE(fit_summary(target, nearest).find("--model eon,albedo=0.8,roughness=0.7"),
            std::string::npos)
      << fit_summary(target, nearest);
}

TEST_F(ModelFits, AreTheSameForAnyNumberOfThreads) {
  const std::vector<Truth> truths = truths_of_form("vmf_diffuse,albedo=0.5,roughness=0.3", 1);
  std::vector<ModelFit> fits;
  for (const int threads : {1, 3})
    tbb::task_arena(threads).execute([&] { fits.push_back(fit_to(truths, "eon")); });
  ASSERT_EQ(fits[0].numbers.size(), fits[1].numbers.size());
  for (std::size_t k = 0; k < fits[0].numbers.size(); ++k)
    EXPECT_EQ(fits[0].numbers[k].value, fits[1].numbers[k].value);
  EXPECT_EQ(fits[0].misfit, fits[1].misfit);
}

TEST_F(ModelFits, RefuseWhatCannotBeFitted) {
  const auto refusal = [](const auto& f) -> std::string {
    try {
      f();
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal([] { (void)open_model("eon,nonsense=1"); }), HasSubstr("\"nonsense\""));
  EXPECT_THAT(refusal([] { (void)open_model("nonsense"); }), HasSubstr("allowed: "));
  EXPECT_THAT(refusal([] { (void)open_model("single_scattering"); }), HasSubstr("from a stack"));
  EXPECT_THAT(refusal([] { (void)open_model("microfacet,material=free"); }),
              HasSubstr("allowed of: "));
  std::vector<Truth> dark = truths_of_form("lambert,albedo=0", 1);
  EXPECT_THROW((void)fit_target(dark, false), std::invalid_argument);
}

TEST(ModelsToFit, AreToldApartByTheirNames) {
  const std::vector<ModelRequest> two = models_to_fit({"oren_nayar,eon,albedo=0.9,0.5,0.2"});
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[0].name, "oren_nayar");
  EXPECT_EQ(two[1].values, (KeyValues{{"albedo", "0.9,0.5,0.2"}}));
  const std::vector<ModelRequest> all = models_to_fit({"all"});
  EXPECT_GT(all.size(), 15u);
  for (const ModelRequest& request : all) {
    EXPECT_NE(request.name, "spongecake");
    EXPECT_NE(request.name, "beckmann_diffuse");
  }
}

TEST(FreeNumbers, AreThoseThatAreNotGiven) {
  const auto names = [](const std::string& request, int channels) {
    std::vector<std::string> list;
    for (const FreeNumber& n : open_model(request, channels).free) list.push_back(n.name());
    return list;
  };
  EXPECT_THAT(names("eon", 1), ::testing::ElementsAre("albedo", "roughness"));
  EXPECT_THAT(names("eon,roughness=0.5", 3),
              ::testing::ElementsAre("albedo.r", "albedo.g", "albedo.b"));
  EXPECT_THAT(names("microfacet", 1), ::testing::Not(::testing::Contains("roughness_y")));
  EXPECT_THAT(names("microfacet,roughness_y=free", 1), ::testing::Contains("roughness_y"));
  EXPECT_THAT(names("coated,base=eon", 1), ::testing::Contains("base.roughness"));
  EXPECT_THAT(names("coated", 1), ::testing::Not(::testing::Contains("ior")));
}

}  // namespace
}  // namespace lamella
