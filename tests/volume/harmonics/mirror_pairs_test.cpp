// What mirrors scatter twice, at pairs of directions and on cells: against the integral of the
// symmetric solver, quadrature that knows nothing of the kernels, reciprocity and turns.
#include "volume/harmonics/mirror_pairs.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/harmonics/beam_quadrature.h"
#include "volume/harmonics/circle_points.h"
#include "volume/harmonics/circle_sum_formulas.h"
#include "volume/harmonics/pair_cells.h"
#include "volume/harmonics/pair_field.h"
#include "volume/quadrature/depth_integrals.h"
#include "volume/quadrature/quadrature.h"
#include "volume/solver/second_order.h"

namespace lamella {
namespace {

std::string along(const std::string& medium, double x, double y, double z) {
  return fmt::format("{}\naxis = [{}, {}, {}]", medium, x, y, z);
}

// mu_i, mu_o and the azimuth between: both sides, grazing, beside and at the direction straight on.
constexpr std::array<double, 3> kHardPairs[] = {
    {0.7, 0.6, 1.0},   {0.7, 0.7, 3.14}, {0.7, -0.7, 3.1}, {0.7, -0.7, kPi}, {-0.3, 0.5, 2.0},
    {-0.4, -0.9, 0.3}, {1e-3, 0.5, 1.0}, {0.9, 1e-4, 2.0}, {0.02, 0.02, 3.0}};

TEST(CirclePoints, FindZerosInTheComplexPlane) {
  // |a - z|^2 |b - z|^2 with z = exp(i phi) has zeros at the azimuths of a and b, at distances
  // -log |a|, -log |b|.
  for (const auto& [ra, pa, rb, pb] :
       {std::array{0.9, 1.0, 0.5, -2.0}, std::array{0.999, 0.3, 0.99, 0.31},
        std::array{0.2, 3.0, 0.21, 3.1}, std::array{1 - 1e-6, -1.0, 0.3, 2.0}}) {
    // Coefficients of the product of 1 + r^2 - 2 r cos(phi - p).
    const double a0 = 1 + ra * ra, ac = -2 * ra * std::cos(pa), as = -2 * ra * std::sin(pa);
    const double b0 = 1 + rb * rb, bc = -2 * rb * std::cos(pb), bs = -2 * rb * std::sin(pb);
    std::vector<CircleZero> zeros;
    add_zeros(a0 * b0 + (ac * bc + as * bs) / 2, a0 * bc + ac * b0, a0 * bs + as * b0,
              (ac * bc - as * bs) / 2, (ac * bs + as * bc) / 2, zeros);
    ASSERT_EQ(zeros.size(), 2U);
    if (std::abs(std::remainder(zeros[0].phi - pa, 2 * kPi)) >
        std::abs(std::remainder(zeros[1].phi - pa, 2 * kPi)))
      std::swap(zeros[0], zeros[1]);
    for (const auto& [zero, r, p] : {std::tuple{zeros[0], ra, pa}, std::tuple{zeros[1], rb, pb}}) {
      EXPECT_NEAR(zero.distance / -std::log(r), 1, 0.05) << r;
      EXPECT_NEAR(std::remainder(zero.phi - p, 2 * kPi), 0, -0.05 * std::log(r)) << r;
    }
  }
}

// The integral of f(phi) over the panels.
template <class F>
double over(const CirclePanels& panels, const F& f) {
  const Quadrature& rule = cached_gauss_legendre(kCirclePoints);
  double sum = 0;
  for (int k = 0; k < panels.size(); ++k)
    for (int j = 0; j < kCirclePoints; ++j) {
      const double middle = std::atan2(panels.sines()[k], panels.cosines()[k]);
      sum += 2 * panels.halves()[k] * rule.weights[j] *
             f(middle + panels.halves()[k] * (2 * rule.points[j] - 1));
    }
  return sum;
}

TEST(CirclePanels, IntegrateWhatIsSteepAboutTheZeros) {
  CirclePanels panels;
  for (const double distance : {1.0, 0.1, 1e-3, 1e-6}) {
    std::vector<CircleZero> zeros;
    const double cosh = std::cosh(distance);
    add_zeros(cosh, -std::cos(2.5), -std::sin(2.5), zeros);
    ASSERT_EQ(zeros.size(), 1U);
    panels.place(zeros, 7);
    for (int k = 0; k < panels.size(); ++k) {
      EXPECT_LE(panels.halves()[k], kPi / 4 * (1 + 1e-15));
      EXPECT_NEAR(std::hypot(panels.cosines()[k], panels.sines()[k]), 1, 1e-14);
    }
    const double sum = over(panels, [&](double phi) { return 1 / (cosh - std::cos(phi - 2.5)); });
    // Halvings end, and cosh keeps few digits of a small distance.
    EXPECT_NEAR(sum * std::sinh(distance) / (2 * kPi), 1, distance > 1e-4 ? 3e-8 : 1e-4)
        << distance;
  }
}

// exp(-depth / mu) along a circle that crosses the horizon, against panels that shrink to the ends.
TEST(CirclePanels, IntegrateWhatIsSteepAtTheHorizon) {
  CirclePanels panels, fine;
  for (const double depth : {1.0, 0.1, 1e-3})
    for (const double end : {1.2, kPi / 2, 2.5}) {
      const auto f = [&](double phi) {
        const double mu = std::cos(phi) - std::cos(end);
        return std::exp(-depth / std::max(mu, 1e-300)) / (depth + mu);
      };
      panels.place_arc(-end, end, 0.12 * depth / std::sin(end), {}, 7);
      fine.place_arc(-end, end, 1e-3 * depth, {}, 0.02);
      const double exact = over(fine, f);
      EXPECT_NEAR(over(panels, f), exact, 3e-8 * exact) << depth << ' ' << end;
      EXPECT_LT(panels.size(), 60);
    }
}

// Their series and fractions against the integrals in double, from rates that nothing attenuates to
// ones that all do, equal and nearly equal ones among them.
TEST(CircleSum, HasTheIntegralsOverDepth) {
  for (const double depth : {0.01, 1.0, 30.0})
    for (double x = 1e-6; x < 1e3; x *= 3.7)
      for (const double ratio : {1.0, 1 + 1e-7, 1.02, 3.0, 300.0}) {
        const double y = ratio * x;
        const auto expect = [&](double found, double exact) {
          EXPECT_NEAR(found, exact, 1e-12 * exact) << depth << ' ' << x << ' ' << y;
        };
        expect(decays(x, depth), decay_integral(x, depth));
        expect(decays(x, y, depth), decay_integral(x, y, depth));
        expect(decays(y, x, depth), decay_integral(y, x, depth));
        expect(crosses(x, y, depth), crossing_integral(x, y, depth));
        expect(crosses(x, y, 2 * x, depth), crossing_integral(x, y, 2 * x, depth));
      }
}

// Where the stack is symmetric: roughness from 0.02 to 0.5, several layers, Schlick's factor, a
// half space, flakes with one side, both sides, grazing, beside and at the direction straight on.
TEST(MirrorPairs, AreThoseOfTheSymmetricSolver) {
  for (const std::string& toml :
       {layer(sggx(0.5, "mirror"), 0.9, 1), layer(sggx(0.1, "mirror"), 0.9, 1),
        layer(sggx(0.3, "mirror"), 0.9, 1e3),
        layer(sggx(0.2, "mirror"), 0.9, 0.5) +
            layer(sggx(0.4, "mirror") + "\nshape = \"fiber\"\naxis = [0, 0, 1]\nf0 = 0.2", 0.8, 2) +
            layer(sggx(0.6, "lambert"), 0.8, 0.3),
        layer(vmf(0.2, "mirror"), 0.9, kInfinity), layer(vmf(0.5, "mirror"), 0.9, 0.7)}) {
    const Stack stack = stack_of(toml);
    const SecondOrder expected(stack, 0);
    const MirrorPairs pairs(stack);
    for (const auto& [mu_i, mu_o, phi] : kHardPairs) {
      const Direction wi = direction_from_mu_phi(mu_i, 0.3),
                      wo = direction_from_mu_phi(mu_o, 0.3 + phi);
      const SecondOrder::Value f = expected(wi, wo, 1e-12);
      const double tolerance = 1e-6 * f.f;
      const MirrorPairs::Value found = pairs(wi, wo, tolerance);
      EXPECT_NEAR(found.f.r, f.f, 2e-7 * f.f + found.error + f.error)
          << toml << " mu " << mu_i << ' ' << mu_o;
      EXPECT_LE(found.error, 2 * tolerance) << toml << " mu " << mu_i << ' ' << mu_o;
    }
  }
}

// Axes that lean, a matrix with three eigenvalues and colour, against polar coordinates about the
// direction straight on, in which nothing is known of the second kernel's jump.
TEST(MirrorPairs, AreTheIntegralOfBothKernels) {
  const Stack stack = stack_of(
      layer(sggx(0.5, "mirror") + "\naxis = [0.4, 0.2, 1]\nf0 = [0.9, 0.5, 0.1]", 0.9, 0.8) +
      layer("medium = \"sggx\"\nmatrix = [0.3, 0.7, 1, 0.1, 0, -0.1]", 0.7, 1.3));
  const MirrorPairs pairs(stack);
  const Direction wi = direction_from_mu_phi(0.6, 0.2);
  for (const Direction wo : {direction_from_mu_phi(0.8, 2), direction_from_mu_phi(-0.5, 5)}) {
    Rgb sum;
    const BeamQuadrature about(-wi, 200, 600);
    const bool reflects = wo.z > 0;
    for (std::size_t n = 0; n < about.directions.size(); ++n) {
      const Direction w = about.directions[n];
      const bool onward = w.z < 0;
      struct Met {
        double a, b, c, depth, in = 0, out = 0;
        Rgb k1{}, k2{};
      };
      std::array<Met, 2> met{};
      for (int k = 0; k < 2; ++k) {
        const Layer& l = stack.layers[k];
        const auto kernel = [&](Direction from, Direction to) {
          const PhaseValue p = phase(l.medium, from, to);
          return sigma(l.medium, from) * p.density * (l.albedo * schlick(l.f0, p.schlick));
        };
        met[k] = {sigma(l.medium, wi) / wi.z, sigma(l.medium, -wo) / std::abs(wo.z),
                  sigma(l.medium, -w) / std::abs(w.z), l.depth()};
        met[k].k1 = kernel(wi, w);
        met[k].k2 = kernel(-w, wo);
      }
      met[1].in = met[0].a * met[0].depth;
      (reflects ? met[1].out : met[0].out) =
          reflects ? met[0].b * met[0].depth : met[1].b * met[1].depth;
      Rgb here;
      for (const Met& m : met) {
        const double both =
            onward ? (reflects ? decay_integral(m.a + m.b, m.b + m.c, m.depth)
                               : crossing_integral(m.a, m.c, m.b, m.depth))
                   : (reflects ? decay_integral(m.a + m.b, m.a + m.c, m.depth)
                               : crossing_integral(m.a, m.b, m.a + m.b + m.c, m.depth));
        here += std::exp(-m.in - m.out) * both * (m.k1 * m.k2);
      }
      const Met &first = met[onward ? 0 : 1], &second = met[onward ? 1 : 0];
      const double sent =
          std::exp(-first.in) * (onward ? crossing_integral(first.a, first.c, first.depth)
                                        : decay_integral(first.a + first.c, first.depth));
      const double seen =
          std::exp(-second.out) * (onward == reflects
                                       ? decay_integral(second.b + second.c, second.depth)
                                       : crossing_integral(second.c, second.b, second.depth));
      here += sent * seen * (first.k1 * second.k2);
      sum += about.weights[n] / std::abs(w.z) * here;
    }
    sum = 1 / (wi.z * std::abs(wo.z)) * sum;
    const MirrorPairs::Value found = pairs(wi, wo, 1e-9);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found.f[c] / sum[c], 1, 3e-5) << c << ' ' << wo.z;
  }
}

TEST(MirrorPairs, AreReciprocalAndTurnWithTheStack) {
  const auto stack_at = [](double turn) {
    const double c = std::cos(turn), s = std::sin(turn);
    return stack_of(layer(along(sggx(0.1, "mirror") + "\nshape = \"fiber\"", c, s, 0.3), 0.9, 1) +
                    layer(along(sggx(0.3, "mirror"), -s, c, 1), 0.8, 0.5));
  };
  const Stack stack = stack_at(0), turned = stack_at(1);
  const MirrorPairs pairs(stack), of_turned(turned);
  for (const auto& [mu_i, mu_o, phi] : {std::array{0.7, 0.4, 1.0}, std::array{0.2, -0.6, 2.5}}) {
    const Direction wi = direction_from_mu_phi(mu_i, 0.3), wo = direction_from_mu_phi(mu_o, phi);
    const double there = pairs(wi, wo, 1e-9).f.r;
    EXPECT_NEAR(pairs(wo, wi, 1e-9).f.r / there, 1, 1e-7);
    EXPECT_NEAR(
        of_turned(direction_from_mu_phi(mu_i, 1.3), direction_from_mu_phi(mu_o, phi + 1), 1e-9)
                .f.r /
            there,
        1, 1e-7);
  }
}

// On lanes as with doubles.
// Circles about the axis of the flakes and about the normal place other points: thin and thick
// layers, flakes that lie or lean, two layers that share an axis with one that has none and one
// that only attenuates, grazing, beside and at the direction straight on.
TEST(MirrorPairs, AreTheSameWithCirclesAboutTheAxis) {
  const auto flakes = [](double roughness, const std::string& shape) {
    return sggx(roughness, "mirror") + "\nshape = \"" + shape + "\"";
  };
  for (const std::string& toml :
       {layer(along(flakes(0.1, "fiber"), 1, 0, 0), 0.9, 1),
        layer(along(flakes(0.3, "fiber"), 1, 0.3, 0.5), 0.9, 30),
        layer(along(flakes(0.1, "surface"), 1, 0.3, 0.5), 0.9, 0.01),
        layer(along(flakes(0.5, "surface"), 0.1, 0, 1) + "\nf0 = 0.3", 0.9, kInfinity),
        layer(along(vmf(0.3, "mirror"), 0.5, 0.2, 1), 0.9, 1),
        layer(along(flakes(0.2, "fiber"), 0, 1, 0), 0.9, 1) +
            layer(along(flakes(0.4, "fiber"), 0, -1, 0), 0.7, 0.5) +
            layer(flakes(1, "fiber"), 0.8, 0.3) +
            layer(along(sggx(0.3, "lambert"), 1, 0, 1), 0.8, 0.3)}) {
    const Stack stack = stack_of(toml);
    const Isa isa = supported_isas().back();
    const MirrorPairs about_normal(stack, isa, MirrorCircles::about_normal), pairs(stack, isa);
    ASSERT_FALSE(pairs.layers().about_normal) << toml;
    ASSERT_TRUE(about_normal.layers().about_normal);
    for (const auto& [mu_i, mu_o, phi] : kHardPairs) {
      const Direction wi = direction_from_mu_phi(mu_i, 0.3),
                      wo = direction_from_mu_phi(mu_o, 0.3 + phi);
      const double scale = about_normal(wi, wo, 1e-4).f.r;
      // Light that crosses a half space, or thirty times the free path at grazing.
      if (scale < 1e-12) continue;
      const double tolerance = 1e-6 * scale;
      const MirrorPairs::Value expected = about_normal(wi, wo, tolerance);
      const MirrorPairs::Value found = pairs(wi, wo, tolerance);
      EXPECT_NEAR(found.f.r, expected.f.r, 1e-7 * scale + found.error + expected.error)
          << toml << " mu " << mu_i << ' ' << mu_o;
      EXPECT_LE(found.error, 2 * tolerance) << toml << " mu " << mu_i << ' ' << mu_o;
    }
  }
}

TEST(MirrorPairs, AreTheSameOnLanes) {
  const Stack stack =
      stack_of(layer(along(sggx(0.2, "mirror"), 0.3, 0.1, 1) + "\nf0 = [0.9, 0.5, 0.1]", 0.9, 0.1) +
               layer(along(vmf(0.4, "mirror"), 0.1, 0, 1), 0.9, 2) + layer(kSphere, 0.9, 0.4));
  const MirrorPairs reference(stack);
  for (const Isa isa : supported_isas()) {
    const MirrorPairs pairs(stack, isa);
    for (const double mu : {0.5, -0.4}) {
      const Direction wi = direction_from_mu_phi(0.6, 0), wo = direction_from_mu_phi(mu, 2.5);
      const Rgb a = reference(wi, wo, 1e-10).f, b = pairs(wi, wo, 1e-10).f;
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(b[c] / a[c], 1, 1e-10) << to_text(isa);
    }
  }
}

// Means over cells within their bounds of a product rule that is far finer than the cells.
TEST(PairCells, AreMeansWithinTheirBounds) {
  const Stack stack =
      stack_of(layer(along(sggx(0.4, "mirror") + "\nshape = \"fiber\"", 1, 0, 0), 0.9, 1));
  const MirrorPairs pairs(stack, supported_isas().back());
  const CellGrid grid{8, 16};
  const Direction wi = direction_from_degrees(45, 20);
  const std::vector<int> cells{0, 38, 120};
  for (const bool up : {true, false}) {
    const auto means = pair_cells(pairs, grid, wi, up, cells,
                                  std::vector<Rgb>(grid.rows(), Rgb(1e-4)), 0.4, nullptr);
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const int row = cells[k] / grid.columns(), column = cells[k] % grid.columns();
      const double low = std::sqrt(std::asin(grid.edge_mu(row + 1))),
                   high = std::sqrt(std::asin(grid.edge_mu(row)));
      const Quadrature& rule = cached_gauss_legendre(8);
      double sum = 0, weights = 0;
      for (int a = 0; a < 8; ++a)
        for (int b = 0; b < 8; ++b) {
          const double t = low + (high - low) * rule.points[a], e = t * t;
          const double weight = rule.weights[a] * rule.weights[b] * t * std::sin(e) * std::cos(e);
          const double phi =
              azimuth(wi) + grid.edge_phi(column) + grid.edge_phi(1) * rule.points[b];
          weights += weight;
          sum += weight *
                 pairs(wi, direction_from_mu_phi(up ? std::sin(e) : -std::sin(e), phi), 1e-6).f.r;
        }
      ASSERT_TRUE(means[k]);
      // The polynomial's, and half as much for its values.
      EXPECT_LE(means[k]->error.r, 1.5e-4);
      EXPECT_NEAR(means[k]->value.r, sum / weights, means[k]->error.r + 2e-6) << cells[k] << up;
    }
  }
  const std::atomic<bool> stop{true};
  EXPECT_FALSE(
      pair_cells(pairs, grid, wi, true, {3}, std::vector<Rgb>(8, Rgb(1e-3)), 0.4, &stop)[0]);
}

// All cells of a side come from one field, few of them from blocks of their own.
TEST(PairCells, AreTheSameFromAFieldAndFromBlocks) {
  const Stack stack =
      stack_of(layer(along(sggx(0.4, "mirror") + "\nshape = \"fiber\"", 1, 0, 0.4), 0.9, 1));
  const MirrorPairs pairs(stack, supported_isas().back());
  const CellGrid grid{4, 16};
  const Direction wi = direction_from_degrees(50, 20);
  const std::vector<Rgb> tolerance(grid.rows(), Rgb(2e-5));
  std::vector<int> all;
  for (int k = 0; k < grid.cells(); ++k) all.push_back(k);
  const std::vector<int> few{3, 17, 40, 56, 63};
  for (const bool up : {true, false}) {
    EXPECT_TRUE(expected_seconds(pairs, grid, wi, up, all, tolerance, 1e-3, 0.4));
    EXPECT_FALSE(expected_seconds(pairs, grid, wi, up, few, tolerance, 1e-3, 0.4));
    const auto field = pair_cells(pairs, grid, wi, up, all, tolerance, 0.4, nullptr);
    const auto blocks = pair_cells(pairs, grid, wi, up, few, tolerance, 0.4, nullptr);
    for (std::size_t k = 0; k < few.size(); ++k) {
      const CellMean &a = *field[few[k]], &b = *blocks[k];
      EXPECT_NEAR(a.value.r, b.value.r, a.error.r + b.error.r) << few[k] << up;
      EXPECT_LE(a.error.r, 3e-5);
      EXPECT_GT(a.value.r, 1e-4);
    }
  }
}

// Flakes that lie or lean, seen from both sides, with and without planes of symmetry: at random
// directions and at the edges of parts.
// Albedos that are multiples of one colour share a channel; others do not.
TEST(MirrorPairs, AreThoseOfEachChannelAlone) {
  const std::string first = along(sggx(0.4, "mirror"), 1, 0, 0.2) + "\nthickness = 1\nalbedo = ";
  const std::string second = along(sggx(0.6, "mirror"), 0, 1, 0) + "\nthickness = 2\nalbedo = ";
  const auto stack = [&](const std::string& a, const std::string& b) {
    return stack_of("[[layer]]\n" + first + a + "\n[[layer]]\n" + second + b + "\n");
  };
  const Direction wi = direction_from_mu_phi(0.6, 0.3);
  const auto value = [&](const Stack& s, Direction wo) {
    return MirrorPairs(s, supported_isas().back())(wi, wo, 1e-9).f;
  };
  for (const bool shares : {true, false}) {
    const std::array<std::string, 3> upper{"0.9", "0.45", "0.1"};
    const std::array<std::string, 3> lower =
        shares ? std::array<std::string, 3>{"0.45", "0.225", "0.05"}
               : std::array<std::string, 3>{"0.2", "0.9", "0.4"};
    const Stack coloured = stack(fmt::format("[{}]", fmt::join(upper, ", ")),
                                 fmt::format("[{}]", fmt::join(lower, ", ")));
    for (const Direction wo : {direction_from_mu_phi(0.5, 2), direction_from_mu_phi(-0.7, 1)}) {
      const Rgb all = value(coloured, wo);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(all[c] / value(stack(upper[c], lower[c]), wo)[c], 1, 1e-6) << shares << c;
    }
  }
}

TEST(PairField, IsWhatMirrorsScatterTwice) {
  struct Case {
    std::string medium;
    double phi;
    bool up;
  };
  for (const auto& [medium, phi, up] :
       {Case{along(sggx(0.4, "mirror") + "\nshape = \"fiber\"", 1, 0, 0), 0.3, true},
        Case{along(sggx(0.3, "mirror") + "\nshape = \"fiber\"", 1, 0, 0), 0, false},
        Case{along(sggx(0.4, "mirror") + "\nshape = \"fiber\"", 0, 1, 0), 0, true},
        Case{along(sggx(0.4, "mirror"), 0.5, 0.2, 1), 0.3, true},
        Case{along(sggx(0.4, "mirror"), -0.5, 0.2, -1), 0.3, false}}) {
    const Stack stack = stack_of(layer(medium, 0.9, 1));
    const MirrorPairs pairs(stack, supported_isas().back());
    ASSERT_TRUE(PairField::applies(pairs));
    const Direction wi = direction_from_mu_phi(0.6, phi);
    constexpr double kTolerance = 1e-5;
    const PairField field(
        pairs, wi, up, [](double) { return kTolerance; }, nullptr);
    ASSERT_TRUE(field.is_whole());
    EXPECT_GT(field.parts(), 4);
    // The number of values that was expected is right within a factor of 5.
    const double expected = PairField::expected_pairs(pairs, wi, kTolerance / 0.05, 0.4);
    EXPECT_GT(5 * PairField::kValuesOfPart * field.parts(), expected) << medium;
    EXPECT_LT(PairField::kValuesOfPart * field.parts(), 5 * expected) << medium;
    std::mt19937_64 draw(7);
    std::uniform_real_distribution<double> uniform;
    for (int k = 0; k < 60; ++k) {
      const double mu = std::sqrt(uniform(draw));
      const Direction wo =
          k == 0 ? Direction{-wi.x, -wi.y, up ? wi.z : -wi.z}
                 : direction_from_mu_phi(up ? mu : -mu, k < 20 ? 0.3 * k : 2 * kPi * uniform(draw));
      const PairField::Value found = field.at(wo);
      EXPECT_LE(found.error, 2 * kTolerance);
      // Polynomials are held against f at nine places: between those they may be off by more.
      EXPECT_NEAR(found.f.r, pairs(wi, wo, 1e-8).f.r, 3 * kTolerance) << medium << ' ' << k;
    }
  }
}

TEST(PairField, EndsWhereItIsStopped) {
  const Stack stack = stack_of(layer(along(sggx(0.4, "mirror"), 1, 0, 0), 0.9, 1));
  const MirrorPairs pairs(stack);
  const std::atomic<bool> stop = true;
  const PairField field(
      pairs, {0, 0.6, 0.8}, true, [](double) { return 1e-6; }, &stop);
  EXPECT_FALSE(field.is_whole());
}

}  // namespace
}  // namespace lamella
