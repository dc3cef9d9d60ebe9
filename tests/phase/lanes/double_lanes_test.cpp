// Lanes of double on every instruction set that the machine has, against the standard library.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/phase/lanes/lane_probe.h"

namespace lamella {
namespace {

class DoubleLanes : public ::testing::TestWithParam<Isa> {};

constexpr std::size_t kCount = 1 << 14;

struct Probed {
  std::vector<double> x, log, exp, cos, erf;
};

Probed probed(Isa isa, double from, double to) {
  Probed p;
  for (std::vector<double>* list : {&p.x, &p.log, &p.exp, &p.cos, &p.erf}) list->resize(kCount);
  for (std::size_t i = 0; i < kCount; ++i)
    p.x[i] = from + (to - from) * (static_cast<double>(i) + 0.5) / kCount;
  probe_double_math_for(isa)(p.x.data(), p.log.data(), p.exp.data(), p.cos.data(), p.erf.data(),
                             kCount);
  return p;
}

TEST_P(DoubleLanes, LogarithmAndExponentialKeepTheirStatedErrors) {
  for (const auto& [from, to] :
       {std::pair{-708.0, 709.0}, {-1.0, 1.0}, {0.999, 1.001}, {1e-150, 1e-149}, {1e-8, 1e-7}}) {
    const Probed p = probed(GetParam(), from, to);
    for (std::size_t i = 0; i < kCount; ++i) {
      const double e = std::exp(p.x[i]), l = std::log(std::abs(p.x[i]));
      EXPECT_NEAR(p.exp[i], e, 4e-16 * e) << p.x[i];
      EXPECT_NEAR(p.log[i], l, 4e-16 * std::abs(l)) << p.x[i];
    }
  }
  const Probed low = probed(GetParam(), -1e6, -709);
  for (const double e : low.exp) EXPECT_EQ(e, 0);
}

TEST_P(DoubleLanes, CosineAndErrorFunctionKeepTheirStatedErrors) {
  for (const double end : {0.01, 1.0, 8.0, 100.0}) {
    const Probed p = probed(GetParam(), -end, end);
    for (std::size_t i = 0; i < kCount; ++i) {
      EXPECT_NEAR(p.cos[i], std::cos(p.x[i]), 4e-16) << p.x[i];
      EXPECT_NEAR(p.erf[i], std::erf(p.x[i]), 9e-16) << p.x[i];
    }
  }
  const std::vector<double> x(16, -std::numeric_limits<double>::infinity());
  std::vector<double> log(16), exp(16), cos(16), erf(16);
  probe_double_math_for(GetParam())(x.data(), log.data(), exp.data(), cos.data(), erf.data(), 16);
  EXPECT_EQ(exp, std::vector<double>(16, 0.0));
  EXPECT_EQ(erf, std::vector<double>(16, -1.0));
}

TEST_P(DoubleLanes, AnglesKeepTheirStatedErrorFromZeroToPi) {
  std::vector<double> sine(kCount), cosine(kCount), angle(kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double t = M_PI * static_cast<double>(i) / (kCount - 1);
    sine[i] = std::sin(t);
    cosine[i] = std::cos(t);
  }
  // Next to the ends and the diagonals, where the cases meet.
  for (std::size_t i = 1; i < 16; ++i) {
    sine[i] = std::pow(0.1, static_cast<double>(10 * i));
    cosine[i] = i % 2 ? 1 : -1;
    sine[16 + i] = std::sqrt(0.5) * (1 + (static_cast<double>(i) - 8) * 1e-16);
    cosine[16 + i] = (i % 2 ? 1 : -1) * std::sqrt((1 - sine[16 + i]) * (1 + sine[16 + i]));
  }
  probe_angles_for(GetParam())(sine.data(), cosine.data(), angle.data(), kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double exact = std::atan2(sine[i], cosine[i]);
    EXPECT_NEAR(angle[i], exact, 5e-16 * exact) << sine[i] << ' ' << cosine[i];
  }
}

INSTANTIATE_TEST_SUITE_P(AllSets, DoubleLanes,
                         ::testing::ValuesIn(supported_isas().begin() + 1, supported_isas().end()),
                         [](const auto& isa) { return to_text(isa.param); });

}  // namespace
}  // namespace lamella
