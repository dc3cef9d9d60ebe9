#include "compare/judge/projection.h"

#include <tbb/parallel_for.h>

#include <boost/math/quadrature/gauss.hpp>
#include <chrono>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "analytic/model/batched_model.h"
#include "analytic/model/stochastic_model.h"
#include "compare/judge/cell_pieces.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

constexpr int kPoints = 4;  // per panel and dimension
// Pairs of a call of a BatchedModel.
constexpr std::size_t kBatchPairs = 1 << 16;

using Values = OrderMap<Rgb>;

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

  // The cell's means with panels x panels panels in each of its pieces.
  [[nodiscard]] Values means(int cell, const std::vector<CellPiece>& pieces, int panels) const {
    Values sums{};
    for (const CellPiece& piece : pieces) {
      const Values part = integrals(piece, panels);
      for (std::size_t o = 0; o < sums.size(); ++o) sums[o] += part[o];
    }
    const double norm = cell_norm(grid_, cell);
    for (Rgb& sum : sums) sum = norm * sum;
    return sums;
  }

  // The same of many cells, for a BatchedModel: the points of all of them in calls of
  // kBatchPairs pairs. `pieces`: of every cell.
  [[nodiscard]] std::vector<Values> means(const std::vector<int>& cells,
                                          const std::vector<std::vector<CellPiece>>& pieces,
                                          int panels) const {
    std::vector<Values> sums(cells.size(), Values{});
    std::vector<DirectionPair> pairs;
    std::vector<std::pair<std::size_t, double>> places;  // of sums, and the weight there
    std::vector<Rgb> values;
    const auto evaluate = [&] {
      values.resize(pairs.size());
      model_.eval(pairs, values, Isa::scalar);
      for (std::size_t k = 0; k < pairs.size(); ++k)
        sums[places[k].first][Order::all] += places[k].second * values[k];
      pairs.clear();
      places.clear();
    };
    for (std::size_t n = 0; n < cells.size(); ++n)
      for (const CellPiece& piece : pieces[cells[n]]) {
        const double scale = cell_norm(grid_, cells[n]) * area_of(piece, panels);
        visit(piece, panels, [&](Direction wo, double weight) {
          pairs.push_back({wi_, wo});
          places.emplace_back(n, scale * weight);
        });
        if (pairs.size() >= kBatchPairs) evaluate();
      }
    if (!pairs.empty()) evaluate();
    if (info_.lobes[0].order != Order::all)
      for (Values& v : sums) v[info_.lobes[0].order] = v[Order::all];
    return sums;
  }

 private:
  // Of f mu dmu dphi; steps in mu, where f is smooth down to 0.
  [[nodiscard]] Values integrals(const CellPiece& piece, int panels) const {
    Values sums{};
    std::vector<Rgb> lobes(info_.lobes.size());
    visit(piece, panels, [&](Direction wo, double weight) {
      model_.eval_lobes(wi_, wo, lobes);
      for (std::size_t k = 0; k < lobes.size(); ++k) {
        const Rgb part = weight * lobes[k];
        sums[Order::all] += part;
        if (info_.lobes[k].order != Order::all) sums[info_.lobes[k].order] += part;
      }
    });
    for (Rgb& sum : sums) sum = area_of(piece, panels) * sum;
    return sums;
  }

  // What the sums over a piece's points are multiplied by.
  [[nodiscard]] static double area_of(const CellPiece& piece, int panels) {
    const double dmu = (piece.mu1 - piece.mu0) / panels;
    const double dphi = (piece.phi1 - piece.phi0) / panels;
    return dmu / 2 * dphi / 2;
  }

  // f(w_o, weight) at every point of the piece.
  template <class F>
  void visit(const CellPiece& piece, int panels, const F& f) const {
    static const auto rule = gauss_rule();
    const double mu0 = piece.mu0, phi0 = azimuth(wi_) + piece.phi0;
    const double dmu = (piece.mu1 - piece.mu0) / panels;
    const double dphi = (piece.phi1 - piece.phi0) / panels;
    for (int a = 0; a < panels; ++a)
      for (const auto& [x, wx] : rule) {
        const double mu = mu0 + dmu * (a + (x + 1) / 2);
        for (int b = 0; b < panels; ++b)
          for (const auto& [y, wy] : rule) {
            const double phi = phi0 + dphi * (b + (y + 1) / 2);
            f(direction_from_mu_phi(side_ * mu, phi), wx * wy * mu);
          }
      }
  }

  const Model& model_;
  const ModelInfo& info_;
  Direction wi_;
  const CellGrid& grid_;
  double side_;
};

// |a - b| per order and channel.
Values change(const Values& a, const Values& b) {
  Values d{};
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

OrderMap<std::vector<double>> by_channel(const std::vector<Values>& cells, int channels) {
  OrderMap<std::vector<double>> lobes;
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
  const bool batches = dynamic_cast<const BatchedModel*>(&model) != nullptr;
  std::vector<std::vector<CellPiece>> pieces(cells);
  std::vector<Values> coarse(cells);
  tbb::parallel_for(0, cells, [&](int cell) { pieces[cell] = cell_pieces(grid, cell, wi); });
  std::vector<int> rest(cells);
  std::iota(rest.begin(), rest.end(), 0);
  if (batches)
    coarse = integrator.means(rest, pieces, 1);
  else
    tbb::parallel_for(0, cells,
                      [&](int cell) { coarse[cell] = integrator.means(cell, pieces[cell], 1); });
  Values scale{};
  for (const Values& v : coarse)
    for (int o = 0; o < kLobeOrders; ++o)
      for (int c = 0; c < 3; ++c) scale[o][c] += std::abs(v[o][c]) / cells;

  const auto start = std::chrono::steady_clock::now();
  const auto is_late = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() >
           kProjectionSeconds;
  };
  const Values nothing{};
  std::vector<Values> open(cells, nothing);
  // Takes the finer means of a cell; whether they are fine enough.
  const auto refine = [&](int cell, const Values& fine) {
    const bool done = close(coarse[cell], fine, scale);
    open[cell] = done ? nothing : change(coarse[cell], fine);
    coarse[cell] = fine;
    return done;
  };
  for (int cell = 0; cell < cells; ++cell)
    open[cell] = change(coarse[cell], nothing);  // unrefined, nothing is known of it
  if (batches)
    for (int panels = 2; panels <= kProjectionPanels && !rest.empty() && !is_late(); panels *= 2) {
      const std::vector<Values> fine = integrator.means(rest, pieces, panels);
      std::vector<int> further;
      for (std::size_t n = 0; n < rest.size(); ++n)
        if (!refine(rest[n], fine[n])) further.push_back(rest[n]);
      rest = std::move(further);
    }
  else
    tbb::parallel_for(0, cells, [&](int cell) {
      for (int panels = 2; panels <= kProjectionPanels && !is_late(); panels *= 2)
        if (refine(cell, integrator.means(cell, pieces[cell], panels))) break;
    });

  // A comparison would take what is no number for no difference.
  for (const Values& cell : coarse)
    for (const Rgb& f : cell)
      if (!std::isfinite(f.r + f.g + f.b))
        throw std::domain_error(info.name + ": its mean over a cell is not finite");

  ProjectedLobes result;
  result.has[Order::all] = true;
  for (const LobeInfo& lobe : info.lobes) result.has[lobe.order] = true;

  result.lobes = by_channel(coarse, channels);
  result.errors = by_channel(open, channels);
  if (const auto* stochastic = dynamic_cast<const StochasticModel*>(&model))
    for (const auto& part : stochastic->split(kBatches)) {
      const CellIntegrator rough(*part, info, wi, grid, up);
      tbb::parallel_for(0, cells,
                        [&](int cell) { coarse[cell] = rough.means(cell, pieces[cell], 1); });
      result.parts.push_back(by_channel(coarse, channels));
    }
  return result;
}

}  // namespace lamella
