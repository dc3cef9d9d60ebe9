#include "volume/harmonics/harmonic_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "phase/math/larger_error.h"
#include "phase/stack/single_scattering.h"
#include "volume/harmonics/axial_normals.h"
#include "volume/harmonics/harmonic_solution.h"
#include "volume/solver/closed_cells.h"
#include "volume/solver/distinct_channels.h"

namespace lamella {
namespace {

// Degrees that are tried one after the other; each solution is the bound of the one before.
constexpr int kDegrees[] = {12, 17, 24, 34, 48, 68, 96};
// A change of the degree changes the time by about this power of its ratio.
constexpr double kGrowth = 4;
// Light that grazes more than this is solved as if it did not.
constexpr double kLowest = 1e-6;
// Share of the tolerance for the quadrature of order 1 over cells.
constexpr double kFirstShare = 0.1;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Narrow distributions change nothing at low degrees: the first one that is worth its time.
std::size_t first_level(const Stack& stack) {
  const double width = narrowest_feature(stack);
  return width > 0.4 ? 0 : width > 0.2 ? 1 : width > 0.08 ? 2 : 3;
}

// One direction in one channel.
struct Answer {
  HarmonicEnergies energies;
  std::array<HarmonicCells, 2> sides;  // up, down
};

struct Level {
  int degree = 0;
  std::vector<std::vector<Answer>> answers;  // by distinct channel and direction
};

class Refinement {
 public:
  Refinement(const Stack& stack, const Plan& plan, std::span<const Direction> incident,
             CellGrid grid, const HarmonicOptions& options)
      : stack_(stack), plan_(plan), grid_(grid), options_(options) {
    for (Direction w : incident) {
      w = with_grazing_limit(w);
      if (std::abs(w.z) < kLowest)
        w = direction_from_mu_phi(std::copysign(kLowest, w.z), azimuth(w));
      incident_.push_back(w);
      lowest_ = std::min(lowest_, std::abs(w.z));
    }
    DistinctChannels distinct = distinct_channels(stack);
    channels_ = std::move(distinct.channels);
    channel_of_ = distinct.channel_of;
  }

  std::vector<RunResult> run() {
    const std::size_t begin = first_level(stack_);
    for (std::size_t k = begin; k < std::size(kDegrees); ++k) {
      const double before = seconds_since(start_);
      if (!solve(kDegrees[k])) {
        accuracy_.limit = DeterministicLimit::interrupted;
        break;
      }
      if (k == begin) solve_first();
      judge();
      if (accuracy_.reached) break;
      const double took = seconds_since(start_) - before;
      if (k + 1 == std::size(kDegrees) || kDegrees[k + 1] > options_.max_degree) {
        accuracy_.limit = DeterministicLimit::modes;
        break;
      }
      const double next =
          took * std::pow(static_cast<double>(kDegrees[k + 1]) / kDegrees[k], kGrowth);
      if (seconds_since(start_) + next > options_.max_seconds) {
        accuracy_.limit = DeterministicLimit::time;
        break;
      }
    }
    return results();
  }

 private:
  // Whether it was done before it was stopped; the first is done in any case.
  bool solve(int degree) {
    try {
      solve_level(degree, now_.answers.empty() ? nullptr : options_.stop);
      return true;
    } catch (const HarmonicStopped&) {
      return false;
    }
  }

  void solve_level(int degree, const std::atomic<bool>* stop) {
    Level next{degree, {}};
    for (const int channel : channels_) {
      const HarmonicTransport transport(
          stack_, channel,
          {.degree = degree,
           .depth_nodes = std::min(9, 6 + static_cast<int>(levels_)),
           .finest = std::min(1e-4, lowest_ / 4),
           .residual = std::clamp(options_.tolerance / 100, 1e-12, 1e-8),
           .isa = options_.isa,
           .stop = stop});
      next.answers.emplace_back();
      for (const Direction wi : incident_) {
        if (options_.report)
          options_.report({.nodes = degree,
                           .modes = degree + 1,
                           .error = levels_ > 0 ? accuracy_.error : 1,
                           .seconds = seconds_since(start_)});
        const HarmonicSolution solution(transport, wi);
        Answer answer{solution.energies(), {}};
        for (const bool up : {true, false})
          if (sees(wi, up)) answer.sides[up ? 0 : 1] = solution.cells(grid_, up);
        next.answers.back().push_back(std::move(answer));
      }
    }
    before_ = std::move(now_);
    now_ = std::move(next);
    ++levels_;
  }

  [[nodiscard]] bool sees(Direction wi, bool up) const {
    return up == (wi.z > 0) || plan_.transmits;
  }

  // Order 1 in closed form, to a share of the tolerance.
  void solve_first() {
    for (std::size_t i = 0; i < incident_.size(); ++i)
      for (const bool up : {true, false}) {
        first_.emplace_back();
        if (!sees(incident_[i], up)) continue;
        const Direction wi = incident_[i];
        const auto order = [&](Direction wo) {
          const SingleScattering f = single_scattering(stack_, wi, wo);
          return f.layers + f.substrate;
        };
        std::vector<Rgb> allowed(grid_.rows());
        for (int row = 0; row < grid_.rows(); ++row) {
          Rgb sum;
          constexpr int kAround = 16;
          const double mu = (grid_.edge_mu(row) + grid_.edge_mu(row + 1)) / 2;
          for (int k = 0; k < kAround; ++k)
            sum += 1.0 / kAround *
                   order(direction_from_mu_phi(up ? mu : -mu, 2 * kPi * (k + 0.5) / kAround));
          for (int c = 0; c < 3; ++c)
            allowed[row][c] =
                kFirstShare * options_.tolerance * (sum[c] + row_mean(channel_of_[c], i, up, row));
        }
        first_.back() = closed_cells(stack_, grid_, wi, up, allowed, order);
      }
  }

  // Of orders 2 and up.
  [[nodiscard]] double row_mean(int channel, std::size_t i, bool up, int row) const {
    const HarmonicCells& cells = now_.answers[channel][i].sides[up ? 0 : 1];
    double sum = 0;
    for (int column = 0; column < grid_.columns(); ++column)
      for (const std::vector<double>& order : cells.value)
        sum += order[row * grid_.columns() + column];
    return sum / grid_.columns();
  }

  [[nodiscard]] const std::vector<CellMean>& first_of(std::size_t i, bool up) const {
    return first_[2 * i + (up ? 0 : 1)];
  }

  // The bound of one cell: order by order for lobes of their own, and of all.
  [[nodiscard]] double changed(int channel, std::size_t i, bool up, int cell) const {
    const HarmonicCells& cells = now_.answers[channel][i].sides[up ? 0 : 1];
    double error = cells.error[cell];
    for (int k = 0; k < kHarmonicOrders; ++k) {
      const double before = before_.answers.empty()
                                ? 0
                                : before_.answers[channel][i].sides[up ? 0 : 1].value[k][cell];
      error += std::abs(cells.value[k][cell] - before);
    }
    return error;
  }

  void judge() {
    accuracy_.error = 0;
    accuracy_.energy_defect = 0;
    for (std::size_t k = 0; k < channels_.size(); ++k)
      for (std::size_t i = 0; i < incident_.size(); ++i) {
        accuracy_.energy_defect =
            larger_error(accuracy_.energy_defect, std::abs(now_.answers[k][i].energies.sum() - 1));
        for (const bool up : {true, false})
          if (sees(incident_[i], up))
            accuracy_.error = larger_error(accuracy_.error, worst(k, i, up));
      }
    accuracy_.node_error = accuracy_.error;
    accuracy_.reached =
        accuracy_.error <= options_.tolerance && accuracy_.energy_defect <= options_.tolerance;
  }

  // The largest bound of a cell, relative to the mean of its row.
  [[nodiscard]] double worst(std::size_t k, std::size_t i, bool up) const {
    const std::vector<CellMean>& first = first_of(i, up);
    const int channel = channels_[k];
    double worst = 0;
    for (int row = 0; row < grid_.rows(); ++row) {
      double scale = row_mean(static_cast<int>(k), i, up, row), error = 0;
      for (int column = 0; column < grid_.columns(); ++column) {
        const int cell = row * grid_.columns() + column;
        scale += first[cell].value[channel] / grid_.columns();
        error = larger_error(
            error, changed(static_cast<int>(k), i, up, cell) + first[cell].error[channel]);
      }
      if (scale > 0) worst = larger_error(worst, error / scale);
    }
    return worst;
  }

  std::vector<RunResult> results() {
    accuracy_.seconds = seconds_since(start_);
    accuracy_.nodes = std::max(32, now_.degree + 8);
    accuracy_.modes = now_.degree + 1;
    accuracy_.harmonics = now_.degree;
    accuracy_.channel_modes.fill(accuracy_.modes);
    std::vector<RunResult> runs(incident_.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
      RunResult& run = runs[i];
      run.incident = incident_[i];
      run.estimator = Estimator::deterministic;
      run.grid = grid_;
      run.channels = plan_.channels;
      run.seconds = accuracy_.seconds / static_cast<double>(runs.size());
      run.accuracy = accuracy_;
      run.accuracy->error = 0;
      for (const bool reflected : {true, false}) {
        const bool up = (incident_[i].z > 0) == reflected;
        SideResult& side = reflected ? run.reflected : run.transmitted;
        if (sees(incident_[i], up)) fill_lobes(side, i, up);
        fill_energies(side, i, up);
        if (sees(incident_[i], up))
          for (int c = 0; c < plan_.channels; ++c)
            run.accuracy->error = larger_error(run.accuracy->error, worst(channel_of_[c], i, up));
      }
      double defect = 0;
      for (int c = 0; c < plan_.channels; ++c) {
        const HarmonicEnergies& e = now_.answers[channel_of_[c]][i].energies;
        run.uncollided[c] = {e.uncollided, 0};
        run.absorbed[c] = {e.absorbed, bound_of(channel_of_[c], i, [](const HarmonicEnergies& x) {
                             return x.absorbed;
                           })};
        defect = larger_error(defect, std::abs(e.sum() - 1));
      }
      run.accuracy->energy_defect = defect;
      run.accuracy->reached =
          run.accuracy->error <= options_.tolerance && defect <= options_.tolerance;
    }
    return runs;
  }

  // An energy's last change, and what the ledger lacks.
  template <class Energy>
  [[nodiscard]] double bound_of(int channel, std::size_t i, const Energy& energy) const {
    const HarmonicEnergies& e = now_.answers[channel][i].energies;
    const double before =
        before_.answers.empty() ? 0 : energy(before_.answers[channel][i].energies);
    return std::abs(energy(e) - before) + std::abs(e.sum() - 1);
  }

  void fill_energies(SideResult& side, std::size_t i, bool up) const {
    for (int c = 0; c < plan_.channels; ++c) {
      const int channel = channel_of_[c];
      const auto of = [&](const auto& energy) {
        return Estimate{energy(now_.answers[channel][i].energies), bound_of(channel, i, energy)};
      };
      for (int order = 0; order < 4; ++order)
        side.orders[order][c] =
            of([&](const HarmonicEnergies& e) { return (up ? e.up : e.down)[order]; });
      side.total[c] = of([&](const HarmonicEnergies& e) {
        double sum = 0;
        for (const double x : up ? e.up : e.down) sum += x;
        return sum;
      });
    }
  }

  void fill_lobes(SideResult& side, std::size_t i, bool up) const {
    const int cells = grid_.cells();
    for (int lobe = 0; lobe <= kTallyOrders; ++lobe) {
      side.lobes[lobe].value.assign(static_cast<std::size_t>(plan_.channels) * cells, 0);
      side.lobes[lobe].standard_error = side.lobes[lobe].value;
    }
    for (int c = 0; c < plan_.channels; ++c)
      for (int cell = 0; cell < cells; ++cell) {
        const std::size_t at = static_cast<std::size_t>(c) * cells + cell;
        const CellMean& first = first_of(i, up)[cell];
        side.lobes[0].value[at] = first.value[c];
        side.lobes[0].standard_error[at] = first.error[c];
        double all = first.value[c];
        const double error = changed(channel_of_[c], i, up, cell);
        const HarmonicCells& solved = now_.answers[channel_of_[c]][i].sides[up ? 0 : 1];
        for (int k = 0; k < kHarmonicOrders; ++k) {
          side.lobes[k + 1].value[at] = solved.value[k][cell];
          side.lobes[k + 1].standard_error[at] = error;
          all += solved.value[k][cell];
        }
        side.lobes[Order::all].value[at] = all;
        side.lobes[Order::all].standard_error[at] = error + first.error[c];
      }
  }

  const Stack& stack_;
  const Plan& plan_;
  CellGrid grid_;
  HarmonicOptions options_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::vector<Direction> incident_;
  double lowest_ = 1;
  std::vector<int> channels_;
  std::array<int, 3> channel_of_{};
  Level now_, before_;
  std::size_t levels_ = 0;
  std::vector<std::vector<CellMean>> first_;  // by direction, up and down
  DeterministicAccuracy accuracy_{};
};

}  // namespace

double narrowest_feature(const Stack& stack) {
  double width = 1;
  for (const Layer& layer : stack.layers) {
    if (layer.interface || layer.depth() == 0) continue;
    const auto normals = axial_normals(layer.medium);
    width =
        std::min(width, normals ? normals->width : 1 - std::abs(traits(layer.medium).mean_cosine));
  }
  return width;
}

std::optional<std::string> why_not_harmonic(const Stack& stack) {
  if (stack.has_grid()) return "a grid varies a layer's density laterally";
  if (stack.grains()) return "the stack is explicit geometry";
  if (stack.has_boundaries())
    return "interfaces and surfaces other than Lambert's beside layers without symmetry about the "
           "normal are left to walks";
  for (const Layer& layer : stack.layers) {
    if (layer.interface || layer.depth() == 0) continue;
    if (auto reason = why_no_harmonics(layer.medium)) return reason;
    if (std::isinf(layer.depth()) && !traits(layer.medium).two_sided)
      return "a half space of tilted one-sided flakes is left to walks";
  }
  return std::nullopt;
}

std::vector<RunResult> harmonic_runs(const Stack& stack, const Plan& plan,
                                     std::span<const Direction> incident, CellGrid grid,
                                     const HarmonicOptions& options) {
  if (const auto reason = why_not_harmonic(stack)) throw std::invalid_argument(*reason);
  grid.folded = plan.folded && grid.phi_cells % 2 == 0;
  return Refinement(stack, plan, incident, grid, options).run();
}

}  // namespace lamella
