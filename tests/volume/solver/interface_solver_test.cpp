#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numeric>

#include "phase/interface/dielectric.h"
#include "phase/surface/conductor.h"
#include "phase/surface/fresnel_formulas.h"
#include "tests/volume/run/stacks.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/quadrature/quadrature.h"
#include "volume/run/simulation.h"
#include "volume/solver/answer_check.h"
#include "volume/solver/deterministic.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

std::string interface(double ior, const std::string& kind = "smooth",
                      const std::string& more = "") {
  return fmt::format("[[layer]]\ninterface = \"{}\"\nior = {}\n{}\n", kind, ior, more);
}

std::string rough(double ior, double alpha, const std::string& kind = "ggx") {
  return interface(ior, kind, fmt::format("roughness = {}", alpha));
}

DeterministicSolution solved(const std::string& toml, double tolerance = 1e-8) {
  return solve_deterministic(stack_of(toml), {.tolerance = tolerance, .max_seconds = 100});
}

Direction up(double mu, double phi = 0) { return direction_from_mu_phi(mu, phi); }

DeterministicEnergies energies_of(const DeterministicSolution& s, double mu) {
  const double list[] = {mu};
  return s.energies(list).front();
}

// A smooth boundary of relative index n over an absorbing layer of depth tau over Lambert's ground,
// in closed form, its diffuse integrals by quadrature in pieces that end at the critical angle.
struct CoatedLambert {
  double n, tau, albedo, reflected_inside = 0, leaves = 0;

  CoatedLambert(double index, double depth, double rho) : n(index), tau(depth), albedo(rho) {
    const double critical = n > 1 ? std::sqrt((1 - 1 / n) * (1 + 1 / n)) : 0;
    const Quadrature& rule = cached_gauss_legendre(400);
    for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
      const double u = rule.points[k], w = rule.weights[k];
      const double mu = critical + (1 - critical) * u * u;
      const double reflectance = refraction(mu, 1 / n).reflectance;
      const double flux = 2 * mu * w * 2 * u * (1 - critical);
      reflected_inside += flux * reflectance * std::exp(-2 * tau / mu);
      leaves += flux * (1 - reflectance) * std::exp(-tau / mu);
      const double below = critical * u * u * u;
      if (below > 0)
        reflected_inside += 2 * below * w * critical * 3 * u * u * std::exp(-2 * tau / below);
    }
  }
  [[nodiscard]] double enters(double mu) const {
    const Refraction<double> r = refraction(mu, n);
    return (1 - r.reflectance) * std::exp(-tau / r.cosine);
  }
  [[nodiscard]] double f(double mu_i, double mu_o) const {
    return enters(mu_i) * enters(mu_o) * albedo / (kPi * n * n * (1 - albedo * reflected_inside));
  }
  [[nodiscard]] double reflects(double mu) const {
    return refraction(mu, n).reflectance +
           enters(mu) * albedo * leaves / (1 - albedo * reflected_inside);
  }
};

TEST(InterfaceSolver, SmoothOverLambertIsTheClosedForm) {
  for (const double n : {1.5, 3.0, 1.33})
    for (const double tau : {0.0, 0.3}) {
      const CoatedLambert exact(n, tau, 0.8);
      const DeterministicSolution s =
          solved(interface(n) + layer(kIsotropic, 0, tau) + lambert_ground(0.8), 1e-10);
      const std::string what = fmt::format("n {} tau {}", n, tau);
      for (const auto& [mu_i, mu_o] : {std::pair{0.6, 0.3}, {1.0, 0.9}, {0.05, 0.5}}) {
        const DeterministicValue v = s.f(up(mu_i), up(mu_o, 1));
        EXPECT_NEAR(v.order[Order::all].r / exact.f(mu_i, mu_o), 1, tau > 0 ? 2e-11 : 1e-12)
            << what;
        const double turn = 0.8 * exact.reflected_inside;
        EXPECT_NEAR(v.order[0].r / exact.f(mu_i, mu_o), 1 - turn, 1e-12) << what;
        EXPECT_NEAR(v.order[1].r / exact.f(mu_i, mu_o), (1 - turn) * turn, 1e-11) << what;
      }
      const DeterministicEnergies e = energies_of(s, 0.6);
      EXPECT_NEAR(e.reflected[Order::all].r, exact.reflects(0.6), tau > 0 ? 1e-11 : 1e-12) << what;
      EXPECT_NEAR(e.specular_of[Order::all].r, refraction(0.6, n).reflectance, 1e-15) << what;
      EXPECT_NEAR(e.sum().r, 1, 1e-13) << what;
    }
  // 1 - F_int = (1 - F_ext) / n^2.
  EXPECT_NEAR(CoatedLambert(1.5, 0, 1).reflected_inside, 0.5963, 5e-5);
}

TEST(InterfaceSolver, PublishedValuesAreFound) {
  const DeterministicSolution slab = solved(layer(henyey_greenstein(0.75), 0.9, 2));
  const DeterministicEnergies e = energies_of(slab, 1);
  EXPECT_NEAR(e.reflected[Order::all].r, 0.09739, 1e-5);
  EXPECT_NEAR(e.transmitted[Order::all].r + e.uncollided.r, 0.66096, 1e-5);
  // Giovanelli 1955, the mirror image included.
  const DeterministicSolution half = solved(interface(1.5) + layer(kIsotropic, 0.9, kInfinity));
  EXPECT_NEAR(energies_of(half, 1).reflected[Order::all].r, 0.2600, 1e-4);
}

TEST(InterfaceSolver, PlateWithNothingInsideSumsBounces) {
  const DeterministicSolution s = solved(interface(1.5) + interface(1.0));
  for (const double mu : {1.0, 0.5, 0.01, -0.3}) {
    const double r = refraction(std::abs(mu), 1.5).reflectance;
    const DeterministicEnergies e = energies_of(s, mu);
    EXPECT_NEAR(e.zero_reflected.r, 2 * r / (1 + r), 1e-14) << mu;
    EXPECT_NEAR(e.uncollided.r, (1 - r) / (1 + r), 1e-14) << mu;
  }
}

TEST(InterfaceSolver, IndexOneDoesNothing) {
  const std::string slab = layer(henyey_greenstein(0.5), 0.9, 1);
  const DeterministicSolution a = solved(slab, 1e-6), b = solved(interface(1) + slab, 1e-6);
  // Mode 0 of a layer by itself comes from eigenmodes, beside an interface from doubling, whose
  // start leaves 1e-11.
  EXPECT_NEAR(
      a.f(up(0.6), up(0.3, 1)).order[Order::all].r / b.f(up(0.6), up(0.3, 1)).order[Order::all].r,
      1, 1e-11);
  EXPECT_EQ(energies_of(a, 0.6).reflected[Order::all].r,
            energies_of(b, 0.6).reflected[Order::all].r);
}

TEST(InterfaceSolver, SmoothCoatsKeepReciprocityEnergyAndOrders) {
  for (const std::string& medium : {kIsotropic, henyey_greenstein(0.6), sggx(0.5, "lambert")}) {
    const DeterministicSolution s =
        solved(interface(1.5) + layer(medium, 0.95, 1.3) + interface(1.2), 1e-7);
    EXPECT_TRUE(s.accuracy().reached) << medium;
    const Direction a = up(0.6), b = up(0.35, 1.1), c = up(-0.7, 2);
    const DeterministicValue ab = s.f(a, b), ac = s.f(a, c), ca = s.f(c, a);
    EXPECT_NEAR(s.f(b, a).order[Order::all].r / ab.order[Order::all].r, 1, 1e-12);
    EXPECT_NEAR(ac.order[Order::all].r / (1.2 * 1.2) / ca.order[Order::all].r, 1, 1e-12);
    for (const DeterministicValue& v : {ab, ac, ca})
      EXPECT_NEAR((v.order[0] + v.order[1] + v.order[2] + v.order[3]).r / v.order[Order::all].r, 1,
                  1e-13);
    for (const double mu : {0.6, 1e-7, -0.6, -0.2}) {
      const DeterministicEnergies e = energies_of(s, mu);
      EXPECT_NEAR(e.sum().r, 1, 1e-11) << medium << " mu " << mu;
    }
  }
}

// Cells are integrals of their own: their sum is the energy of the nodes within their bounds, which
// are as small as asked, though f behaves like a root at the critical angle of a denser bottom.
TEST(InterfaceSolver, CellsAddUpToTheEnergyOfTheNodes) {
  constexpr double kTolerance = 1e-5;
  const std::string sand = layer(vmf(0.5, "lambert"), 1, 1);
  for (const std::string& toml :
       {interface(1.4) + sand, interface(1.4) + layer(sggx(0.3, "lambert"), 0.9, 0.5),
        interface(1.6) + sand + interface(1.3), interface(0.8) + sand + interface(1.2),
        interface(1.5) + layer(kIsotropic, 0.9, 1) + lambert_ground(0.5)}) {
    const Stack stack = stack_of(toml);
    std::vector<Direction> incident{direction_from_degrees(30, 0), direction_from_degrees(85, 0)};
    if (stack.is_open_below()) incident.push_back(direction_from_degrees(130, 40));
    const DeterministicSolution s = solve_deterministic(stack, {.tolerance = kTolerance / 2});
    for (const CellGrid grid : {CellGrid{8, 8, false}, CellGrid{3, 4, false}}) {
      const std::vector<RunResult> runs =
          deterministic_runs(s, make_plan(stack), incident, grid, kTolerance);
      for (std::size_t i = 0; i < runs.size(); ++i) {
        const double mu[] = {incident[i].z};
        const DeterministicEnergies nodes = s.energies(mu).front();
        for (const bool reflected : {true, false}) {
          const SideResult& side = reflected ? runs[i].reflected : runs[i].transmitted;
          const LobeEstimate& all = side.lobes[Order::all];
          if (all.value.empty()) continue;
          double sum = reflected ? nodes.specular_of[Order::all].r : 0, bound = 0;
          for (int k = 0; k < runs[i].grid.cells(); ++k) {
            sum += runs[i].grid.projected_solid_angle() * all.value[k];
            bound += runs[i].grid.projected_solid_angle() * all.standard_error[k];
          }
          const double energy =
              reflected ? nodes.reflected[Order::all].r : nodes.transmitted[Order::all].r;
          EXPECT_NEAR(sum, energy, bound + s.accuracy().node_error * energy)
              << toml << " direction " << i << (reflected ? " reflected" : " transmitted");
          EXPECT_LE(bound, 2 * kTolerance * energy + 1e-12) << toml << " direction " << i;
        }
      }
    }
  }
}

TEST(InterfaceSolver, SmoothHardCasesHaveFiniteNumbersAndKeepEnergy) {
  const double deep = 1e6;
  for (const std::string& toml :
       {interface(1.0001) + layer(kIsotropic, 1, 1) + interface(1),
        interface(3) + layer(kIsotropic, 1, 1) + interface(1),
        interface(0.7) + layer(kIsotropic, 0.9, 1) + lambert_ground(0.5),
        interface(1.5) + layer(kIsotropic, 1, deep) + interface(1),
        interface(1.5) + layer(kIsotropic, 1, 1e-9) + interface(1),
        interface(1.5) + layer(kIsotropic, 1, 0) + interface(1.3) + interface(1.5),
        interface(1.5) + interface(1) + interface(1.5)}) {
    const DeterministicSolution s = solved(toml, 1e-6);
    EXPECT_TRUE(s.accuracy().is_answer()) << toml;
    const bool open = s.stack().is_open_below();
    const double critical = std::sqrt(1 - 1 / 2.25);
    for (const double mu : {1.0, critical, 1e-7, 0.0, -1e-7, -critical, -1.0}) {
      if (mu < 0 && !open) continue;
      const DeterministicEnergies e = energies_of(s, with_grazing_limit(up(mu)).z);
      EXPECT_NEAR(e.sum().r, 1, 1e-9) << toml << " mu " << mu;
      const Direction wi = with_grazing_limit(up(mu));
      for (const double mu_o : {0.7, 1e-5, -critical, -0.3}) {
        if (mu_o < 0 && !open) continue;
        const DeterministicValue v = s.f(wi, up(mu_o, 2));
        EXPECT_TRUE(std::isfinite(v.order[Order::all].r) && std::isfinite(v.error.r)) << toml;
        EXPECT_GE(v.order[Order::all].r, -v.error.r - 1e-12) << toml;
      }
    }
  }
}

TEST(InterfaceSolver, SmoothConductorUnderACoatSumsBounces) {
  Stack stack =
      stack_of(interface(1.5) + "[substrate]\nbsdf = \"conductor\"\neta = 0.2\nk = 3.9\n");
  const Conductor metal(
      {.facets = {.shape = FacetShape::smooth}, .eta = Rgb(0.2 / 1.5), .k = Rgb(3.9 / 1.5)});
  stack.substrate->law = std::make_shared<Conductor>(metal);
  const DeterministicSolution s = solve_deterministic(stack, {.tolerance = 1e-8});
  for (const double mu : {1.0, 0.4}) {
    const Refraction<double> r = refraction(mu, 1.5);
    const double m = metal.reflectance(r.cosine).r, through = 1 - r.reflectance;
    const DeterministicEnergies e = energies_of(s, mu);
    EXPECT_NEAR(e.zero_reflected.r, r.reflectance, 1e-15);
    EXPECT_NEAR(e.reflected[0].r, through * through * m, 1e-14);
    EXPECT_NEAR(e.reflected[1].r, through * through * m * m * r.reflectance, 1e-14);
    EXPECT_NEAR(e.reflected[Order::all].r,
                r.reflectance + through * through * m / (1 - m * r.reflectance), 1e-14);
    EXPECT_NEAR(e.sum().r, 1, 1e-14);
  }
}

// What a rough boundary of GGX or Beckmann facets sends from mu_i, by quadrature over the normals.
double by_normals(const Dielectric& d, double mu_i, bool transmits) {
  constexpr int kTheta = 300, kPhi = 300;
  const Quadrature &theta = cached_gauss_legendre(kTheta), &phi = cached_gauss_legendre(kPhi);
  Direction w = up(mu_i);
  const double n = d.ratio(w);
  if (w.z < 0) w = -w;
  double sum = 0;
  for (int a = 0; a < kTheta; ++a) {
    const double at = kPi / 2 * theta.points[a], slope = d.facets.alpha_x * std::tan(at);
    const double c = 1 / std::hypot(1.0, slope), s = slope * c;
    const double measure =
        theta.weights[a] * kPi / 2 * d.facets.alpha_x / std::pow(std::cos(at), 2) * c * c * s;
    for (int b = 0; b < kPhi; ++b) {
      const double x = kPi * phi.points[b];
      const Direction m{s * std::cos(x), s * std::sin(x), c};
      const double cosine = dot(w, m);
      if (!(cosine > 0)) continue;
      const Refraction<double> r = refraction(cosine, n);
      if (transmits && r.cosine == 0) continue;
      Direction wo = transmits ? refracted_ray(w, m, cosine, r.cosine, n) : 2 * cosine * m - w;
      if ((wo.z < 0) != transmits) continue;
      wo.z = std::abs(wo.z);
      sum += 2 * kPi * phi.weights[b] * measure * (transmits ? 1 - r.reflectance : r.reflectance) *
             d.facets.visible_density(w, m) * d.facets.passes(d.masking, transmits, w, wo);
    }
  }
  return sum;
}

TEST(InterfaceSolver, RoughCoatOverLambertIsTheClosedForm) {
  for (const double alpha : {0.3, 0.6}) {
    const DeterministicSolution s = solved(rough(1.5, alpha) + lambert_ground(0.8), 1e-6);
    EXPECT_TRUE(s.accuracy().reached);
    const Dielectric d{.facets = {FacetShape::ggx, alpha, alpha}, .above = 1, .below = 1.5};
    // The quadrature's own error, in pieces that end at the critical angle, is about 1e-6.
    double inside = 0;
    const double critical = std::sqrt(1 - 1 / 2.25);
    const Quadrature& rule = cached_gauss_legendre(16);
    for (Eigen::Index k = 0; k < rule.points.size(); ++k)
      for (const bool below : {true, false}) {
        const double low = below ? 0 : critical, high = below ? critical : 1;
        const double mu = low + (high - low) * rule.points[k];
        inside += 2 * mu * (high - low) * rule.weights[k] * by_normals(d, -mu, false);
      }
    for (const auto& [mu_i, mu_o] : {std::pair{0.9, 0.3}, {0.5, 0.8}}) {
      const double base = by_normals(d, mu_i, true) * by_normals(d, mu_o, true) * 0.8 /
                          (kPi * 2.25 * (1 - 0.8 * inside));
      const DeterministicValue v = s.f(up(mu_i), up(mu_o, 1));
      EXPECT_NEAR(v.zero.r, d.single(up(mu_i), up(mu_o, 1)), 1e-14);
      EXPECT_NEAR((v.order[Order::all].r - v.zero.r) / base, 1, 2e-5) << alpha;
    }
    const DeterministicEnergies e = energies_of(s, 0.9);
    EXPECT_NEAR(e.zero_reflected.r, by_normals(d, 0.9, false), 1e-7);
    EXPECT_NEAR(e.sum().r, 1, 1e-13);
  }
}

TEST(InterfaceSolver, RoughCoatsReachTheirTolerances) {
  for (const auto& [alpha, tolerance] : {std::pair{0.3, 1e-6}, {0.1, 1e-5}})
    for (const std::string kind : {"ggx", "beckmann"}) {
      const DeterministicSolution s =
          solved(rough(1.5, alpha, kind) + layer(kIsotropic, 0.9, kInfinity), tolerance);
      EXPECT_TRUE(s.accuracy().reached) << kind << ' ' << alpha;
      const Direction a = up(0.6), b = up(0.35, 1.1);
      EXPECT_NEAR(s.f(a, b).order[Order::all].r / s.f(b, a).order[Order::all].r, 1, tolerance);
    }
}

TEST(InterfaceSolver, WhatIsLeftToWalksIsRefusedByName) {
  const Stack stack = stack_of(interface(1.5, "ggx", "roughness = 0.3\nscattering = \"multiple\"") +
                               lambert_ground(0.5));
  const auto reason = why_not_deterministic(stack);
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->find("multiple scattering"), std::string::npos) << *reason;
}

// The solver against walks on cells, a z-score for every lobe's energy and every cell of "all".
TEST(InterfaceSolver, StacksAgreeWithWalks) {
  const std::string iso = layer(kIsotropic, 0.9, 0.8), hg = layer(henyey_greenstein(0.6), 0.95, 1);
  const std::string flakes = layer(sggx(0.5, "lambert"), 0.8, 0.7);
  for (const std::string& toml :
       {interface(1.5) + iso + lambert_ground(0.6), interface(1.5) + hg + interface(1),
        interface(1.3) + flakes + interface(1.6) + iso, hg + interface(1.4) + iso + interface(1),
        iso + rough(1.5, 0.3) + flakes + lambert_ground(0.5),
        rough(1.5, 0.3) + hg + lambert_ground(0.7),
        rough(1.4, 0.5, "beckmann") + layer(vmf(0.5, "lambert"), 0.9, kInfinity),
        rough(1.5, 0.4) + iso + rough(1, 0.4)}) {
    const Stack stack = stack_of(toml);
    const Plan plan = make_plan(stack);
    const CellGrid grid{.mu_cells = 4, .phi_cells = 8};
    const DeterministicSolution s =
        solve_deterministic(stack, {.tolerance = 1e-4, .max_seconds = 5});
    const bool open = stack.is_open_below();
    for (const double mu : {0.8, 0.2, -0.6}) {
      if (mu < 0 && !open) continue;
      const Direction wi[] = {up(mu)};
      const RunResult exact = deterministic_runs(s, plan, wi, grid, 1e-3)[0];
      EXPECT_FALSE(why_no_answer(exact)) << toml;
      Simulation walks(stack, plan, wi[0], Estimator::next_event, grid, 5);
      walks.advance(40000);
      const RunResult found = reduce(walks);
      const auto agree = [&](const Estimate& a, const Estimate& b, const char* what) {
        const double error = std::hypot(a.standard_error, b.standard_error) + 1e-9;
        EXPECT_LT(std::abs(a.value - b.value), 4.7 * error)
            << what << ' ' << a.value << ' ' << b.value << " mu " << mu << '\n'
            << toml;
      };
      agree(exact.lost[0], found.lost[0], "lost");
      agree(exact.absorbed[0], found.absorbed[0], "absorbed");
      agree(exact.uncollided[0], found.uncollided[0], "uncollided");
      for (const auto side : {&RunResult::reflected, &RunResult::transmitted}) {
        const SideResult &a = exact.*side, &b = found.*side;
        agree(a.total[0], b.total[0], "total");
        agree(a.zero[0], b.zero[0], "zero");
        agree(a.specular[0], b.specular[0], "specular");
        for (int o = 0; o < kTallyOrders; ++o) agree(a.orders[o][0], b.orders[o][0], "order");
        for (const int lobe : {kTallyOrders, place(Order::zero), place(Order::scattered)}) {
          const LobeEstimate &x = a.lobes[lobe], &y = b.lobes[lobe];
          if (x.value.empty() || y.value.empty()) continue;
          ASSERT_EQ(x.value.size(), y.value.size());
          for (std::size_t k = 0; k < x.value.size(); ++k)
            if (y.standard_error[k] > 0)
              agree({x.value[k], x.standard_error[k]}, {y.value[k], y.standard_error[k]}, "cell");
        }
        if (!a.has_zero_lobe()) continue;
        for (std::size_t k = 0; k < a.lobes[Order::zero].value.size(); ++k)
          EXPECT_NEAR(a.lobes[Order::zero].value[k] + a.lobes[Order::scattered].value[k],
                      a.lobes[Order::all].value[k], 1e-12 * a.lobes[Order::all].value[k]);
      }
    }
  }
}

// Mirror flakes over metal at pairs: over a rough one order 2 is integrated, over a smooth one it
// is in the modes, which the bound tells.
TEST(InterfaceSolver, MirrorFlakesOverMetalAgreeWithWalksAtPairs) {
  const std::string flakes = layer(sggx(0.5, "mirror"), 0.9, 0.7);
  const std::string metal = "[substrate]\nbsdf = \"conductor\"\neta = 0.2\nk = 3.9\n";
  const Direction wi = up(0.7);
  const std::vector<Direction> points{up(0.7, 1), up(0.3, kPi), up(0.9, 2)};
  const std::string coat = rough(1.5, 0.4) + layer(sggx(0.5, "lambert"), 0.8, 0.5);
  for (const std::string& toml : {flakes + metal + "distribution = \"ggx\"\nroughness = 0.3\n",
                                  flakes + metal, coat + metal}) {
    const Stack stack = stack_of(toml);
    const DeterministicSolution s =
        solve_deterministic(stack, {.tolerance = 1e-3, .max_nodes = 32, .max_seconds = 100});
    Simulation walks(stack, make_plan(stack), wi, points, 3);
    walks.advance(50000);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const DeterministicValue v = s.f(wi, points[k]);
      EXPECT_LT(v.error.r, 2e-2 * v.order[Order::all].r);
      for (const int order : {0, 1, 2, kTallyOrders}) {
        const Estimate e = testing::point_estimate(walks, order, static_cast<int>(k),
                                                   static_cast<int>(points.size()));
        const double scattered = v.order[order].r - (order == kTallyOrders ? v.zero.r : 0);
        EXPECT_NEAR(e.value, scattered, 4.5 * e.standard_error + v.error.r)
            << toml << " point " << k << " order " << order;
      }
    }
  }
}

}  // namespace
}  // namespace lamella
