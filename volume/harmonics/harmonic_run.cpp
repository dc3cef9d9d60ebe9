#include "volume/harmonics/harmonic_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "phase/math/larger_error.h"
#include "volume/harmonics/bounded_cells.h"
#include "volume/harmonics/harmonic_degrees.h"
#include "volume/harmonics/harmonic_lobes.h"
#include "volume/harmonics/pair_cells.h"
#include "volume/solver/closed_cells.h"
#include "volume/solver/closed_orders.h"

namespace lamella {
namespace {

// Share of the tolerance for the quadrature of order 1 over cells.
constexpr double kFirstShare = 0.03;
// This number of cells has order 2 integrated over pairs of mirrors without a look at the clock;
// for more of them a sample tells what all would take.
constexpr std::size_t kFewPairCells = 200, kSampledCells = 8;
// The sample ends early where its first cells take this many times what is left.
constexpr double kHopeless = 4;
// Shares of the tolerance for what mirrors scatter twice: of harmonics, which are kept within it,
// and of its quadrature.
constexpr double kSecondShare = 0.3, kPairShare = 0.13;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class Refinement {
 public:
  Refinement(const Stack& stack, const Plan& plan, std::span<const Direction> incident,
             CellGrid grid, const HarmonicOptions& options)
      : stack_(stack),
        grid_(grid),
        options_(options),
        pairs_(stack, options.isa),
        lobes_(stack, plan, incident, grid) {
    if (stack.has_boundaries()) cosines_.emplace(grid, stack);
  }

  std::vector<RunResult> run() {
    const std::size_t begin = first_degree(stack_);
    for (std::size_t k = begin; k < std::size(kHarmonicDegrees); ++k) {
      const double before = seconds_since(start_);
      if (!solve(kHarmonicDegrees[k])) {
        accuracy_.limit = DeterministicLimit::interrupted;
        break;
      }
      const double took = seconds_since(start_) - before;
      if (k == begin) solve_first();
      judge();
      if (!accuracy_.reached && solve_pairs(true)) judge();
      if (accuracy_.reached) break;
      if (k + 1 == std::size(kHarmonicDegrees) || kHarmonicDegrees[k + 1] > options_.max_degree) {
        accuracy_.limit = DeterministicLimit::modes;
        break;
      }
      if (next_bytes(k) > static_cast<double>(options_.max_bytes)) {
        accuracy_.limit = DeterministicLimit::memory;
        break;
      }
      const double next = took * growth(k);
      if (seconds_since(start_) + next > options_.max_seconds) {
        accuracy_.limit = DeterministicLimit::time;
        break;
      }
    }
    if (!accuracy_.reached && !is_stopped() && solve_pairs(false)) judge();
    accuracy_.seconds = seconds_since(start_);
    accuracy_.bytes = levels().last().bytes;
    accuracy_.nodes = std::max(32, levels().last().degree + 8);
    accuracy_.modes = levels().last().degree + 1;
    accuracy_.harmonics = levels().last().degree;
    accuracy_.channel_modes.fill(accuracy_.modes);
    return lobes_.results(accuracy_, options_.tolerance);
  }

 private:
  [[nodiscard]] const HarmonicLevels& levels() const { return lobes_.levels; }
  [[nodiscard]] const std::vector<Direction>& incident() const { return lobes_.incident(); }
  [[nodiscard]] bool is_stopped() const { return options_.stop && *options_.stop; }

  [[nodiscard]] HarmonicResolution resolution_at(int degree, const std::atomic<bool>* stop) const {
    HarmonicResolution resolution = resolution_of(degree, levels().count(), lobes_.lowest(),
                                                  options_.tolerance, options_.isa, stop);
    resolution.is_even = is_even(stack_, incident());
    return resolution;
  }

  // Of the solution after that of degree k: that of the operators of boundaries grows; without
  // boundaries it is told beforehand.
  [[nodiscard]] double next_bytes(std::size_t k) const {
    if (cosines_) return static_cast<double>(levels().last().bytes) * growth_of_operators(k);
    const HarmonicResolution next = resolution_at(kHarmonicDegrees[k + 1], nullptr);
    return static_cast<double>(bytes_of_open(stack_, lobes_.channels(), next));
  }

  // Whether it was done before it was stopped; the first is done in any case.
  bool solve(int degree) {
    try {
      solve_level(degree, levels().count() == 0 ? nullptr : options_.stop);
      return true;
    } catch (const HarmonicStopped&) {
      return false;
    }
  }

  // Rows of cells that wanted more elevations have them in the next solution; the first, which
  // takes little, is repeated until they are enough.
  void solve_level(int degree, const std::atomic<bool>* stop) {
    HarmonicLevel next{degree, 0, {}};
    if (cosines_) cosines_->refine();
    const HarmonicResolution resolution = resolution_at(degree, stop);
    if (!cosines_) next.bytes = bytes_of_open(stack_, lobes_.channels(), resolution);
    const LayerKernels kernels(HarmonicTransport::basis_of(resolution),
                               MatrixProduct(options_.isa));
    do {
      next.answers.clear();
      SharedBoundaries boundaries;
      for (const int channel : lobes_.channels()) {
        if (cosines_)
          solve_bounded(channel, resolution, kernels, boundaries, next);
        else
          solve_open(channel, resolution, kernels, next);
      }
    } while (levels().count() == 0 && cosines_ && cosines_->refine());
    lobes_.levels.add(std::move(next));
  }

  void solve_open(int channel, const HarmonicResolution& resolution, const LayerKernels& kernels,
                  HarmonicLevel& level) const {
    const HarmonicTransport transport(stack_, channel, resolution, &kernels);
    level.answers.emplace_back();
    for (std::size_t i = 0; i < incident().size(); ++i) {
      report(resolution.degree);
      const HarmonicSolution solution(transport, incident()[i]);
      HarmonicAnswer answer{solution.energies(), {}};
      for (const bool up : {true, false})
        if (lobes_.sees(i, up))
          answer.sides[up ? 0 : 1] = solution.cells(grid_, up, options_.tolerance);
      level.answers.back().push_back(std::move(answer));
    }
  }

  void solve_bounded(int channel, const HarmonicResolution& resolution, const LayerKernels& kernels,
                     SharedBoundaries& boundaries, HarmonicLevel& level) {
    const BoundedTransport transport(stack_, channel, resolution, cosines_->asked(), incident(),
                                     &kernels, &boundaries);
    level.bytes = std::max(level.bytes, transport.surroundings().bytes());
    level.answers.emplace_back();
    for (std::size_t i = 0; i < incident().size(); ++i) {
      report(resolution.degree);
      const BoundedSolution solution(transport, i, incident()[i]);
      HarmonicAnswer answer{solution.energies(), {}};
      for (const bool up : {true, false})
        if (lobes_.sees(i, up))
          answer.sides[up ? 0 : 1] =
              cosines_->means(solution, up, azimuth(incident()[i]), options_.tolerance);
      level.answers.back().push_back(std::move(answer));
    }
  }

  void report(int degree) const {
    if (options_.report)
      options_.report({.nodes = degree,
                       .modes = degree + 1,
                       .error = levels().count() > 0 ? accuracy_.error : 1,
                       .seconds = seconds_since(start_)});
  }

  // What is closed (ClosedOrders), to a share of the tolerance.
  void solve_first() {
    for (std::size_t i = 0; i < incident().size(); ++i)
      for (const bool up : {true, false}) {
        lobes_.closed.emplace_back();
        if (!lobes_.sees(i, up)) continue;
        const Direction wi = incident()[i];
        const auto order = [&](Direction wo) { return closed_orders(stack_, wi, wo).all(); };
        std::vector<Rgb> allowed(grid_.rows());
        for (int row = 0; row < grid_.rows(); ++row) {
          Rgb sum;
          constexpr int kAround = 16;
          const double mu = (grid_.edge_mu(row) + grid_.edge_mu(row + 1)) / 2;
          for (int k = 0; k < kAround; ++k)
            sum += 1.0 / kAround *
                   order(direction_from_mu_phi(up ? mu : -mu, 2 * kPi * (k + 0.5) / kAround));
          for (int c = 0; c < 3; ++c)
            allowed[row][c] = kFirstShare * options_.tolerance *
                              (sum[c] + lobes_.row_mean(lobes_.channel_of(c), i, up, row));
        }
        lobes_.closed.back() = closed_cells(stack_, grid_, wi, up, allowed, order);
      }
  }

  // Cells of one side that want it.
  struct PairSide {
    std::size_t i;
    bool up;
    std::vector<int> cells;
    std::vector<Rgb> allowed;  // by row
  };

  [[nodiscard]] std::vector<std::optional<CellMean>> means_of(const PairSide& side,
                                                              const std::vector<int>& cells) const {
    return pair_cells(pairs_, grid_, incident()[side.i], side.up, cells, side.allowed,
                      narrowest_feature(stack_), options_.stop);
  }

  // Whether the time allows it. Once begun it goes on: what a later degree adds is little.
  [[nodiscard]] bool may_integrate(const std::vector<PairSide>& sides, std::size_t count) const {
    const int degree = levels().last().degree;
    if (options_.integrate_from)
      return *options_.integrate_from > 0 && degree >= *options_.integrate_from;
    if (count <= kFewPairCells || accuracy_.integrated_from > 0) return true;
    double expected = 0;
    for (const PairSide& side : sides) {
      if (side.cells.empty()) continue;
      expected += expected_time(side);
      if (seconds_since(start_) + expected > options_.max_seconds) return false;
    }
    return true;
  }

  // Of all cells of a side [seconds].
  [[nodiscard]] double expected_time(const PairSide& side) const {
    if (const auto seconds =
            expected_seconds(pairs_, grid_, incident()[side.i], side.up, side.cells, side.allowed,
                             options_.tolerance, narrowest_feature(stack_)))
      return *seconds;
    const double begin = seconds_since(start_);
    const std::size_t step = std::max<std::size_t>(1, side.cells.size() / kSampledCells);
    std::size_t sampled = 0;
    double expected = 0;
    for (std::size_t k = step / 2; k < side.cells.size(); k += step) {
      static_cast<void>(means_of(side, {side.cells[k]}));
      const double now = seconds_since(start_);
      expected =
          (now - begin) * static_cast<double>(side.cells.size()) / static_cast<double>(++sampled);
      if (expected > kHopeless * (options_.max_seconds - now)) break;
    }
    return expected;
  }

  // What mirrors scatter twice, by quadrature, wherever the harmonics leave more of it than a share
  // of the tolerance, unless that would take too long. if_enough: only if that is all that is
  // missing.
  bool solve_pairs(bool if_enough) {
    if (cosines_ || pairs_.is_empty()) return false;
    std::vector<PairSide> sides;
    for (std::size_t i = 0; i < incident().size(); ++i)
      for (const bool up : {true, false}) {
        if (!lobes_.sees(i, up)) continue;
        PairSide side{i, up, {}, {}};
        for (int row = 0; row < grid_.rows(); ++row) {
          Rgb scale;
          for (int c = 0; c < 3; ++c)
            scale[c] = options_.tolerance * lobes_.scale_of(c, i, up, row);
          side.allowed.push_back(kPairShare * scale);
          for (int column = 0; column < grid_.columns(); ++column) {
            const int cell = row * grid_.columns() + column;
            if (if_enough && !would_reach(i, up, cell, scale)) return false;
            bool is_needed = false;
            for (int c = 0; c < 3; ++c)
              is_needed = is_needed || lobes_.error_of(c, i, up, cell, 0) > kSecondShare * scale[c];
            if (is_needed && !lobes_.pairs_of(i, up, cell)) side.cells.push_back(cell);
          }
        }
        sides.push_back(std::move(side));
      }
    std::size_t count = 0;
    for (const PairSide& side : sides) count += side.cells.size();
    if (count == 0 || !may_integrate(sides, count)) return false;
    if (accuracy_.integrated_from == 0) accuracy_.integrated_from = levels().last().degree;
    for (const PairSide& side : sides) {
      report(levels().last().degree);
      const auto means = means_of(side, side.cells);
      for (std::size_t k = 0; k < means.size(); ++k)
        lobes_.pairs[2 * side.i + (side.up ? 0 : 1)][side.cells[k]] = means[k];
    }
    return true;
  }

  // Whether all but what mirrors scatter twice is known well enough.
  [[nodiscard]] bool would_reach(std::size_t i, bool up, int cell, Rgb tolerance) const {
    for (int c = 0; c < 3; ++c) {
      double error = kPairShare * tolerance[c] + lobes_.closed_of(i, up)[cell].error[c];
      for (const int part : {1, 2, kWithoutPairs})
        error += levels().error(lobes_.channel_of(c), i, up, cell, part);
      if (error > tolerance[c]) return false;
    }
    return true;
  }

  void judge() {
    accuracy_.error = 0;
    accuracy_.energy_defect = 0;
    for (int c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < incident().size(); ++i) {
        accuracy_.energy_defect =
            larger_error(accuracy_.energy_defect, std::abs(lobes_.energies_of(c, i).sum() - 1));
        for (const bool up : {true, false})
          if (lobes_.sees(i, up))
            accuracy_.error = larger_error(accuracy_.error, lobes_.worst(c, i, up));
      }
    accuracy_.node_error = accuracy_.error;
    accuracy_.reached =
        accuracy_.error <= options_.tolerance && accuracy_.energy_defect <= options_.tolerance;
  }

  const Stack& stack_;
  CellGrid grid_;
  HarmonicOptions options_;
  std::optional<CellCosines> cosines_;  // where there are boundaries
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  MirrorPairs pairs_;
  HarmonicLobes lobes_;
  DeterministicAccuracy accuracy_{};
};

}  // namespace

std::vector<RunResult> harmonic_runs(const Stack& stack, const Plan& plan,
                                     std::span<const Direction> incident, CellGrid grid,
                                     const HarmonicOptions& options) {
  if (const auto reason = why_not_harmonic(stack)) throw std::invalid_argument(*reason);
  grid.folded = plan.folded && grid.phi_cells % 2 == 0;
  return Refinement(stack, plan, incident, grid, options).run();
}

}  // namespace lamella
