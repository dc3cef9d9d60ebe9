// Walks through interfaces against closed forms, against each other, and at the ends of the
// parameters.

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>

#include "phase/interface/dielectric.h"
#include "phase/surface/fresnel.h"
#include "tests/phase/interface/facet_energies.h"
#include "tests/volume/run/stacks.h"

namespace lamella::testing {
namespace {

using boost::math::quadrature::gauss_kronrod;

std::string interface(const std::string& keys) { return "[[layer]]\ninterface = " + keys + "\n"; }
std::string substrate(const std::string& keys) { return "[substrate]\nbsdf = " + keys + "\n"; }
std::string half_space(const std::string& keys) { return layer(keys + "\nthickness = inf"); }

template <class F>
double integral(const F& f, double from, double to) {
  return gauss_kronrod<double, 61>::integrate(f, from, to, 15, 1e-11);
}

// 2 integral of F(mu) g(mu) mu dmu from inside, total reflection included.
template <class G>
double mean_inside(double n, const G& g) {
  const double critical = std::sqrt(1 - 1 / (n * n));
  const auto part = [&](double mu) { return 2 * mu * fresnel_reflectance(mu, 1 / n) * g(mu); };
  return integral([&](double mu) { return 2 * mu * g(mu); }, 0, critical) +
         integral([&](double t) { return 2 * t * part(critical + t * t); }, 0,
                  std::sqrt(1 - critical));
}

double inner_cosine(double mu, double n) { return std::sqrt(1 - (1 - mu * mu) / (n * n)); }

// A smooth interface over an absorbing layer over Lambert's substrate.
struct CoatedLambert {
  double n, albedo, depth;
  [[nodiscard]] double through(double mu) const {
    return (1 - fresnel_reflectance(mu, n)) * std::exp(-depth / inner_cosine(mu, n));
  }
  [[nodiscard]] double back() const {
    return mean_inside(n, [&](double mu) { return std::exp(-2 * depth / mu); });
  }
  [[nodiscard]] double f(double mi, double mo) const {
    return albedo / (kPi * n * n) * through(mi) * through(mo) / (1 - albedo * back());
  }
  [[nodiscard]] Stack stack() const {
    std::string text = interface("'smooth'\nior = " + std::to_string(n));
    if (depth > 0)
      text +=
          layer("medium = 'henyey_greenstein'\nalbedo = 0\nthickness = " + std::to_string(depth));
    return stack_from(text + substrate("'lambert'\nalbedo = " + std::to_string(albedo)));
  }
};

Estimate at_point(const Stack& stack, Direction wi, Direction wo, int order, std::uint64_t walks,
                  int channel = 0, std::uint64_t seed = 1) {
  Simulation simulation(stack, make_plan(stack), wi, {wo}, seed);
  simulation.advance(walks);
  const int channels = simulation.plan().channels;
  return batch_estimate(simulation.batches(), [&](const BatchTally& b) {
    double sum = 0;
    for (int o = 0; o < simulation.plan().order_slots(); ++o)
      if (o == order) sum += b.f[o * channels + channel];
    return sum;
  });
}
Estimate all_at_point(const Stack& stack, Direction wi, Direction wo, std::uint64_t walks,
                      int channel = 0, std::uint64_t seed = 1) {
  Simulation simulation(stack, make_plan(stack), wi, {wo}, seed);
  simulation.advance(walks);
  const int channels = simulation.plan().channels;
  return batch_estimate(simulation.batches(), [&](const BatchTally& b) {
    double sum = 0;
    for (int o = 0; o < simulation.plan().order_slots(); ++o) sum += b.f[o * channels + channel];
    return sum;
  });
}

RunResult simulate(const Stack& stack, Direction wi, Estimator estimator, std::uint64_t walks,
                   CellGrid grid = {4, 4, false}, std::uint64_t seed = 1) {
  Simulation simulation(stack, make_plan(stack), wi, estimator, grid, seed);
  simulation.advance(walks);
  return reduce(simulation);
}

TEST(InterfaceWalk, SmoothOverLambertIsItsClosedForm) {
  EXPECT_NEAR(mean_inside(1.5, [](double) { return 1.0; }), 0.5963, 5e-5);
  for (const CoatedLambert& c :
       {CoatedLambert{1.5, 0.8, 0}, {1.5, 1, 0}, {1.5, 0.8, 0.3}, {1.33, 0.5, 1}})
    for (const auto& [mi, mo] : {std::pair{0.9, 0.4}, {0.1, 0.7}}) {
      const Estimate f = all_at_point(c.stack(), direction_from_mu_phi(mi, 0),
                                      direction_from_mu_phi(mo, 2), soaked(40000));
      EXPECT_LT(std::abs(f.value - c.f(mi, mo)) / f.standard_error, allowed_z())
          << c.n << ' ' << c.albedo << ' ' << c.depth << ' ' << f.value << ' ' << c.f(mi, mo);
      const RunResult run =
          simulate(c.stack(), direction_from_mu_phi(mi, 0), Estimator::analog, soaked(40000));
      const double energy = fresnel_reflectance(mi, c.n) +
                            integral([&](double mu) { return 2 * kPi * mu * c.f(mi, mu); }, 0, 1);
      const Estimate& total = run.reflected.total[0];
      EXPECT_LT(std::abs(total.value - energy), allowed_z() * total.standard_error + 1e-10);
      EXPECT_NEAR(run.reflected.specular[0].value, fresnel_reflectance(mi, c.n), 0.01);
    }
}

TEST(InterfaceWalk, RoughOverLambertIsItsClosedForm) {
  const double n = 1.5, albedo = 0.8;
  for (const std::string masking : {"beta", "correlated", "separable"})
    for (const double alpha : {0.1, 0.5}) {
      Dielectric d{
          .facets = {FacetShape::ggx, alpha, alpha}, .masking = masking_from(masking), .below = n};
      const Stack stack = stack_from(interface("'ggx'\nior = 1.5\nmasking = '" + masking +
                                               "'\nroughness = " + std::to_string(alpha)) +
                                     substrate("'lambert'\nalbedo = 0.8"));
      const double inside = boost::math::quadrature::gauss<double, 20>::integrate(
          [&](double mu) {
            return 2 * mu * facet_energies(d, direction_from_mu_phi(-mu, 0), 60).reflected;
          },
          0.0, 1.0);
      const Direction wi = direction_from_mu_phi(0.7, 0), wo = direction_from_mu_phi(0.5, 2.6);
      const double base = albedo / (kPi * n * n) * facet_energies(d, wi, 60).transmitted *
                          facet_energies(d, wo, 60).transmitted / (1 - albedo * inside);
      const Estimate all = all_at_point(stack, wi, wo, soaked(60000));
      // The quadrature over facets, 60 x 60, is good to 1e-3 of the base.
      EXPECT_LT(std::abs(all.value - base - d.single(wi, wo)),
                allowed_z() * all.standard_error + 2e-3 * base)
          << masking << ' ' << alpha;
      const Estimate zero = at_point(stack, wi, wo, kZeroSlot, 1280);
      EXPECT_NEAR(zero.value, d.single(wi, wo), 1e-12 * zero.value);
    }
}

TEST(InterfaceWalk, APlateIsTheSumOverItsBounces) {
  const Stack plate = stack_from(interface("'smooth'\nior = 1.5") + interface("'smooth'\nior = 1"));
  for (const double mu : {1.0, 0.4, -0.4, 0.05}) {
    const double f = fresnel_reflectance(std::abs(mu), 1.5);
    const RunResult run =
        simulate(plate, direction_from_mu_phi(mu, 0), Estimator::next_event, soaked(40000));
    const Estimate& r = run.reflected.specular[0];
    EXPECT_LT(std::abs(r.value - 2 * f / (1 + f)) / r.standard_error, allowed_z()) << mu;
    EXPECT_EQ(run.reflected.total[0].value, r.value);
    EXPECT_NEAR(run.uncollided[0].value + r.value, 1, 1e-12);
    EXPECT_EQ(run.transmitted.total[0].value, 0);
  }
}

// Giovanelli 1955, as MCML's authors quote it: specular light included.
TEST(InterfaceWalk, HalfSpaceUnderGlassReflectsWhatGiovanelliFound) {
  const Stack stack = stack_from(interface("'smooth'\nior = 1.5") +
                                 half_space("medium = 'henyey_greenstein'\nalbedo = 0.9"));
  const RunResult run = simulate(stack, {0, 0, 1}, Estimator::analog, soaked(400000));
  const Estimate& total = run.reflected.total[0];
  EXPECT_LT(std::abs(total.value - 0.2600) - 5e-5, allowed_z() * total.standard_error)
      << total.value;
}

TEST(InterfaceWalk, AnIndexThatDoesNotChangeDoesNothing) {
  const std::string body = layer("medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = 2");
  const Stack bare = stack_from(body);
  const Stack with = stack_from(interface("'ggx'\nior = 1\nroughness = 0.3") + body +
                                interface("'smooth'\nior = 1"));
  for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
    const RunResult a = simulate(bare, direction_from_mu_phi(0.6, 0), estimator, 4096);
    const RunResult b = simulate(with, direction_from_mu_phi(0.6, 0), estimator, 4096);
    EXPECT_EQ(a.reflected.lobes[Order::all].value, b.reflected.lobes[Order::all].value);
    EXPECT_EQ(a.transmitted.total[0].value, b.transmitted.total[0].value);
  }
}

std::vector<std::string> stacks_with_interfaces() {
  const std::string hg =
      layer("medium = 'henyey_greenstein'\ng = 0.5\nalbedo = 0.9\nthickness = 1");
  const std::string spheres =
      layer("medium = 'lambert_sphere'\nalbedo = [0.9, 0.5, 0.8]\nthickness = 0.7");
  const std::string flakes =
      layer("medium = 'sggx'\nroughness = 0.4\nf0 = 0.04\nalbedo = 0.95\nthickness = 0.5");
  const std::string sand = layer("medium = 'vmf_flake'\nroughness = 0.5\nthickness = 0.8");
  const std::string copper = "'conductor'\neta = [0.2, 0.92, 1.1]\nk = [3.91, 2.45, 2.14]\n";
  const std::string smooth = interface("'smooth'\nior = 1.5"), air = interface("'smooth'\nior = 1");
  const std::string rough = interface("'ggx'\nior = 1.5\nroughness = 0.4");
  const std::string beckmann = interface("'beckmann'\nior = 1.3\nroughness = [0.2, 0.5]");
  const std::string all = "\nscattering = 'multiple'";
  return {smooth + hg,
          smooth + hg + air,
          rough + spheres + substrate("'lambert'\nalbedo = 0.5"),
          rough + hg + air,
          interface("'ggx'\nior = 1.5\nroughness = 0.4" + all) + flakes +
              interface("'ggx'\nior = 1\nroughness = 0.2" + all),
          beckmann + sand + interface("'ggx'\nior = 1.6\nroughness = 0.3") + hg,
          smooth + spheres + substrate(copper + "distribution = 'ggx'\nroughness = 0.4"),
          rough + substrate(copper),
          rough + hg + substrate(copper + "distribution = 'beckmann'\nroughness = 0.5" + all),
          interface("'smooth'\nior = 0.8") + hg + beckmann + spheres,
          smooth + half_space("medium = 'rayleigh'\nalbedo = 0.95")};
}

// Both estimators count the same light; their energies share walks, their cells do not.
TEST(InterfaceWalk, AnalogAndNextEventAgree) {
  for (const std::string& text : stacks_with_interfaces())
    for (const double mu : {0.7, -0.5}) {
      const Stack stack = stack_from(text);
      if (mu < 0 && !stack.is_open_below()) continue;
      const Direction wi = direction_from_mu_phi(mu, 0.3);
      const RunResult a = simulate(stack, wi, Estimator::analog, soaked(120000), {3, 4, false}, 1);
      const RunResult b =
          simulate(stack, wi, Estimator::next_event, soaked(40000), {3, 4, false}, 2);
      for (const bool reflected : {true, false}) {
        const SideResult& sa = reflected ? a.reflected : a.transmitted;
        const SideResult& sb = reflected ? b.reflected : b.transmitted;
        for (const int lobe : {0, 1, kTallyOrders, place(Order::zero)}) {
          ASSERT_EQ(sa.lobes[lobe].value.size(), sb.lobes[lobe].value.size());
          for (std::size_t k = 0; k < sa.lobes[lobe].value.size(); ++k) {
            const Estimate ea{sa.lobes[lobe].value[k], sa.lobes[lobe].standard_error[k]};
            const Estimate eb{sb.lobes[lobe].value[k], sb.lobes[lobe].standard_error[k]};
            // Fewer than some fifty photons in a cell are not normal.
            if (ea.value < 50 * ea.standard_error * ea.standard_error * 120000 / 3) {
              if (!(ea.value > 7 * ea.standard_error)) continue;
            }
            EXPECT_LT(std::abs(z_between(ea, eb)), allowed_z())
                << text << " mu " << mu << " lobe " << lobe << " cell " << k << ' ' << ea.value
                << ' ' << eb.value << " +- " << eb.standard_error;
          }
        }
        for (int c = 0; c < a.channels; ++c)
          EXPECT_LT(std::abs(z_between(sa.total[c], sb.total[c])), allowed_z()) << text;
      }
    }
}

// f(w_i, w_o) / n_o^2 = f(w_o, w_i) / n_i^2 at points, order 0 included; across one-sided flakes
// times exp(-one_sidedness) from above.
TEST(InterfaceWalk, IsReciprocalWithTheSquareOfTheIndex) {
  for (const std::string& text : stacks_with_interfaces()) {
    const Stack stack = stack_from(text);
    const double below = stack.index_of(stack.layers.size());
    std::vector<std::pair<Direction, Direction>> pairs{
        {direction_from_mu_phi(0.8, 0.2), direction_from_mu_phi(0.4, 2.5)}};
    if (stack.is_open_below()) {
      pairs.push_back({direction_from_mu_phi(0.8, 0.2), direction_from_mu_phi(-0.9, 3.0)});
      pairs.push_back({direction_from_mu_phi(-0.6, 0.2), direction_from_mu_phi(-0.9, 2.0)});
    }
    for (const auto& [wi, wo] : pairs) {
      const auto squared = [&](Direction w) { return w.z > 0 ? 1 : below * below; };
      Estimate there = all_at_point(stack, wi, wo, soaked(60000), 0, 3);
      Estimate back = all_at_point(stack, wo, wi, soaked(60000), 0, 4);
      for (double* v : {&there.value, &there.standard_error}) *v /= squared(wo);
      const double across = wi.z * wo.z < 0 ? std::exp(-stack.one_sidedness()) : 1;
      for (double* v : {&back.value, &back.standard_error}) *v *= across / squared(wi);
      EXPECT_LT(std::abs(z_between(there, back)), allowed_z())
          << text << there.value << ' ' << back.value << " +- " << back.standard_error;
    }
  }
}

TEST(InterfaceWalk, LedgersAddUpAndOrdersToTheWhole) {
  for (const std::string& text : stacks_with_interfaces()) {
    const Stack stack = stack_from(text);
    const RunResult run = simulate(stack, direction_from_mu_phi(0.6, 0), Estimator::analog, 8192);
    for (int c = 0; c < run.channels; ++c) {
      EXPECT_NEAR(ledger_sum(run, c), 1, 1e-11) << text;
      for (const SideResult* side : {&run.reflected, &run.transmitted}) {
        double sum = side->zero[c].value;
        for (int o = 0; o < kTallyOrders; ++o) sum += side->orders[o][c].value;
        EXPECT_NEAR(sum, side->total[c].value, 1e-12);
      }
    }
    if (!run.reflected.has_zero_lobe()) continue;
    const auto& lobes = run.reflected.lobes;
    for (std::size_t k = 0; k < lobes[Order::zero].value.size(); ++k)
      EXPECT_NEAR(lobes[Order::zero].value[k] + lobes[Order::scattered].value[k],
                  lobes[Order::all].value[k], 1e-12);
  }
}

TEST(InterfaceWalk, WhiteStacksOfSmoothAndOfMultipleInterfacesLoseNothing) {
  for (const std::string shape : {"'ggx'", "'beckmann'"})
    for (const std::string alpha : {"1e-4", "0.1", "1"}) {
      const std::string rough =
          shape + "\nroughness = " + alpha + "\nscattering = 'multiple'\nior = ";
      const Stack stack = whitened(stack_from(
          interface(rough + "1.5") + layer("medium = 'lambert_sphere'\nthickness = 0.5") +
          interface("'smooth'\nior = 1.2") + interface(rough + "1.7") +
          substrate("'conductor'\neta = 0.2\nk = 3.9\ndistribution = 'ggx'\nroughness = 0.3\n"
                    "scattering = 'multiple'")));
      const RunResult run = simulate(stack, direction_from_mu_phi(0.3, 0), Estimator::analog, 4096);
      EXPECT_NEAR(run.reflected.total[0].value, 1, 1e-12) << shape << alpha;
    }
}

TEST(InterfaceWalk, TheWayInWhichARunAdvancesDoesNotMatter) {
  const Stack stack = stack_from(stacks_with_interfaces()[3]);
  const auto run = [&](std::vector<std::uint64_t> stops) {
    Simulation simulation(stack, make_plan(stack), direction_from_mu_phi(0.6, 0),
                          Estimator::next_event, {4, 4, false}, 1);
    for (const std::uint64_t stop : stops) simulation.advance(stop);
    return reduce(simulation).reflected.lobes[Order::all].value;
  };
  EXPECT_EQ(run({5000}), run({1, 130, 777, 2048, 5000}));
}

// Light that is totally reflected at both sides of a film must not bounce till the end of time.
TEST(InterfaceWalk, ThinFilmsBetweenInterfacesEnd) {
  for (const std::string depth : {"1e-9", "1e-3", "1e6"}) {
    const Stack stack =
        stack_from(interface("'smooth'\nior = 1.5") +
                   layer("medium = 'henyey_greenstein'\ng = 0.5\nthickness = " + depth) +
                   interface("'smooth'\nior = 1") + layer("medium = 'rayleigh'\nthickness = 1e-9"));
    const RunResult run =
        simulate(stack, direction_from_mu_phi(0.3, 0), Estimator::next_event, 512);
    EXPECT_NEAR(ledger_sum(run, 0), 1, 1e-12) << depth;
  }
}

TEST(InterfaceWalk, HardCasesAddUp) {
  for (const std::string n : {"1.0001", "3", "0.7"})
    for (const std::string shape : {"'smooth'", "'ggx'\nroughness = 1e-4", "'ggx'\nroughness = 1",
                                    "'beckmann'\nroughness = 1", "'beckmann'\nroughness = 1e-4",
                                    "'ggx'\nroughness = 1\nscattering = 'multiple'"})
      for (const std::string k : {"0", "20"})
        for (const double mu : {1.0, 1e-7, 0.0}) {
          const Stack stack =
              stack_from(interface(shape + "\nior = " + n) +
                         layer("medium = 'lambert_sphere'\nalbedo = 0.5\nthickness = 1e-3") +
                         substrate("'conductor'\neta = 1.5\nk = " + k +
                                   "\ndistribution = 'beckmann'\nroughness = 1"));
          for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
            const RunResult run = simulate(stack, direction_from_mu_phi(mu, 0), estimator, 128);
            EXPECT_NEAR(ledger_sum(run, 0), 1, 1e-11) << n << shape << k << ' ' << mu;
          }
        }
}

TEST(InterfaceWalk, LightFromBelowOpaqueStacksIsRefused) {
  const Stack stack = stack_from(interface("'smooth'\nior = 1.5") + substrate("'black'"));
  EXPECT_THROW(simulate(stack, {0, 0, -1}, Estimator::analog, 128), std::invalid_argument);
}

// A layer on a perfect mirror is half of a layer of twice its depth: what would cross that leaves
// above, mirrored.
TEST(InterfaceWalk, AMirrorBelowUnfoldsALayer) {
  const std::string medium = "medium = 'henyey_greenstein'\ng = 0.4\nalbedo = 0.9\nthickness = ";
  const Stack folded = stack_from(
      layer(medium + "0.6") +
      substrate("'conductor'\ndistribution = 'smooth'\nfresnel = 'one'\neta = 1\nk = 1"));
  const Stack whole = stack_from(layer(medium + "1.2"));
  const Direction wi = direction_from_degrees(40, 0);
  for (const auto& [theta, phi] : {std::pair{20.0, 30.0}, {70.0, 180.0}, {40.0, 180.0}}) {
    const Direction wo = direction_from_degrees(theta, phi), below{wo.x, wo.y, -wo.z};
    const Estimate f = all_at_point(folded, wi, wo, 200000);
    const Estimate up = all_at_point(whole, wi, wo, 200000),
                   down = all_at_point(whole, wi, below, 200000);
    EXPECT_NEAR(f.value, up.value + down.value,
                allowed_z() * std::hypot(f.standard_error, up.standard_error, down.standard_error))
        << theta << ' ' << phi;
  }
}

TEST(InterfaceWalk, PointsThatDeltaFlakesWouldHideAreRefused) {
  const std::string flakes =
      layer("medium = 'vmf_flake'\nroughness = 0\nflake = 'mirror'\nthickness = 1");
  const Direction w = direction_from_degrees(40, 0);
  const auto begin = [&](const Stack& stack) { Simulation(stack, make_plan(stack), w, {w}, 1); };
  begin(stack_from(flakes));
  for (const std::string& more :
       {layer("medium = 'lambert_sphere'\nthickness = 1"), substrate("'lambert'\nalbedo = 0.5"),
        interface("'ggx'\nior = 1.5\nroughness = 0.2")})
    EXPECT_THROW(begin(stack_from(more[1] == 's' ? flakes + more : more + flakes)),
                 std::invalid_argument)
        << more;
}

}  // namespace
}  // namespace lamella::testing
