#include "tests/phase/medium/media_cases.h"

#include <fmt/format.h>

#include <algorithm>

namespace lamella::testing {
namespace {

constexpr Direction kUp{0, 0, 1};
const Direction kFiber = normalized(Direction{1, 0.2, 0.3});

double width_of(double alpha) { return std::min(alpha, 1.0); }

void add_sggx(std::vector<MediumCase>& list) {
  for (const double alpha : {0.001, 0.5, 1.0})
    for (const Direction axis : {kUp, kTilted}) {
      const Sggx ndf(Sggx::surface_matrix(alpha, axis));
      const std::string name = fmt::format("surface {} about {}", alpha, to_text(axis));
      list.push_back({"sggx mirror " + name, MirrorFlakes<Sggx>{ndf}, axis, width_of(alpha)});
      if (axis == kUp || alpha == 0.5)
        list.push_back({"sggx lambert " + name, LambertFlakes<Sggx>{ndf}, axis, 1, false, true});
    }
  for (const double alpha : {0.05, 0.5, 1.0})
    for (const Direction axis : {Direction{1, 0, 0}, kFiber}) {
      const Sggx ndf(Sggx::fiber_matrix(alpha, axis));
      const std::string name = fmt::format("fiber {} along {}", alpha, to_text(axis));
      list.push_back({"sggx mirror " + name, MirrorFlakes<Sggx>{ndf}, axis, 1, true});
      if (axis == kFiber)
        list.push_back({"sggx lambert " + name, LambertFlakes<Sggx>{ndf}, axis, 1, false, true});
    }
  const Sggx full(tilted_matrix());
  list.push_back({"sggx mirror matrix", MirrorFlakes<Sggx>{full}, kUp, 1, true});
  list.push_back({"sggx lambert matrix", LambertFlakes<Sggx>{full}, kUp, 1, false, true});
}

void add_vmf(std::vector<MediumCase>& list) {
  for (const double r : {0.001, 0.1, 0.5, 1.0})
    for (const Direction axis : {kUp, kTilted}) {
      const double alpha = vmf_alpha(r);
      const Vmf ndf(alpha, axis);
      const std::string name = fmt::format("r = {} about {}", r, to_text(axis));
      list.push_back({"vmf mirror " + name, MirrorFlakes<Vmf>{ndf}, axis, width_of(alpha)});
      list.push_back({"vmf lambert " + name, LambertFlakes<Vmf>{ndf}, axis, 1, false, true});
    }
}

}  // namespace

std::array<double, 6> tilted_matrix() {
  const Frame<double> f = frame_around(normalized(Direction{0.5, 0.6, -0.4}));
  const auto s = [&](double Direction::*a, double Direction::*b) {
    return f.s.*a * f.s.*b + 0.3 * f.t.*a * f.t.*b + 0.05 * f.n.*a * f.n.*b;
  };
  const auto x = &Direction::x, y = &Direction::y, z = &Direction::z;
  return {s(x, x), s(y, y), s(z, z), s(x, y), s(x, z), s(y, z)};
}

std::vector<MediumCase> media_cases() {
  std::vector<MediumCase> list;
  add_sggx(list);
  add_vmf(list);
  list.push_back({"lambert flakes all along z", LambertFlakes<Vmf>{Vmf(0, kUp)}, kUp, 1, false});
  list.push_back({"lambert sphere", LambertSphere{}});
  list.push_back({"rayleigh", Rayleigh{}});
  for (const double g : {-0.9, 0.0, 0.95})
    list.push_back({fmt::format("henyey-greenstein {}", g), HenyeyGreenstein{g}});
  return list;
}

std::vector<Direction> incident_directions() {
  return {direction_from_mu_phi(1, 0),       direction_from_mu_phi(0.7, 0.9),
          direction_from_mu_phi(0.3, 4),     direction_from_mu_phi(0.02, 2.5),
          direction_from_mu_phi(-0.02, 5.5), direction_from_mu_phi(-0.6, 1.2),
          direction_from_mu_phi(-1, 0)};
}

bool scatters(const MediumCase& c, Direction wi) {
  const auto* flakes = std::get_if<LambertFlakes<Vmf>>(&c.medium);
  return !(flakes && flakes->ndf.is_delta()) || sigma(c.medium, wi) > 0;
}

SphereCells lobe_cells(const MediumCase& c, Direction wi) {
  if (const auto* hg = std::get_if<HenyeyGreenstein>(&c.medium))
    return {.axis = hg->g < 0 ? wi : -wi,
            .width = hg->g == 0 ? kInfinity : (1 - std::abs(hg->g)) / std::sqrt(std::abs(hg->g))};
  if (c.costly) {
    // Narrow one-sided flakes' light ends within alpha of the horizon, which few points would miss.
    const auto* one_sided = std::get_if<LambertFlakes<Vmf>>(&c.medium);
    const bool narrow = one_sided && one_sided->ndf.alpha() < 0.1;
    return {.axis = c.axis, .rows = 4, .columns = 6, .smooth = !narrow};
  }
  if (c.fiber || c.roughness >= 1) return {.axis = c.axis};
  const double u = dot(wi, c.axis);
  const auto* vmf = std::get_if<MirrorFlakes<Vmf>>(&c.medium);
  // Two-sided flakes turn a normal to the light; one-sided ones seen from behind are seen edge-on.
  if (vmf && u < 0) {
    const double kappa = vmf_concentration(vmf->ndf.alpha());
    const double sine = std::sqrt((1 - u) * (1 + u));
    const Direction towards = sine > 1e-6 ? c.axis : frame_around(wi).s;
    // Where sigma leaves its table every value takes a quadrature: few points then.
    return {.axis = -wi,
            .width = std::min({c.roughness, 4 / (kappa * -u), 1.0}),
            .towards = towards,
            .azimuth_width = 1 / std::sqrt(1 + kappa * sine),
            .smooth = vmf->sigma(wi) < 1e-20};
  }
  const Direction normal = u < 0 ? -c.axis : c.axis;
  return {.axis = mirrored(wi, normal), .width = c.roughness};
}

std::string to_text(Direction w) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", w.x, w.y, w.z); }

}  // namespace lamella::testing
