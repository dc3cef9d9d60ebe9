#include "analytic/coated/coat.h"

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "analytic/facets/facet_integral.h"
#include "phase/surface/fresnel.h"

namespace lamella {
namespace {

// A smaller reflectance counts as none: this is 1e-7 of that of n = 1.0001 at normal incidence.
constexpr double kLeastReflected = 2.5e-16;

// Tolerances are of the rules' differences: the errors are smaller by 100 and more. Terms and ends
// are of tables: albedos go like mu log mu near 0, and like mu^b with the masking's Beta function;
// near 1 refracted light goes like (1 - mu) log(1 - mu).
struct TableRule {
  double tolerance;
  int terms;
  double near_0, near_1;
};
struct Precision {
  TableRule reflected, transmitted;
  double mean;
};
constexpr Precision kExact{{1e-8, 12, 1e-7, 0.01}, {1e-6, 9, 1e-6, 1e-4}, 1e-6};
constexpr Precision kQuick{{1e-4, 6, 1e-3, 0.1}, {1e-4, 5, 1e-3, 0.02}, 1e-4};

thread_local bool is_quick = false;
const Precision& precision() { return is_quick ? kQuick : kExact; }

// Of quick coats, the tables of the last interfaces: a search asks for one again as often as it
// changes other parameters.
CosineTable recent_table(const Dielectric& interface, const std::function<CosineTable()>& make) {
  constexpr std::size_t kMost = 8;
  thread_local std::vector<std::pair<Dielectric, CosineTable>> recent;
  for (const auto& [known, table] : recent)
    if (known == interface) return table;
  if (recent.size() == kMost) recent.erase(recent.begin());
  return recent.emplace_back(interface, make()).second;
}

Direction at_cosine(double mu) { return direction_from_mu_phi(std::fmax(mu, kGrazingLimit), 0); }

// What a coat of that colour leaves of light that passes it once at a cosine within.
double passed(double color, double cosine) { return std::pow(color, 0.5 / cosine); }

}  // namespace

QuickCoats::QuickCoats() : before_(is_quick) { is_quick = true; }
QuickCoats::~QuickCoats() { is_quick = before_; }

Coat::Coat(const Dielectric& interface, Rgb color, bool through)
    : interface_(interface), color_(color) {
  if (index() == 1) interface_.facets.shape = FacetShape::smooth;
  const double edges[] = {0, 0.03, 1};
  fresnel_mean_ =
      integrate_adaptively<double>([&](double mu) { return 2 * mu * fresnel(mu); }, edges, 1e-9);
  reflected_mean_ = fresnel_mean_;
  if (!is_delta()) make_tables(through);
  if (!through) return;
  for (int c = 0; c < 3; ++c)
    internal_mean_[c] =
        c > 0 && color[c] == color[c - 1] ? internal_mean_[c - 1] : internal_mean_of(color[c]);
}

void Coat::make_tables(bool through) {
  const Facets& facets = interface_.facets;
  const double n = index();
  const TableRule& of_reflected = precision().reflected;
  const auto table = [&] {
    return CosineTable(
        [&](double mu) {
          return reflected_share<double>(
              facets, interface_.masking, at_cosine(mu),
              [&](double cosine, Direction) {
                return fresnel_reflectance(std::fmin(cosine, 1), n);
              },
              of_reflected.tolerance, 0, kLeastReflected);
        },
        of_reflected.terms, of_reflected.near_0, of_reflected.near_1);
  };
  reflected_ = is_quick ? recent_table(interface_, table) : table();
  reflected_mean_ = reflected_.mean();
  if (!through) return;
  const TableRule& of_transmitted = precision().transmitted;
  for (int c = 0; c < (color_.is_grey() ? 1 : 3); ++c)
    transmitted_[c] = CosineTable(
        [&](double mu) {
          return refracted_share(
              facets, interface_.masking, n, at_cosine(mu),
              [&](double cosine) { return passed(color_[c], cosine); }, of_transmitted.tolerance);
        },
        of_transmitted.terms, of_transmitted.near_0, of_transmitted.near_1);
}

double Coat::internal_mean_of(double color) const {
  const double n = index(), critical = std::sqrt(nonnegative(1 - 1 / (n * n)));
  const double edges[] = {0, critical, 1};
  const auto back = [&](double mu) {
    if (!(mu > 0)) return 0.0;
    if (is_delta()) return fresnel_reflectance(mu, 1 / n) * passed(color, mu / 2);
    return passed(color, mu) *
           reflected_share<double>(
               interface_.facets, interface_.masking, at_cosine(mu),
               [&](double cosine, Direction wo) {
                 return fresnel_reflectance(std::fmin(cosine, 1), 1 / n) *
                        (color < 1 ? passed(color, std::fmax(wo.z, kGrazingLimit)) : 1);
               },
               precision().mean, critical);
  };
  return integrate_adaptively<double>([&](double mu) { return 2 * mu * back(mu); }, edges,
                                      is_delta() ? 1e-10 : precision().mean);
}

double Coat::fresnel(double mu) const { return fresnel_reflectance(mu, index()); }

double Coat::reflected(double mu) const {
  return is_delta() ? fresnel(mu) : std::fmin(std::fmax(reflected_(mu), 0), 1);
}

double Coat::refracted(double mu) const {
  const double n = index();
  return std::sqrt((n - 1) * (n + 1) + mu * mu) / n;
}

Rgb Coat::absorption(double mu_i, double mu_o) const {
  if (color_ == Rgb(1)) return color_;
  const double way = 0.5 / refracted(std::fmax(mu_i, kGrazingLimit)) +
                     0.5 / refracted(std::fmax(mu_o, kGrazingLimit));
  return {std::pow(color_.r, way), std::pow(color_.g, way), std::pow(color_.b, way)};
}

Rgb Coat::transmitted(double mu) const {
  Rgb t;
  const double inside = refracted(std::fmax(mu, kGrazingLimit));
  for (int c = 0; c < 3; ++c) {
    if (c > 0 && color_[c] == color_[c - 1])
      t[c] = t[c - 1];
    else
      t[c] = is_delta() ? (1 - fresnel(mu)) * passed(color_[c], inside)
                        : std::fmax(transmitted_[c](mu), 0);
  }
  return t;
}

}  // namespace lamella
