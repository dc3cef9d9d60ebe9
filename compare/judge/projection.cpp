#include "compare/judge/projection.h"

#include <tbb/parallel_for.h>

#include <boost/math/quadrature/gauss.hpp>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "analytic/model/stochastic_model.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

constexpr int kPoints = 4;  // per panel and dimension

using Values = std::vector<Rgb>;  // per order and all

// Nodes and weights of the rule on [-1, 1].
std::array<std::pair<double, double>, kPoints> gauss_rule() {
  using Rule = boost::math::quadrature::gauss<double, kPoints>;
  std::array<std::pair<double, double>, kPoints> rule;
  for (int i = 0; i < kPoints / 2; ++i) {
    rule[2 * i] = {-Rule::abscissa()[i], Rule::weights()[i]};
    rule[2 * i + 1] = {Rule::abscissa()[i], Rule::weights()[i]};
  }
  return rule;
}

class CellIntegrator {
 public:
  CellIntegrator(const Model& model, const ModelInfo& info, Direction wi, const CellGrid& grid,
                 bool up)
      : model_(model), info_(info), wi_(wi), grid_(grid), side_(up ? 1 : -1) {}

  // The cell's means with panels x panels sub-cells; steps in mu, where f is smooth down to 0.
  [[nodiscard]] Values means(int cell, int panels) const {
    static const auto rule = gauss_rule();
    const int row = cell / grid_.columns(), column = cell % grid_.columns();
    const double mu0 = grid_.edge_mu(row + 1), mu1 = grid_.edge_mu(row);
    const double phi0 = azimuth(wi_) + grid_.edge_phi(column);
    const double dmu = (mu1 - mu0) / panels;
    const double dphi = 2 * kPi / grid_.phi_cells / panels;
    Values sums(kOrders + 1);
    std::vector<Rgb> lobes(info_.lobes.size());
    for (int a = 0; a < panels; ++a)
      for (const auto& [x, wx] : rule) {
        const double mu = mu0 + dmu * (a + (x + 1) / 2);
        for (int b = 0; b < panels; ++b)
          for (const auto& [y, wy] : rule) {
            const double phi = phi0 + dphi * (b + (y + 1) / 2);
            model_.eval_lobes(wi_, direction_from_mu_phi(side_ * mu, phi), lobes);
            const double weight = wx * wy * mu;
            for (std::size_t k = 0; k < lobes.size(); ++k) {
              const Rgb part = weight * lobes[k];
              sums[kOrders] += part;
              // Order 0 has no tally yet: it is part of all orders only.
              if (static_cast<int>(info_.lobes[k].order) < kOrders)
                sums[static_cast<int>(info_.lobes[k].order)] += part;
            }
          }
      }
    // Over the cell, the integral of mu dmu dphi is (mu1^2 - mu0^2) / 2 times the width of phi.
    const double norm =
        dmu / 2 * dphi / 2 / ((mu1 - mu0) * (mu1 + mu0) / 2 * (2 * kPi / grid_.phi_cells));
    for (Rgb& sum : sums) sum = norm * sum;
    return sums;
  }

 private:
  const Model& model_;
  const ModelInfo& info_;
  Direction wi_;
  const CellGrid& grid_;
  double side_;
};

// |a - b| per order and channel.
Values change(const Values& a, const Values& b) {
  Values d(a.size());
  for (std::size_t o = 0; o < a.size(); ++o)
    for (int c = 0; c < 3; ++c) d[o][c] = std::abs(a[o][c] - b[o][c]);
  return d;
}

bool close(const Values& a, const Values& b, const Values& scale) {
  for (std::size_t o = 0; o < a.size(); ++o)
    for (int c = 0; c < 3; ++c) {
      const double allowed =
          kProjectionTolerance * std::max(std::abs(b[o][c]), kProjectionFloor * scale[o][c]);
      if (std::abs(a[o][c] - b[o][c]) > allowed) return false;
    }
  return true;
}

std::array<std::vector<double>, kOrders + 1> by_channel(const std::vector<Values>& cells,
                                                        int channels) {
  std::array<std::vector<double>, kOrders + 1> lobes;
  for (std::size_t o = 0; o < lobes.size(); ++o)
    for (int c = 0; c < channels; ++c)
      for (const Values& cell : cells) lobes[o].push_back(cell[o][c]);
  return lobes;
}

}  // namespace

ProjectedLobes project(const Model& model, const ModelInfo& info, Direction wi,
                       const CellGrid& grid, bool up, int channels) {
  wi = with_grazing_limit(wi);
  const CellIntegrator integrator(model, info, wi, grid, up);
  const int cells = grid.cells();
  std::vector<Values> coarse(cells);
  tbb::parallel_for(0, cells, [&](int cell) { coarse[cell] = integrator.means(cell, 1); });
  Values scale(kOrders + 1);
  for (const Values& v : coarse)
    for (int o = 0; o <= kOrders; ++o)
      for (int c = 0; c < 3; ++c) scale[o][c] += std::abs(v[o][c]) / cells;

  const auto start = std::chrono::steady_clock::now();
  const auto is_late = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() >
           kProjectionSeconds;
  };
  const Values nothing(kOrders + 1);
  std::vector<Values> open(cells, nothing);
  tbb::parallel_for(0, cells, [&](int cell) {
    open[cell] = change(coarse[cell], nothing);  // unrefined, nothing is known of it
    for (int panels = 2; panels <= kProjectionPanels && !is_late(); panels *= 2) {
      const Values fine = integrator.means(cell, panels);
      const bool done = close(coarse[cell], fine, scale);
      open[cell] = done ? nothing : change(coarse[cell], fine);
      coarse[cell] = fine;
      if (done) break;
    }
  });

  // A comparison would take what is no number for no difference.
  for (const Values& cell : coarse)
    for (const Rgb& f : cell)
      if (!std::isfinite(f.r + f.g + f.b))
        throw std::domain_error(info.name + ": its mean over a cell is not finite");

  ProjectedLobes result;
  result.has[kOrders] = true;
  for (const LobeInfo& lobe : info.lobes)
    if (static_cast<int>(lobe.order) < kOrders) result.has[static_cast<int>(lobe.order)] = true;
  result.lobes = by_channel(coarse, channels);
  result.errors = by_channel(open, channels);
  if (const auto* stochastic = dynamic_cast<const StochasticModel*>(&model))
    for (const auto& part : stochastic->split(kBatches)) {
      const CellIntegrator rough(*part, info, wi, grid, up);
      tbb::parallel_for(0, cells, [&](int cell) { coarse[cell] = rough.means(cell, 1); });
      result.parts.push_back(by_channel(coarse, channels));
    }
  return result;
}

}  // namespace lamella
