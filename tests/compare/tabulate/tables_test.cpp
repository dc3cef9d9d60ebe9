// Series of functions whose coefficients are known.
#include "compare/tabulate/tables.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lamella {
namespace {

// p of Henyey and Greenstein's phase function; dot(w_i, w_o) is less the cosine of the deflection.
PairFunction henyey_greenstein(double g) {
  return [g](Direction wi, Direction wo) {
    const double c = -dot(wi, wo);
    return Rgb((1 - g) * (1 + g) / (4 * kPi * std::pow((1 - g) * (1 - g) + 2 * g * (1 - c), 1.5)));
  };
}

TEST(Tables, LegendreCoefficientsOfHenyeyGreensteinArePowers) {
  for (const double g : {0.0, 0.7, -0.5, 0.99, 0.9999}) {
    const NumberTable table = legendre_table(henyey_greenstein(g), 200);
    ASSERT_EQ(table.rows.size(), 200u);
    for (const std::vector<double>& row : table.rows) {
      // The cosine of a deflection of 1e-8 is 1: peaks keep 1e-16 / (1 - g)^2.
      const double rounding = 1e-12 + 2e-16 / ((1 - g) * (1 - g));
      EXPECT_NEAR(row[1], std::pow(g, row[0]), rounding) << g << ' ' << row[0];
      EXPECT_LT(row[2], rounding);
    }
  }
}

TEST(Tables, LegendreCoefficientsAreThoseOfParticlesAlone) {
  const PairFunction flake = [](Direction wi, Direction wo) { return Rgb(wi.z * wi.z * wo.z); };
  EXPECT_THROW((void)legendre_table(flake, 4), std::invalid_argument);
}

TEST(Tables, FourierCoefficientsOfATrigonometricPolynomialAreItsOwn) {
  const PairFunction f = [](Direction wi, Direction wo) {
    const double phi = std::atan2(wo.y, wo.x) - std::atan2(wi.y, wi.x);
    return Rgb(wi.z + wo.z * std::cos(phi) - 0.25 * std::cos(5 * phi), wo.z, 0.5 * std::cos(phi));
  };
  const NumberTable table = fourier_table(f, {0.5, 1.0 / 3}, {0.25, -0.75}, 6, true);
  ASSERT_EQ(table.rows.size(), 4u * 6u);
  EXPECT_EQ(table.columns.size(), 7u);
  for (const std::vector<double>& row : table.rows) {
    const double mi = row[0], mo = row[1];
    const int m = static_cast<int>(row[2]);
    EXPECT_NEAR(row[3], m == 0 ? mi : m == 1 ? mo / 2 : m == 5 ? -0.125 : 0, 1e-14);
    EXPECT_NEAR(row[4], m == 0 ? mo : 0, 1e-14);
    EXPECT_NEAR(row[5], m == 1 ? 0.25 : 0, 1e-14);
    EXPECT_LT(row[6], 1e-13);
  }
}

// Poisson's kernel (1 - q^2) / (1 + q^2 - 2 q cos phi) has the coefficients q^m.
TEST(Tables, FourierCoefficientsOfAPeakTakeAsManyPointsAsItAsks) {
  for (const double q : {0.5, 0.99, 0.999}) {
    const PairFunction f = [q](Direction wi, Direction wo) {
      const double s = 2 * std::sin((std::atan2(wo.y, wo.x) - std::atan2(wi.y, wi.x)) / 2);
      return Rgb((1 - q) * (1 + q) / ((1 - q) * (1 - q) + q * s * s));
    };
    for (const std::vector<double>& row : fourier_table(f, {0.5}, {0.5}, 32, false).rows)
      EXPECT_NEAR(row[3], std::pow(q, row[2]), 1e-11 + row[4]) << q;
  }
}

TEST(Tables, FourierCoefficientsAskForSymmetry) {
  const PairFunction turned = [](Direction wi, Direction wo) { return Rgb(2 + wi.x * wo.x); };
  const PairFunction one_sided = [](Direction wi, Direction wo) {
    return Rgb(2 + wi.x * wo.y - wi.y * wo.x);
  };
  EXPECT_THROW((void)fourier_table(turned, {0.5}, {0.5}, 4, false), std::invalid_argument);
  EXPECT_THROW((void)fourier_table(one_sided, {0.5}, {0.5}, 4, false), std::invalid_argument);
}

}  // namespace
}  // namespace lamella
