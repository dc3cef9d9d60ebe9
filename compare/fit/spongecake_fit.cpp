#include "compare/fit/spongecake_fit.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <cmath>

#include "analytic/layered/spongecake.h"
#include "phase/math/luminance.h"
#include "phase/stack/single_scattering.h"

namespace lamella {
namespace {

constexpr double kLargestFactor = 1e3;
// Standard errors of the energy that cut walks held which are added to it (judge/missing_light.h).
constexpr double kUnresolvedErrors = 3;
// Narrower flakes than this are narrower than a cell.
constexpr double kLeastRoughness = 0.02, kLargestG = 0.98;

/// One cell of one run and side.
struct Cell {
  Direction wi;
  std::array<Direction, 4> wo;  // nodes of Gauss's rule in mu^2 and phi
  Rgb truth, variance;
  bool reflected;
  std::size_t residue;
};

// Per channel, how much the energy of a run's orders 2 and up may be too low, as walks were cut.
Rgb missing_energy(const RunResult& run) {
  Rgb missing;
  for (int c = 0; c < 3; ++c) {
    const Estimate& cut = run.unresolved[run.channels == 3 ? c : 0];
    if (!run.is_bounded() && cut.value > 0)
      missing[c] = std::min(1.0, cut.value + kUnresolvedErrors * cut.standard_error);
  }
  return missing;
}

/// What is free, in the order of the solver's vector.
struct Layout {
  int layers, channels;
  std::vector<int> rough, deep;  // layers with a free roughness, depth
  bool transmits;

  [[nodiscard]] int tint(int layer, int c) const {  // layer > 0
    return static_cast<int>(rough.size() + deep.size()) + (layer - 1) * channels + c;
  }
  [[nodiscard]] int weight(int c) const { return tint(layers, c); }
  [[nodiscard]] int reflect(int c) const { return weight(channels) + c; }
  [[nodiscard]] int transmit(int c) const { return reflect(channels) + c; }
  [[nodiscard]] int size() const { return transmits ? transmit(channels) : transmit(0); }
};

struct Lobes {
  std::vector<SpongecakeFactors> factors;
  Rgb weight, reflect, transmit;
};

Lobes lobes_of(const Layout& layout, const double* x) {
  Lobes lobes;
  lobes.factors.resize(layout.layers);
  int at = 0;
  for (const int k : layout.rough) lobes.factors[k].roughness = x[at++];
  for (const int k : layout.deep) lobes.factors[k].depth = std::exp(x[at++]);
  for (int c = 0; c < 3; ++c) {
    const int own = layout.channels == 3 ? c : 0;
    for (int k = 1; k < layout.layers; ++k) lobes.factors[k].albedo[c] = x[layout.tint(k, own)];
    lobes.weight[c] = x[layout.weight(own)];
    lobes.reflect[c] = x[layout.reflect(own)];
    if (layout.transmits) lobes.transmit[c] = x[layout.transmit(own)];
  }
  return lobes;
}

std::vector<Rgb> values_of(const Stack& stack, const Lobes& lobes, const std::vector<Cell>& cells) {
  const Stack second = spongecake_second_stack(stack, lobes.factors);
  std::vector<Rgb> values;
  for (const Cell& cell : cells) {
    Rgb sum;
    for (const Direction wo : cell.wo) sum += single_scattering(second, cell.wi, wo).layers;
    values.push_back(0.25 * (lobes.weight * sum) +
                     1 / kPi * (cell.reflected ? lobes.reflect : lobes.transmit));
  }
  return values;
}

struct Difference {
  const Stack& stack;
  const Layout& layout;
  const std::vector<Cell>& cells;
  double scale;

  bool operator()(const double* const* x, double* residuals) const {
    const std::vector<Rgb> values = values_of(stack, lobes_of(layout, x[0]), cells);
    std::size_t at = 0;
    for (std::size_t k = 0; k < cells.size(); ++k)
      for (int c = 0; c < layout.channels; ++c) {
        residuals[at] = (values[k][c] - cells[k].truth[c]) / scale;
        if (!std::isfinite(residuals[at++])) return false;
      }
    return true;
  }
};

std::vector<Cell> cells_of(const std::vector<RunResult>& runs,
                           std::vector<SpongecakeResidue>& residues) {
  const double node[2] = {0.5 - std::sqrt(3.0) / 6, 0.5 + std::sqrt(3.0) / 6};
  std::vector<Cell> cells;
  for (const RunResult& run : runs)
    for (const bool reflected : {true, false}) {
      const SideResult& side = reflected ? run.reflected : run.transmitted;
      if (side.lobes[0].value.empty()) continue;
      const std::size_t count = run.grid.cells();
      const double sign = (run.incident.z > 0) == reflected ? 1 : -1;
      for (std::size_t k = 0; k < count; ++k) {
        Cell cell{.wi = run.incident,
                  .wo = {},
                  .truth = {},
                  .variance = {},
                  .reflected = reflected,
                  .residue = residues.size()};
        const int row = static_cast<int>(k) / run.grid.columns();
        const int column = static_cast<int>(k) % run.grid.columns();
        for (int n = 0; n < 4; ++n) {
          const double mu2 = 1 - (row + node[n / 2]) / run.grid.mu_cells;
          const double phi = 2 * kPi * (column + node[n % 2]) / run.grid.phi_cells;
          cell.wo[n] = direction_from_mu_phi(sign * std::sqrt(mu2), azimuth(run.incident) + phi);
        }
        for (int c = 0; c < 3; ++c) {
          const std::size_t at = (run.channels == 3 ? c : 0) * count + k;
          for (int o = 1; o < kTallyOrders; ++o) {
            cell.truth[c] += side.lobes[o].value[at];
            cell.variance[c] += std::pow(side.lobes[o].standard_error[at], 2);
          }
        }
        cells.push_back(cell);
      }
      residues.push_back({.wi = run.incident,
                          .reflected = reflected,
                          .energy_missing = luminance(missing_energy(run))});
    }
  return cells;
}

std::string text_of(Rgb c) {
  return c.is_grey() ? fmt::format("{:.6g}", c.r)
                     : fmt::format("{:.6g},{:.6g},{:.6g}", c.r, c.g, c.b);
}

std::string request_of(const Layout& layout, const Lobes& lobes) {
  std::string text = fmt::format("spongecake,second_weight={},lambert_reflect={}",
                                 text_of(lobes.weight), text_of(lobes.reflect));
  if (layout.transmits) text += fmt::format(",lambert_transmit={}", text_of(lobes.transmit));
  for (const int k : layout.rough)
    text += fmt::format(",second_roughness_{}={:.6g}", k + 1, lobes.factors[k].roughness);
  for (const int k : layout.deep)
    text += fmt::format(",second_depth_{}={:.6g}", k + 1, lobes.factors[k].depth);
  for (int k = 1; k < layout.layers; ++k)
    text += fmt::format(",second_albedo_{}={}", k + 1, text_of(lobes.factors[k].albedo));
  return text;
}

}  // namespace

SpongecakeFit fit_spongecake(const Stack& stack, const std::vector<RunResult>& runs) {
  SpongecakeFit fit;
  const std::vector<Cell> cells = cells_of(runs, fit.residues);
  Layout layout{.layers = static_cast<int>(stack.layers.size()),
                .channels = runs.front().channels,
                .rough = {},
                .deep = {},
                .transmits = stack.is_open_below()};
  std::vector<double> own;  // roughness or g of the layers in `rough`
  std::vector<bool> particle;
  for (int k = 0; k < layout.layers; ++k) {
    const Layer& layer = stack.layers[k];
    const bool hg = std::holds_alternative<HenyeyGreenstein>(layer.medium);
    const char* key = hg ? "g" : "roughness";
    if (layer.parameters.has(key) && layer.parameters.number(key) != 0) {
      layout.rough.push_back(k);
      own.push_back(layer.parameters.number(key));
      particle.push_back(hg);
    }
    if (std::isfinite(layer.depth()) && layer.depth() > 0) layout.deep.push_back(k);
  }
  double square = 0;
  for (const Cell& cell : cells)
    for (int c = 0; c < layout.channels; ++c) square += cell.truth[c] * cell.truth[c];
  const double scale = std::sqrt(square);
  if (!(scale > 0)) throw std::invalid_argument("the stack has no multiple scattering to fit");

  double least = std::numeric_limits<double>::infinity();
  Lobes best;
  for (const bool rough : {false, true}) {
    std::vector<double> x(layout.size(), 0.0);
    std::vector<std::pair<double, double>> bounds(x.size(), {0.0, kLargestFactor});
    int at = 0;
    for (std::size_t k = 0; k < own.size(); ++k, ++at) {
      const double most = (particle[k] ? kLargestG : 1.0) / std::abs(own[k]);
      bounds[at] = {particle[k] ? -most : std::min(1.0, kLeastRoughness / own[k]), most};
      x[at] = particle[k] ? (rough ? 0.3 : 0.9) : rough ? most : std::min(1.3, most);
    }
    for (std::size_t k = 0; k < layout.deep.size(); ++k, ++at)
      bounds[at] = {-std::log(kLargestFactor), std::log(kLargestFactor)};
    for (std::size_t k = at; k < x.size(); ++k)
      x[k] = static_cast<int>(k) < layout.weight(0) ? 1 : 0.3;

    ceres::Problem problem;
    auto* cost = new ceres::DynamicNumericDiffCostFunction<Difference, ceres::CENTRAL>(
        new Difference{stack, layout, cells, scale});
    cost->AddParameterBlock(layout.size());
    cost->SetNumResiduals(static_cast<int>(cells.size()) * layout.channels);
    problem.AddResidualBlock(cost, nullptr, x.data());
    for (std::size_t k = 0; k < x.size(); ++k) {
      // Numbers within the bounds by more than a step of differentiation.
      const double margin = 1e-5 * (std::abs(bounds[k].first) + std::abs(bounds[k].second)) * 0.5;
      const bool tight = static_cast<int>(k) < static_cast<int>(own.size());
      const double low = bounds[k].first + (tight ? margin : 0);
      const double high = bounds[k].second - (tight ? margin : 0);
      problem.SetParameterLowerBound(x.data(), static_cast<int>(k), low);
      problem.SetParameterUpperBound(x.data(), static_cast<int>(k), high);
      x[k] = std::clamp(x[k], low, high);
    }
    ceres::Solver::Options options;
    options.max_num_iterations = 100;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    fit.iterations += static_cast<int>(summary.iterations.size());
    if (summary.final_cost < least) {
      least = summary.final_cost;
      best = lobes_of(layout, x.data());
    }
  }
  fit.request = request_of(layout, best);

  const std::vector<Rgb> values = values_of(stack, best, cells);
  std::vector<double> error(fit.residues.size()), truth(fit.residues.size()),
      noise(fit.residues.size());
  double all_error = 0, all_noise = 0;
  std::vector<double> counts(fit.residues.size());
  for (std::size_t k = 0; k < cells.size(); ++k)
    for (int c = 0; c < layout.channels; ++c) {
      const std::size_t r = cells[k].residue;
      error[r] += std::pow(values[k][c] - cells[k].truth[c], 2);
      truth[r] += std::pow(cells[k].truth[c], 2);
      noise[r] += cells[k].variance[c];
      const double weight =
          layout.channels == 1 ? 1 : kLuminanceWeights[static_cast<std::size_t>(c)];
      counts[r] += weight;
      fit.residues[r].energy_truth += kPi * weight * cells[k].truth[c];
      fit.residues[r].energy_model += kPi * weight * values[k][c];
    }
  double walk_noise = 0;
  for (const double n : noise) walk_noise += n;
  fit.walk_noise = std::sqrt(walk_noise / square);
  // What cut walks held belongs to an unknown place: at worst to one cell of each side.
  std::size_t next = 0;
  for (const RunResult& run : runs)
    for (const SideResult* side : {&run.reflected, &run.transmitted}) {
      if (side->lobes[0].value.empty()) continue;
      const Rgb missing = missing_energy(run);
      for (int c = 0; c < layout.channels; ++c)
        noise[next] += std::pow(missing[c] / run.grid.projected_solid_angle(), 2);
      ++next;
    }
  for (std::size_t r = 0; r < fit.residues.size(); ++r) {
    SpongecakeResidue& residue = fit.residues[r];
    residue.energy_truth /= counts[r];
    residue.energy_model /= counts[r];
    residue.relative_rmse = truth[r] > 0 ? std::sqrt(error[r] / truth[r]) : 0;
    residue.noise = truth[r] > 0 ? std::sqrt(noise[r] / truth[r]) : 0;
    all_error += error[r];
    all_noise += noise[r];
  }
  fit.relative_rmse = std::sqrt(all_error / square);
  fit.noise = std::sqrt(all_noise / square);
  return fit;
}

}  // namespace lamella
