// Whatever the stack: `auto` answers with finite, physical numbers in bounded time.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "compare/truth/ground_truth.h"
#include "phase/medium/media.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The values of a parameter that a scan takes: both ends of a number, every choice. Ends that are
// open, or infinite, are replaced by something near them.
std::vector<std::string> ends_of(const ParameterInfo& p) {
  std::vector<std::string> values;
  if (p.kind == ParameterKind::choice)
    for (const std::string& choice : p.choices) values.push_back(fmt::format("\"{}\"", choice));
  if (p.kind == ParameterKind::number) {
    const double low = std::isinf(p.min) ? -1e3 : p.min, high = std::isinf(p.max) ? 1e3 : p.max;
    values.push_back(to_text(p.min_open ? low + 1e-6 * (high - low) : low));
    values.push_back(to_text(p.max_open ? high - 1e-9 * (high - low) : high));
  }
  return values;
}

// Every medium with each of its numbers at both ends and each of its choices, the other keys being
// as they are by default, and with all pairs of a choice and an end.
std::vector<std::string> all_media() {
  std::vector<std::string> list;
  for (const MediumInfo& info : media()) {
    const std::string medium = fmt::format("medium = \"{}\"\n", info.name);
    std::vector<std::string> bases{medium};
    for (const ParameterInfo& p : info.parameters)
      if (p.kind == ParameterKind::choice)
        for (const std::string& base : std::vector<std::string>(bases))
          for (const std::string& value : ends_of(p))
            bases.push_back(base + fmt::format("{} = {}\n", p.name, value));
    for (const std::string& base : bases) {
      list.push_back(base);
      for (const ParameterInfo& p : info.parameters)
        if (p.kind == ParameterKind::number)
          for (const std::string& value : ends_of(p))
            list.push_back(base + fmt::format("{} = {}\n", p.name, value));
    }
  }
  return list;
}

void expect_physical(const RunResult& run) {
  const auto within = [](const Estimate& e, const char* what) {
    EXPECT_TRUE(std::isfinite(e.value) && std::isfinite(e.standard_error)) << what;
    EXPECT_GE(e.value, -e.standard_error - 1e-9) << what;
    // A colour's walks carry weights: an energy is off by some of its standard errors.
    EXPECT_LE(e.value, 1 + 6 * e.standard_error + 1e-9) << what;
  };
  double sum = 0, error = 0;
  const auto add = [&](const Estimate& e) {
    sum += e.value;
    error += e.standard_error;
  };
  for (const SideResult* side : {&run.reflected, &run.transmitted}) {
    within(side->total[0], "total");
    add(side->total[0]);
    for (const auto& order : side->orders) within(order[0], "order");
    for (const LobeEstimate& lobe : side->lobes)
      for (std::size_t k = 0; k < lobe.value.size(); ++k)
        EXPECT_TRUE(std::isfinite(lobe.value[k]) && std::isfinite(lobe.standard_error[k]));
  }
  for (const auto* part : {&run.uncollided, &run.absorbed, &run.unresolved}) {
    within((*part)[0], "ledger");
    add((*part)[0]);
  }
  add(run.thinned[0]);
  EXPECT_NEAR(sum, 1, 6 * error + 1e-9);
}

// Answers for every medium that a stack file takes; returns for how many.
int scan(const std::vector<double>& albedos, const std::vector<double>& depths, double tolerance,
         double seconds, int every) {
  int answers = 0, index = 0;
  for (const std::string& medium : all_media())
    for (const double albedo : albedos)
      for (const double depth : depths) {
        if (++index % every != 0) continue;
        const std::string toml = fmt::format("[[layer]]\n{}albedo = {}\nthickness = {}\n", medium,
                                             to_text(albedo), to_text(depth));
        SCOPED_TRACE(toml);
        TruthRequest request;
        try {
          request.stack = parse_stack(toml, "scan", "scan");
        } catch (const StackFileError&) {
          continue;  // a key that goes with another one
        }
        request.directions = {direction_from_degrees(0, 0), direction_from_degrees(45, 0),
                              direction_from_degrees(89.9, 0)};
        request.cells = {3, 4, false};
        request.tolerance = tolerance;
        request.effort.seconds = seconds;
        const auto start = std::chrono::steady_clock::now();
        GroundTruth truth(request, Estimator::analog);
        for (std::size_t k = 0; truth.goes_on(k); ++k) expect_physical(truth.find(k).run);
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        // The solver's trial, a pilot, and three directions, on a machine that does other things.
        EXPECT_LT(taken.count(), 60 + 3 * (5 * seconds + 5));
        ++answers;
      }
  return answers;
}

TEST(AutoScan, AnswersWithPhysicalNumbersInBoundedTime) {
  EXPECT_GE(scan({0, 1}, {1e-9, 1e9, kInfinity}, 1e-2, 0.02, 7), 20);
}

TEST(AutoScanSoak, AnswersWithPhysicalNumbersInBoundedTime) {
  if (!std::getenv("LAMELLA_SOAK")) GTEST_SKIP() << "an hour: set LAMELLA_SOAK";
  EXPECT_GE(scan({0, 1}, {1e-9, 1, 1e9, kInfinity}, 1e-4, 0.2, 1), 200);
}

}  // namespace
}  // namespace lamella
