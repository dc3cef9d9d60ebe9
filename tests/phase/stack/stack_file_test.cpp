#include "phase/stack/stack_file.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "phase/random/random.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella::testing {
namespace {

Stack parse(const std::string& text) { return parse_stack(text, "file.toml", "name"); }

std::string error_of(const std::string& text) {
  try {
    (void)parse(text);
  } catch (const StackFileError& error) {
    return error.what();
  }
  return "no error";
}

TEST(StackFile, EveryBuiltInStackSurvivesTheRoundTrip) {
  for (const BuiltinStack& builtin : builtin_stacks()) {
    const Stack stack = load_stack(builtin.name);
    const std::string text = to_toml(stack);
    const Stack again = parse(text);
    EXPECT_EQ(to_toml(again), text) << builtin.name;
    ASSERT_EQ(again.layers.size(), stack.layers.size());
    for (std::size_t k = 0; k < stack.layers.size(); ++k) {
      const Layer &a = stack.layers[k], &b = again.layers[k];
      EXPECT_EQ(a.medium.index(), b.medium.index());
      EXPECT_EQ(a.parameters.all(), b.parameters.all());
      EXPECT_EQ(a.albedo, b.albedo);
      EXPECT_EQ(a.f0, b.f0);
      EXPECT_EQ(a.depth(), b.depth());
      const Direction w = direction_from_mu_phi(0.4, 1);
      EXPECT_EQ(sigma(a.medium, w), sigma(b.medium, w));
    }
    EXPECT_EQ(again.substrate.has_value(), stack.substrate.has_value());
    EXPECT_FALSE(builtin.doc.empty() || builtin.source.empty());
  }
  EXPECT_NO_THROW((void)load_stack(std::string(kDefaultStack)));
}

// Names and keys of a closed form below are checked by another room; until then any text is kept.
TEST(StackFile, WordsOfASubstrateSurviveTheRoundTrip) {
  const std::string text = R"([substrate]
bsdf = "a\\b \"c\" \n\u0007"
"d \"e\" = \u001f" = "f \"g\\\t"
)";
  const Stack stack = parse(text);
  EXPECT_EQ(stack.substrate->model, "a\\b \"c\" \n\a");
  const Stack again = parse(to_toml(stack));
  EXPECT_EQ(again.substrate->model, stack.substrate->model);
  EXPECT_EQ(again.substrate->parameters.all(), stack.substrate->parameters.all());
  EXPECT_EQ(std::get<std::string>(again.substrate->parameters.at("d \"e\" = \x1f")), "f \"g\\\t");
  EXPECT_EQ(error_of("[substrate]\nbsdf = \"\"\n"),
            "file.toml:2: substrate: key \"bsdf\": found an empty word; allowed: a closed form's "
            "name");
}

TEST(StackFile, FillsInTheDefaults) {
  const Stack stack = parse(
      "[[layer]]\nmedium = \"sggx\"\nroughness = 0.5\nthickness = 1\n"
      "[[layer]]\nmedium = \"sggx\"\nshape = \"fiber\"\nroughness = 0.5\nthickness = 1\n"
      "[[layer]]\nmedium = \"vmf_flake\"\nroughness = 0.5\nthickness = 1\n"
      "[[layer]]\nmedium = \"henyey_greenstein\"\nthickness = 2.0\n[substrate]\n");
  EXPECT_EQ(stack.layers[0].parameters.choice("shape"), "surface");
  EXPECT_EQ(stack.layers[0].parameters.choice("flake"), "mirror");
  EXPECT_EQ(stack.layers[0].parameters.vector("axis"), (Direction{0, 0, 1}));
  EXPECT_EQ(stack.layers[0].f0, Rgb(1));
  EXPECT_EQ(stack.layers[0].albedo, Rgb(1));
  EXPECT_EQ(stack.layers[0].density, 1);
  EXPECT_EQ(stack.layers[1].parameters.vector("axis"), (Direction{1, 0, 0}));
  EXPECT_EQ(stack.layers[2].parameters.choice("flake"), "lambert");
  EXPECT_EQ(stack.layers[3].parameters.number("g"), 0);
  EXPECT_EQ(stack.layers[3].thickness, 2);
  ASSERT_TRUE(stack.substrate);
  EXPECT_EQ(stack.substrate->albedo, Rgb(1));
}

TEST(StackFile, NormalisesTheAxisAndTakesColoursAsNumbersOrTriples) {
  const Stack stack = parse(
      "[[layer]]\nmedium = \"sggx\"\nroughness = 1\naxis = [0, 3, 4]\nthickness = inf\n"
      "albedo = [1, 0.5, 0]\nf0 = 0.04\ndensity = 2");
  EXPECT_NEAR(length(stack.layers[0].parameters.vector("axis") - Direction{0, 0.6, 0.8}), 0, 2e-16);
  EXPECT_EQ(stack.layers[0].albedo, Rgb(1, 0.5, 0));
  EXPECT_EQ(stack.layers[0].f0, Rgb(0.04));
  EXPECT_TRUE(stack.is_half_space());
}

TEST(StackFile, AnAxisThatWasNormalisedStaysAsItIs) {
  const ParameterInfo axis{
      .name = "axis", .kind = ParameterKind::vector, .unit = "1", .doc = "mean normal"};
  const auto is_kept = [&](std::vector<double> v) {
    const ParameterValue once = checked(axis, v);
    EXPECT_EQ(checked(axis, once), once) << to_text(ParameterValue(v));
    const auto& unit = std::get<std::vector<double>>(once);
    EXPECT_NEAR(std::hypot(unit[0], unit[1], unit[2]), 1, 1e-15);
  };
  is_kept({5, 0, 1});  // an ulp off at the second pass if it is normalised again
  RandomStream stream(1, 0, StreamPurpose::test);
  const auto element = [&] {
    return (2 * stream.uniform() - 1) * std::pow(10, 20 * stream.uniform() - 10);
  };
  for (int k = 0; k < 100000; ++k) is_kept({element(), element(), element()});
}

TEST(StackFile, ReadsWindowsLineEndingsAndIntegers) {
  EXPECT_EQ(parse("[[layer]]\r\nmedium = \"lambert_sphere\"\r\nthickness = 1\r\n").layers.size(),
            1U);
}

TEST(StackFile, LoadsAFileByPathAndNamesWhatItCannotOpen) {
  const auto path = std::filesystem::path(::testing::TempDir()) /
                    ("stack_" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
                     "_file_test.toml");
  std::ofstream(path) << "[[layer]]\nmedium = \"lambert_sphere\"\nthickness = 1\nalbdo = 1\n";
  try {
    (void)load_stack(path.string());
    FAIL();
  } catch (const StackFileError& error) {
    EXPECT_NE(std::string(error.what()).find(path.string() + ":4: "), std::string::npos);
  }
  std::filesystem::remove(path);
  for (const std::string what : {"vmf_sandd", ".", "no/such/file.toml", ""}) {
    try {
      (void)load_stack(what);
      FAIL() << what;
    } catch (const StackFileError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("allowed: a TOML file"), std::string::npos) << message;
      const bool near = what == "vmf_sandd";
      EXPECT_TRUE(!near || message.find("did you mean \"vmf_sand\"?") != std::string::npos);
    }
  }
}

struct Broken {
  std::string what, text;
  int line;
  std::vector<std::string> named;  // key, value found, values allowed, suggestion
};

const std::string kLayer = "[[layer]]\n";
const std::string kSphere = kLayer + "medium = \"lambert_sphere\"\n";
const std::string kSggx = kLayer + "medium = \"sggx\"\nthickness = 1\n";
const std::string kVmf = kLayer + "medium = \"vmf_flake\"\nthickness = 1\n";

std::vector<Broken> broken_stacks() {
  const std::string spd = "positive definite";
  return {
      {"empty file", "", 1, {"\"layer\"", "found nothing", "[[layer]]"}},
      {"no layer", "", 1, {"\"layer\"", "found nothing", "[[layer]]"}},
      {"bad syntax", kSphere + "thickness = = 1\n", 3, {"not valid TOML"}},
      {"bad bytes", kSphere + "thickness = 1 # \xff\xfe\n", 3, {"not valid TOML"}},
      {"letter outside of strings",
       kSphere + "thickness = 1\nrough\u03bc = 1\n",
       4,
       {"not valid TOML"}},
      {"key twice", kSphere + "thickness = 1\nthickness = 2\n", 4, {"not valid TOML"}},
      {"layer is no table", "layer = 3\n", 1, {"\"layer\"", "found 3", "[[layer]]"}},
      {"layer is one table", "[layer]\nthickness = 1\n", 1, {"\"layer\"", "a table", "[[layer]]"}},
      {"layers are no tables", "layer = [1, 2]\n", 1, {"\"layer\"", "an array", "[[layer]]"}},
      {"no layers in the list", "layer = []\n", 1, {"\"layer\"", "an array", "[[layer]]"}},
      {"unknown top key",
       kSphere + "thickness = 1\n[substrat]\n",
       4,
       {"\"substrat\"", "did you mean \"substrate\"?", "allowed: layer, substrate"}},
      {"no medium",
       kLayer + "thickness = 1\n",
       1,
       {"layer 0", "\"medium\"", "found nothing", "one of sggx, vmf_flake, lambert_sphere"}},
      {"unknown medium",
       kLayer + "medium = \"vmf_flakes\"\nthickness = 1\n",
       2,
       {"\"medium\"", "\"vmf_flakes\"", "did you mean \"vmf_flake\"?", "henyey_greenstein"}},
      {"medium is a number",
       kLayer + "medium = 5\nthickness = 1\n",
       2,
       {"\"medium\"", "found 5", "one of sggx"}},
      {"unknown key",
       kSphere + "thickness = 1\nalbdo = 0.5\n",
       4,
       {"layer 0", "\"albdo\"", "did you mean \"albedo\"?", "allowed: medium, ",
        "albedo, thickness"}},
      {"key of another medium", kSphere + "thickness = 1\ng = 0.5\n", 4, {"\"g\"", "allowed:"}},
      {"missing thickness",
       kSphere + "albedo = 1\n",
       1,
       {"\"thickness\"", "found nothing", "a number in [0, inf]"}},
      {"negative thickness",
       kSphere + "thickness = -1\n",
       3,
       {"\"thickness\"", "found -1", "a number in [0, inf]"}},
      {"thickness is text",
       kSphere + "thickness = \"thin\"\n",
       3,
       {"\"thickness\"", "found \"thin\"", "a number in [0, inf]"}},
      {"thickness is not a number",
       kSphere + "thickness = nan\n",
       3,
       {"\"thickness\"", "found nan"}},
      {"thickness is a flag", kSphere + "thickness = true\n", 3, {"\"thickness\"", "found true"}},
      {"thickness is a date",
       kSphere + "thickness = 1979-05-27\n",
       3,
       {"\"thickness\"", "found a date or time"}},
      {"infinite density",
       kSphere + "thickness = 1\ndensity = inf\n",
       4,
       {"\"density\"", "found inf", "a number in [0, inf)"}},
      {"no density at infinite thickness",
       kSphere + "thickness = inf\ndensity = 0\n",
       4,
       {"\"density\"", "found 0 with an infinite thickness", "(0, inf)"}},
      {"depth beyond all numbers",
       kSphere + "thickness = 1e300\ndensity = 1e300\n",
       4,
       {"\"density\"", "found 1e+300", "finite"}},
      {"albedo above one",
       kSphere + "thickness = 1\nalbedo = 1.2\n",
       4,
       {"\"albedo\"", "found 1.2", "each in [0, 1]"}},
      {"albedo of two",
       kSphere + "thickness = 1\nalbedo = [0.1, 0.2]\n",
       4,
       {"\"albedo\"", "found [0.1, 0.2]", "three numbers"}},
      {"albedo with text",
       kSphere + "thickness = 1\nalbedo = [0.1, \"a\", 0.2]\n",
       4,
       {"\"albedo\"", "found an array", "three numbers"}},
      {"albedo is a table",
       kSphere + "thickness = 1\nalbedo = { r = 1 }\n",
       4,
       {"\"albedo\"", "found a table"}},
      {"infinite layer not last",
       kSphere + "thickness = inf\n" + kSphere + "thickness = 1\n",
       3,
       {"layer 0", "\"thickness\"", "found inf", "only the last layer"}},
      {"substrate below a half space",
       kSphere + "thickness = inf\n[substrate]\nalbedo = 1\n",
       4,
       {"\"substrate\"", "below an infinite layer", "finite thickness"}},
      {"substrate is no table",
       "substrate = 1\n" + kSphere + "thickness = 1\n",
       1,
       {"\"substrate\"", "found 1"}},
      {"black substrate with an albedo",
       kSphere + "thickness = 1\n[substrate]\nbsdf = \"black\"\nalbedo = 0.2\n",
       6,
       {"\"albedo\"", "allowed: 0"}},
      {"no roughness", kSggx, 1, {"\"roughness\"", "found nothing", "[0.001, 1]"}},
      {"roughness too small", kSggx + "roughness = 0\n", 4, {"\"roughness\"", "[0.001, 1]"}},
      {"unknown shape",
       kSggx + "roughness = 1\nshape = \"fibre\"\n",
       5,
       {"\"shape\"", "\"fibre\"", "did you mean \"fiber\"?", "surface, fiber"}},
      {"axis zero",
       kSggx + "roughness = 1\naxis = [0, 0, 0]\n",
       5,
       {"\"axis\"", "found [0, 0, 0]", "not all zero"}},
      {"axis of two", kSggx + "roughness = 1\naxis = [0, 1]\n", 5, {"\"axis\"", "found [0, 1]"}},
      {"axis infinite", kSggx + "roughness = 1\naxis = [inf, 0, 0]\n", 5, {"\"axis\"", "inf"}},
      {"matrix not positive",
       kSggx + "matrix = [1, 1, -1, 0, 0, 0]\n",
       4,
       {"\"matrix\"", "found [1, 1, -1, 0, 0, 0]", spd}},
      {"matrix of five", kSggx + "matrix = [1, 1, 1, 0, 0]\n", 4, {"\"matrix\"", "six numbers"}},
      {"matrix singular to rounding",
       kSggx + "matrix = [1, 1, 1, 0.99999999999999, 0, 0]\n",
       4,
       {"\"matrix\"", spd}},
      {"matrix beside roughness",
       kSggx + "matrix = [1, 1, 1, 0, 0, 0]\nroughness = 1\n",
       5,
       {"\"roughness\"", "nothing beside \"matrix\""}},
      {"f0 on lambert flakes",
       kSggx + "roughness = 1\nflake = \"lambert\"\nf0 = 0.04\n",
       6,
       {"\"f0\"", "found 0.04", "only mirror flakes"}},
      {"roughness and alpha",
       kVmf + "roughness = 0.5\nalpha = 1\n",
       5,
       {"\"alpha\"", "found 1", "nothing beside \"roughness\""}},
      {"neither roughness nor alpha", kVmf, 1, {"\"roughness\"", "found nothing", "\"alpha\""}},
      {"negative alpha", kVmf + "alpha = -1\n", 4, {"\"alpha\"", "found -1", "[0, inf]"}},
      {"roughness above one", kVmf + "roughness = 1.5\n", 4, {"\"roughness\"", "[0, 1]"}},
      {"g = 1",
       kLayer + "medium = \"henyey_greenstein\"\nthickness = 1\ng = 1\n",
       4,
       {"\"g\"", "found 1", "(-1, 1)"}},
  };
}

TEST(StackFile, RefusesBrokenStacksAndNamesFileLineKeyValueAndWhatIsAllowed) {
  ASSERT_GE(broken_stacks().size(), 25U);
  for (const Broken& broken : broken_stacks()) {
    const std::string message = error_of(broken.text);
    const std::string place = "file.toml:" + std::to_string(broken.line) + ": ";
    EXPECT_EQ(message.rfind(place, 0), 0U) << broken.what << ": " << message;
    for (const std::string& part : broken.named)
      EXPECT_NE(message.find(part), std::string::npos)
          << broken.what << ": no " << part << " in: " << message;
  }
}

TEST(StackFile, AGridKeepsItsNameSizeAndFolder) {
  const std::string text =
      "[[layer]]\nmedium = 'lambert_sphere'\nthickness = 1\n"
      "grid = 'a \"quoted\" \\ name, \u00fc.vdb'\nsize = [0.5, 2]\ngrid_albedo = 'white'\n";
  const Stack stack = parse_stack(text, "some/where/stack.toml", "x");
  ASSERT_TRUE(stack.layers[0].grid);
  const GridReference& grid = *stack.layers[0].grid;
  EXPECT_EQ(grid.file, "a \"quoted\" \\ name, \u00fc.vdb");
  EXPECT_EQ(grid.folder, "some/where");
  EXPECT_EQ(grid.size_x, 0.5);
  EXPECT_EQ(grid.size_y, 2);
  EXPECT_TRUE(grid.white);
  EXPECT_EQ(grid.where, "some/where/stack.toml:4: layer 0");
  EXPECT_TRUE(stack.has_grid());
  EXPECT_FALSE(stack.is_symmetric_about_z());
  const std::string written = to_toml(stack);
  const Stack again = parse(written);
  EXPECT_EQ(to_toml(again), written);
  EXPECT_EQ(again.layers[0].grid->file, grid.file);
}

TEST(StackFile, AGridKeepsTheNamesAndTheTileOfItsFile) {
  const std::string head =
      "[[layer]]\nmedium = 'lambert_sphere'\nthickness = 1\nsize = [1, 1]\ngrid = ";
  const std::string text = head +
                           "'smoke.vdb'\ndensity_grid = 'smoke'\nalbedo_grid = 'Cd'\n"
                           "voxels = [16, 32, 8]\nfirst_voxel = [-8, 0, 4]\n";
  const GridReference grid = *parse_stack(text, "a.toml", "x").layers[0].grid;
  EXPECT_EQ(grid.names, (std::array<std::string, 4>{"smoke", "", "", "Cd"}));
  EXPECT_EQ(grid.voxels, (std::array<int, 3>{16, 32, 8}));
  EXPECT_EQ(grid.first_voxel, (std::array<int, 3>{-8, 0, 4}));
  const std::string written = to_toml(parse(text));
  const GridReference again = *parse(written).layers[0].grid;
  EXPECT_EQ(again.names, grid.names);
  EXPECT_EQ(again.voxels, grid.voxels);
  EXPECT_EQ(again.first_voxel, grid.first_voxel);
  EXPECT_EQ(to_toml(parse(written)), written);
  const auto refusal = [&](const std::string& keys) {
    try {
      (void)parse(head + keys);
    } catch (const StackFileError& error) {
      return std::string(error.what());
    }
    return std::string("no refusal");
  };
  const auto expect = [&](const std::string& keys, std::initializer_list<const char*> parts) {
    const std::string text_of_it = refusal(keys);
    for (const char* part : parts)
      EXPECT_NE(text_of_it.find(part), std::string::npos) << text_of_it;
  };
  expect("'a.vdb'\nvoxels = [16, 16]\n",
         {":6:", "\"voxels\"", "found [16, 16]", "three whole numbers"});
  expect("'a.vdb'\nvoxels = [16, 0, 8]\n", {"found [16, 0, 8]", "[1, "});
  expect("'a.vdb'\nfirst_voxel = [1, 2, 3]\n", {"\"first_voxel\"", "without \"voxels\""});
  expect("'a.vdb'\ndensity_grid = 3\n", {"\"density_grid\"", "found 3", "name of a grid"});
  expect("'builtin:weave'\nalbedo_grid = 'x'\n", {"\"albedo_grid\"", "a .vdb file only"});
}

// toml++ does not convert integers beyond 2^53 that double has to round.
TEST(StackFile, TakesWholeNumbersOfAnySizeAsTheirNearestDouble) {
  const auto thickness = [](const char* number) {
    return parse_stack(
               std::string("[[layer]]\nmedium = 'lambert_sphere'\nthickness = ") + number + "\n",
               "test", "test")
        .layers[0]
        .thickness;
  };
  EXPECT_EQ(thickness("9007199254740993"), 9007199254740992.0);
  EXPECT_EQ(thickness("33776997205278721"), 33776997205278720.0);
  EXPECT_EQ(thickness("9223372036854775807"), 0x1p63);
  EXPECT_EQ(thickness("4"), 4.0);
}

}  // namespace
}  // namespace lamella::testing
