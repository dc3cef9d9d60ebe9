// Cells and ledger of the deterministic solver: against brute-force quadrature of its own values,
// against closed forms, and against themselves under refinement.
#include "volume/solver/deterministic_run.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "phase/interface/dielectric.h"
#include "phase/stack/single_scattering.h"
#include "phase/stack/stack_file.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/quadrature/cell_quadrature.h"
#include "volume/quadrature/quadrature.h"
#include "volume/solver/closed_cells.h"
#include "volume/solver/closed_orders.h"

namespace lamella {
namespace {

std::vector<RunResult> runs_of(const Stack& stack, const std::vector<Direction>& incident,
                               CellGrid grid, double tolerance) {
  return deterministic_runs(solve_deterministic(stack, {.tolerance = 0.7 * tolerance}),
                            make_plan(stack), incident, grid, tolerance);
}

double lobe_energy(const RunResult& run, const SideResult& side, int lobe, int channel) {
  double sum = 0;
  const std::size_t cells = run.grid.cells();
  for (std::size_t k = 0; k < cells; ++k) sum += side.lobes[lobe].value[channel * cells + k];
  return run.grid.projected_solid_angle() * sum;
}

TEST(CellQuadrature, OfAPolynomialIsItsMean) {
  const CellMean mean = cell_mean([](double mu, double phi) { return Rgb(mu * phi, 1, mu * mu); },
                                  {0.25, 0.75, 1, 3}, Rgb(1e-9), {});
  EXPECT_NEAR(mean.value.r, 2 * (0.75 * 0.75 * 0.75 - 0.25 * 0.25 * 0.25) / 3 * 2 / 0.5, 1e-9);
  EXPECT_NEAR(mean.value.g, 1, 1e-9);
  EXPECT_NEAR(mean.value.b, (std::pow(0.75, 4) - std::pow(0.25, 4)) / 4 * 2 / 0.5, 1e-9);
  EXPECT_FALSE(mean.exhausted);
}

TEST(CellQuadrature, MeetsItsToleranceAtAPeakNarrowerThanTheCell) {
  // A Gaussian of width 1e-3 in the corner, far below what 16 points would see.
  const auto peak = [](double mu, double phi) {
    const double a = (mu - 0.5) / 1e-3, b = phi / 1e-3;
    return Rgb(std::exp(-a * a - b * b));
  };
  const CellMean mean = cell_mean(peak, {0.5, 0.6, 0, 0.2}, Rgb(1e-9), {{0.5, 0}});
  // A quarter of the peak: the weight mu adds (0.5 pi + sqrt(pi) 1e-3) / 4 in units of the width.
  const double integral = 1e-6 * (0.5 * kPi / 4 + 1e-3 * std::sqrt(kPi) / 4);
  const double size = (0.36 - 0.25) / 2 * 0.2;
  EXPECT_NEAR(mean.value.r, integral / size, 1e-9);
  EXPECT_FALSE(mean.exhausted);
}

TEST(CellQuadrature, EndsItsPartsAtRoots) {
  // The root of a distance on one side, within the cell, at its edges, and beside another.
  for (const double kink : {0.5, 0.5734, 0.6}) {
    const auto f = [&](double mu, double) {
      return Rgb(std::sqrt(std::max(0.0, mu - kink)), 1, 1);
    };
    const CellMean mean = cell_mean(f, {0.5, 0.6, 0, 0.2}, Rgb(1e-10), {{0.55, 0.1}}, {0.3, kink});
    // Of sqrt(x) (x + kink) over x from 0 to 0.6 - kink.
    const double x = 0.6 - kink;
    const double integral = std::pow(x, 2.5) * 2 / 5 + kink * std::pow(x, 1.5) * 2 / 3;
    EXPECT_NEAR(mean.value.r, integral / ((0.36 - 0.25) / 2), 1e-10) << kink;
    EXPECT_NEAR(mean.value.g, 1, 1e-10) << kink;
    EXPECT_FALSE(mean.exhausted);
  }
}

TEST(CellQuadrature, SaysWhereItGaveUp) {
  // A slanted edge: halving both ways gains a factor of 2 for twice the parts.
  const CellMean mean =
      cell_mean([](double mu, double phi) { return Rgb(mu + 0.3 * phi < 0.57 ? 1 : 0); },
                {0.5, 0.6, 0, 0.2}, Rgb(1e-12), {});
  EXPECT_TRUE(mean.exhausted);
  EXPECT_GT(mean.error.r, 1e-12);
}

// Narrow lobes of facets near grazing are ridges along the plane of incidence. In the slopes of
// their facets they are Gaussian, and the rectangle rule is exact.
TEST(ClosedCells, HoldTheWholeLobeOfNarrowFacets) {
  for (const double alpha : {0.2, 0.05, 0.01, 1e-4})
    for (const double theta : {0.0, 30.0, 80.0, 88.0}) {
      const Stack stack =
          parse_stack(fmt::format("[[layer]]\ninterface = 'beckmann'\nior = 1.5\nroughness = {}\n"
                                  "[substrate]\nalbedo = 0.5\n",
                                  alpha),
                      "test", "test");
      const Dielectric facets{.facets = {FacetShape::beckmann, alpha, alpha}, .below = 1.5};
      const Direction wi = direction_from_degrees(theta, 20);
      constexpr int kSteps = 700;
      const double step = 2 * 7 * alpha / kSteps;
      double energy = 0;
      for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
          const double x = (i + 0.5) * step - 7 * alpha, y = (j + 0.5) * step - 7 * alpha;
          const double z = 1 / std::sqrt(1 + x * x + y * y);
          const Direction h{x * z, y * z, z};
          const double c = dot(wi, h);
          const Direction wo{2 * c * h.x - wi.x, 2 * c * h.y - wi.y, 2 * c * h.z - wi.z};
          if (c <= 0 || wo.z <= 0) continue;
          energy += facets.single(wi, wo) * wo.z * 4 * c * z * z * z * step * step;
        }
      for (const CellGrid grid : {CellGrid{1, 1, false}, CellGrid{3, 6, false}}) {
        const std::vector<CellMean> cells =
            closed_cells(stack, grid, wi, true, std::vector<Rgb>(grid.rows(), Rgb(1e-4)),
                         [&](Direction wo) { return closed_orders(stack, wi, wo).zero; });
        double sum = 0, error = 0;
        for (const CellMean& cell : cells) {
          sum += cell.value.r * grid.projected_solid_angle();
          error += cell.error.r * grid.projected_solid_angle();
        }
        // The rectangles end where light no longer leaves: an edge of the integrand, at 80 and 88.
        EXPECT_NEAR(sum, energy, error + 2e-4 * energy) << alpha << ' ' << theta;
        EXPECT_LT(error, 1e-3);
      }
    }
}

// Every cell of every order against tensor quadrature of the solver's own values at points.
TEST(DeterministicRun, CellsAreTheMeansOfTheValuesAtPoints) {
  const Stack stack = stack_of(layer(sggx(0.5, "lambert"), 0.9, 1.5));
  const CellGrid grid{4, 8, false};
  const std::vector<Direction> incident{direction_from_degrees(50, 20),
                                        direction_from_degrees(120, 0)};
  const DeterministicSolution solution = solve_deterministic(stack, {.tolerance = 1e-6});
  const std::vector<RunResult> runs =
      deterministic_runs(solution, make_plan(stack), incident, grid, 1e-6);
  constexpr int kPoints = 24, kAzimuths = 10;
  const Quadrature rule = gauss_legendre(kPoints), around = gauss_legendre(kAzimuths);
  for (std::size_t i = 0; i < incident.size(); ++i) {
    const double mu_i[] = {incident[i].z};
    for (const bool reflected : {true, false}) {
      const SideResult& side = reflected ? runs[i].reflected : runs[i].transmitted;
      const double sign = (incident[i].z > 0) == reflected ? 1 : -1;
      for (int row = 0; row < grid.rows(); ++row) {
        // In the elevation, mu = sin e, cubed at grazing: no singularity is left.
        const double e0 = std::asin(grid.edge_mu(row + 1)), e1 = std::asin(grid.edge_mu(row));
        std::vector<double> mu_o, weight_of;
        for (int a = 0; a < kPoints; ++a) {
          const double x = rule.points[a];
          const double e = e0 == 0 ? e1 * x * x * x : e0 + (e1 - e0) * x;
          const double slope = e0 == 0 ? 3 * e1 * x * x : e1 - e0;
          mu_o.push_back(sign * std::sin(e));
          weight_of.push_back(rule.weights[a] * slope * std::sin(e) * std::cos(e) * 2 *
                              grid.mu_cells);
        }
        const DeterministicField field = solution.field(mu_i, mu_o);
        for (int column = 0; column < runs[i].grid.columns(); ++column) {
          std::array<double, kSolvedOrders> mean{};
          for (int a = 0; a < kPoints; ++a)
            for (int b = 0; b < kAzimuths; ++b) {
              const double phi = (column + around.points[b]) * 2 * kPi / grid.phi_cells;
              const double weight = weight_of[a] * around.weights[b];
              const SingleScattering single = single_scattering(
                  stack, incident[i], direction_from_mu_phi(mu_o[a], azimuth(incident[i]) + phi));
              DeterministicValue f = field.multiple(0, a, kPi - phi);
              f.order[0] = single.layers + single.substrate;
              f.order[Order::all] += f.order[0];
              for (int o = 0; o < kSolvedOrders; ++o) mean[o] += weight * f.order[o].r;
            }
          const int columns = runs[i].grid.columns();
          double over_azimuth = 0;  // what tolerances are relative to
          for (int k = 0; k < columns; ++k)
            over_azimuth += side.lobes[4].value[row * columns + k] / columns;
          // A tenth of the tolerance for each of the two quadratures.
          for (int o = 0; o < kSolvedOrders; ++o)
            EXPECT_NEAR(side.lobes[o].value[row * columns + column], mean[o], 2e-7 * over_azimuth)
                << "row " << row << ", column " << column << ", lobe " << o;
        }
      }
    }
  }
}

TEST(DeterministicRun, ErrorBoundsHoldAgainstAFinerSolution) {
  for (const std::string& medium : {kSphere, henyey_greenstein(0.6), sggx(0.5, "lambert")})
    for (const double thickness : {0.5, kInfinity}) {
      if (thickness == kInfinity && medium != kSphere) continue;
      const Stack stack = stack_of(layer(medium, 0.9, thickness));
      const std::vector<Direction> incident{direction_from_degrees(0, 0),
                                            direction_from_degrees(60, 0),
                                            direction_from_degrees(88, 0)};
      const auto coarse = runs_of(stack, incident, {6, 8, false}, 1e-4);
      const auto fine = runs_of(stack, incident, {6, 8, false}, 2e-6);
      for (std::size_t i = 0; i < incident.size(); ++i) {
        EXPECT_TRUE(fine[i].accuracy->reached) << medium;
        EXPECT_LE(fine[i].accuracy->error, 2e-6);
        for (const bool reflected : {true, false}) {
          const SideResult& a = reflected ? coarse[i].reflected : coarse[i].transmitted;
          const SideResult& b = reflected ? fine[i].reflected : fine[i].transmitted;
          for (int o = 0; o <= kTallyOrders; ++o)
            for (std::size_t k = 0; k < a.lobes[o].value.size(); ++k)
              EXPECT_LE(std::abs(a.lobes[o].value[k] - b.lobes[o].value[k]),
                        a.lobes[o].standard_error[k] + b.lobes[o].standard_error[k])
                  << medium << ", lobe " << o << ", cell " << k;
        }
      }
    }
}

// The two layers of SpongeCake's figure 7, by the commands' share of the tolerance: the solver is
// content with nodes that are too few for order 2 of the mirrors, which it integrates at points.
TEST(DeterministicRun, CellsOfMirrorsReachTheToleranceThatTheSolverReaches) {
  const Stack stack =
      stack_of(layer(sggx(0.5, "mirror"), 0.9, 0.5) + layer(sggx(0.9, "mirror"), 0.9, 2));
  const std::vector<Direction> incident{direction_from_degrees(30, 0),
                                        direction_from_degrees(80, 0)};
  const CellGrid grid{4, 8, false};
  const Plan plan = make_plan(stack);
  const DeterministicSolution solution = solve_deterministic(stack, {.tolerance = 5e-7});
  ASSERT_TRUE(solution.accuracy().reached);
  ASSERT_GT(solution.accuracy().second_error, 2e-6);
  const std::vector<RunResult> runs = deterministic_runs(solution, plan, incident, grid, 1e-6);
  // At 1e-6 it is the modes that hold order 2, on more nodes.
  const std::vector<RunResult> other = deterministic_runs(
      solve_deterministic(stack, {.tolerance = 1e-6, .min_nodes = 24, .max_nodes = 32}), plan,
      incident, grid, 1e-6);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    EXPECT_TRUE(runs[i].accuracy->reached) << runs[i].accuracy->error;
    for (const bool reflected : {true, false}) {
      const SideResult& a = reflected ? runs[i].reflected : runs[i].transmitted;
      const SideResult& b = reflected ? other[i].reflected : other[i].transmitted;
      for (int o = 0; o <= kTallyOrders; ++o)
        for (std::size_t k = 0; k < a.lobes[o].value.size(); ++k)
          EXPECT_NEAR(a.lobes[o].value[k], b.lobes[o].value[k],
                      a.lobes[o].standard_error[k] + b.lobes[o].standard_error[k]);
    }
  }
}

// Orders 2 and up of mirrors are steep about w_o = -w_i, where hundreds of modes hardly suffice at
// points: the cells that hold it are split there.
TEST(DeterministicRun, CellsOfMirrorsAboutStraightTransmissionReachTheTolerance) {
  const Stack stack = stack_of(layer(sggx(0.5, "mirror"), 0.9, 2));
  const std::vector<Direction> incident{direction_from_degrees(80, 0)};
  const CellGrid grid{8, 16, false};
  const auto coarse = runs_of(stack, incident, grid, 1e-4);
  const auto fine = runs_of(stack, incident, grid, 1e-6);
  EXPECT_TRUE(fine[0].accuracy->reached) << fine[0].accuracy->error;
  for (int o = 0; o <= kTallyOrders; ++o) {
    const LobeEstimate &a = coarse[0].transmitted.lobes[o], &b = fine[0].transmitted.lobes[o];
    for (std::size_t k = 0; k < a.value.size(); ++k)
      EXPECT_NEAR(a.value[k], b.value[k], a.standard_error[k] + b.standard_error[k])
          << "lobe " << o << ", cell " << k;
  }
}

// What is owed is the modes that a fit continues, by how far the fit is to be trusted.
TEST(DeterministicSoak, CellsOfMirrorsReachEightDigits) {
  if (!is_soak()) GTEST_SKIP() << "minutes: set LAMELLA_SOAK";
  const Stack stack = stack_of(layer(sggx(0.5, "mirror"), 0.9, 2));
  const std::vector<Direction> incident{direction_from_degrees(80, 0)};
  const CellGrid grid{8, 16, false};
  const Plan plan = make_plan(stack);
  const auto runs = [&](double tolerance) {
    const DeterministicSolution solution =
        solve_deterministic(stack, {.tolerance = kSolverShare * tolerance, .max_seconds = 3000});
    return deterministic_runs(solution, plan, incident, grid, tolerance).front();
  };
  const RunResult coarse = runs(1e-7), fine = runs(1e-8);
  EXPECT_LE(fine.accuracy->error, 1e-8);
  for (const bool reflected : {true, false})
    for (int o = 0; o <= kTallyOrders; ++o) {
      const LobeEstimate& a = (reflected ? coarse.reflected : coarse.transmitted).lobes[o];
      const LobeEstimate& b = (reflected ? fine.reflected : fine.transmitted).lobes[o];
      for (std::size_t k = 0; k < a.value.size(); ++k)
        EXPECT_NEAR(a.value[k], b.value[k], a.standard_error[k] + b.standard_error[k])
            << "lobe " << o << ", cell " << k;
    }
}

TEST(DeterministicRun, TheLedgerClosesAndTheCellsHoldItsEnergies) {
  const Stack stacks[] = {
      stack_of(layer(vmf(0.5, "lambert"), 1, 1.5)), stack_of(layer(kSphere, 1, kInfinity)),
      stack_of(layer(henyey_greenstein(0.5), 0.8, 1) + layer(sggx(0.4, "lambert"), 0.9, 0.5) +
               lambert_ground(0.3)),
      stack_of(
          "[[layer]]\nmedium = \"lambert_sphere\"\nalbedo = [0.9, 0.5, 0.2]\nthickness = 2\n")};
  for (const Stack& stack : stacks) {
    const std::vector<Direction> incident{direction_from_degrees(30, 0)};
    const RunResult run = runs_of(stack, incident, {8, 8, false}, 1e-6)[0];
    EXPECT_EQ(run.walks, 0u);
    EXPECT_EQ(run.estimator, Estimator::deterministic);
    for (int c = 0; c < run.channels; ++c) {
      EXPECT_NEAR(ledger_sum(run, c), 1, 1e-10);
      EXPECT_EQ(run.unresolved[c].value, 0);
      for (const SideResult* side : {&run.reflected, &run.transmitted}) {
        double orders = 0;
        for (int o = 0; o < kTallyOrders; ++o) orders += side->orders[o][c].value;
        EXPECT_NEAR(orders, side->total[c].value, 1e-14);
        if (side->lobes[0].value.empty()) continue;
        // Cells and nodes integrate over directions apart from each other.
        for (int o = 0; o <= kTallyOrders; ++o) {
          const Estimate& e = o < kTallyOrders ? side->orders[o][c] : side->total[c];
          EXPECT_NEAR(lobe_energy(run, *side, o, c), e.value, 2e-6 * side->total[c].value + 1e-14);
          EXPECT_LE(e.standard_error, 3e-6 * side->total[c].value + 1e-14) << "lobe " << o;
        }
      }
    }
  }
}

TEST(DeterministicRun, LightLostToTheDepthCountsAsTransmittedByOrder) {
  const Stack stack = stack_of(layer(vmf(0.3, "lambert") + "\naxis = [0, 0, -1]", 1, kInfinity));
  const DeterministicSolution solution =
      solve_deterministic(stack, {.tolerance = 1e-2, .min_nodes = 12, .max_nodes = 12});
  const std::vector<Direction> incident{direction_from_mu_phi(0.7, 0)};
  const RunResult run =
      deterministic_runs(solution, make_plan(stack), incident, {4, 8, false}, 1e-2)[0];
  EXPECT_GT(run.transmitted.total[0].value, 0.1);
  EXPECT_TRUE(run.transmitted.lobes[0].value.empty());
  double orders = 0;
  for (int o = 0; o < kTallyOrders; ++o) orders += run.transmitted.orders[o][0].value;
  EXPECT_NEAR(orders, run.transmitted.total[0].value, 1e-12);
  EXPECT_NEAR(ledger_sum(run, 0), 1, 1e-10);
}

// More rows than panels: polynomials serve several rows each.
TEST(DeterministicRun, ManyRowsAgreeWithFewOnes) {
  const Stack stack = stack_of(layer(kSphere, 0.9, kInfinity));
  const std::vector<Direction> incident{direction_from_degrees(60, 0)};
  const RunResult few = runs_of(stack, incident, {8, 4, false}, 1e-6)[0];
  const RunResult many = runs_of(stack, incident, {64, 4, false}, 1e-6)[0];
  for (int o = 0; o <= kTallyOrders; ++o)
    for (int row = 0; row < 8; ++row)
      for (int column = 0; column < few.grid.columns(); ++column) {
        double sum = 0;
        for (int part = 0; part < 8; ++part)
          sum += many.reflected.lobes[o].value[(8 * row + part) * few.grid.columns() + column] / 8;
        const double f = few.reflected.lobes[o].value[row * few.grid.columns() + column];
        EXPECT_NEAR(sum, f, 2e-7 * few.reflected.lobes[4].value[row * few.grid.columns() + column]);
      }
  EXPECT_TRUE(many.accuracy->reached);
}

}  // namespace
}  // namespace lamella
