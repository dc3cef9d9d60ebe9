#include "volume/harmonics/harmonic_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "phase/math/larger_error.h"
#include "volume/harmonics/bounded_cells.h"
#include "volume/harmonics/harmonic_degrees.h"
#include "volume/harmonics/harmonic_levels.h"
#include "volume/harmonics/pair_cells.h"
#include "volume/solver/closed_cells.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/distinct_channels.h"

namespace lamella {
namespace {

// Share of the tolerance for the quadrature of order 1 over cells.
constexpr double kFirstShare = 0.1;
// This number of cells has order 2 integrated over pairs of mirrors without a look at the clock;
// for more of them a sample tells what all would take.
constexpr std::size_t kFewPairCells = 200, kSampledCells = 8;
// Shares of the tolerance for what mirrors scatter twice: of harmonics, which are kept within it,
// and of its quadrature.
constexpr double kSecondShare = 0.3, kPairShare = 0.2;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class Refinement {
 public:
  Refinement(const Stack& stack, const Plan& plan, std::span<const Direction> incident,
             CellGrid grid, const HarmonicOptions& options)
      : stack_(stack),
        plan_(plan),
        grid_(grid),
        options_(options),
        is_bounded_(stack.has_boundaries()),
        is_first_closed_(is_first_closed(stack)),
        pairs_(stack, options.isa),
        levels_(grid),
        pair_means_(2 * incident.size(),
                    std::vector<std::optional<CellMean>>(static_cast<std::size_t>(grid.cells()))) {
    for (Direction w : incident) {
      w = solvable(w);
      incident_.push_back(w);
      lowest_ = std::min(lowest_, std::abs(w.z));
    }
    DistinctChannels distinct = distinct_channels(stack);
    channels_ = std::move(distinct.channels);
    channel_of_ = distinct.channel_of;
  }

  std::vector<RunResult> run() {
    const std::size_t begin = first_degree(stack_);
    for (std::size_t k = begin; k < std::size(kHarmonicDegrees); ++k) {
      const double before = seconds_since(start_);
      if (!solve(kHarmonicDegrees[k])) {
        accuracy_.limit = DeterministicLimit::interrupted;
        break;
      }
      if (k == begin) solve_first();
      judge();
      if (!accuracy_.reached && solve_pairs(true)) judge();
      if (accuracy_.reached) break;
      const double took = seconds_since(start_) - before;
      if (k + 1 == std::size(kHarmonicDegrees) || kHarmonicDegrees[k + 1] > options_.max_degree) {
        accuracy_.limit = DeterministicLimit::modes;
        break;
      }
      const double next = took * growth(k);
      if (seconds_since(start_) + next > options_.max_seconds) {
        accuracy_.limit = DeterministicLimit::time;
        break;
      }
    }
    if (!accuracy_.reached && !is_stopped() && solve_pairs(false)) judge();
    return results();
  }

 private:
  [[nodiscard]] bool is_stopped() const { return options_.stop && *options_.stop; }

  // Whether it was done before it was stopped; the first is done in any case.
  bool solve(int degree) {
    try {
      solve_level(degree, levels_.count() == 0 ? nullptr : options_.stop);
      return true;
    } catch (const HarmonicStopped&) {
      return false;
    }
  }

  void solve_level(int degree, const std::atomic<bool>* stop) {
    HarmonicLevel next{degree, {}};
    for (const int channel : channels_) {
      const HarmonicResolution resolution =
          resolution_of(degree, levels_.count(), lowest_, options_.tolerance, options_.isa, stop);
      if (is_bounded_)
        solve_bounded(channel, resolution, next);
      else
        solve_open(channel, resolution, next);
    }
    levels_.add(std::move(next));
  }

  void solve_open(int channel, const HarmonicResolution& resolution, HarmonicLevel& level) const {
    const HarmonicTransport transport(stack_, channel, resolution);
    level.answers.emplace_back();
    for (const Direction wi : incident_) {
      report(resolution.degree);
      const HarmonicSolution solution(transport, wi);
      HarmonicAnswer answer{solution.energies(), {}};
      for (const bool up : {true, false})
        if (sees(wi, up)) answer.sides[up ? 0 : 1] = solution.cells(grid_, up);
      level.answers.back().push_back(std::move(answer));
    }
  }

  void solve_bounded(int channel, const HarmonicResolution& resolution,
                     HarmonicLevel& level) const {
    const CellCosines cosines(grid_, stack_);
    const BoundedTransport transport(stack_, channel, resolution, cosines.asked(), incident_);
    level.answers.emplace_back();
    for (std::size_t i = 0; i < incident_.size(); ++i) {
      report(resolution.degree);
      const BoundedSolution solution(transport, i, incident_[i]);
      HarmonicAnswer answer{solution.energies(), {}};
      for (const bool up : {true, false})
        if (sees(incident_[i], up))
          answer.sides[up ? 0 : 1] = cosines.means(solution, up, azimuth(incident_[i]));
      level.answers.back().push_back(std::move(answer));
    }
  }

  void report(int degree) const {
    if (options_.report)
      options_.report({.nodes = degree,
                       .modes = degree + 1,
                       .error = levels_.count() > 0 ? accuracy_.error : 1,
                       .seconds = seconds_since(start_)});
  }

  [[nodiscard]] bool sees(Direction wi, bool up) const {
    return up == (wi.z > 0) || (plan_.transmits && (up || is_open_below_));
  }

  // What is closed (ClosedOrders), to a share of the tolerance.
  void solve_first() {
    for (std::size_t i = 0; i < incident_.size(); ++i)
      for (const bool up : {true, false}) {
        first_.emplace_back();
        if (!sees(incident_[i], up)) continue;
        const Direction wi = incident_[i];
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
            allowed[row][c] =
                kFirstShare * options_.tolerance * (sum[c] + row_mean(channel_of_[c], i, up, row));
        }
        first_.back() = closed_cells(stack_, grid_, wi, up, allowed, order);
      }
  }

  // Of all that is not closed.
  [[nodiscard]] double row_mean(int channel, std::size_t i, bool up, int row) const {
    const HarmonicCells& cells = levels_.last().answers[channel][i].sides[up ? 0 : 1];
    double sum = 0;
    for (const int part : kSummedParts)
      if (!cells.value[part].empty())
        for (int column = 0; column < grid_.columns(); ++column)
          sum += cells.value[part][row * grid_.columns() + column];
    return sum / grid_.columns();
  }

  [[nodiscard]] const std::vector<CellMean>& first_of(std::size_t i, bool up) const {
    return first_[2 * i + (up ? 0 : 1)];
  }

  // Whether a cell's order 2 is the sum of what mirrors scatter twice, by quadrature, and the rest.
  [[nodiscard]] const std::optional<CellMean>& pairs_of(std::size_t i, bool up, int cell) const {
    return pair_means_[2 * i + (up ? 0 : 1)][cell];
  }

  // One of kSummedParts of a cell; 0 where there is none.
  [[nodiscard]] double value_of(int c, std::size_t i, bool up, int cell, int order) const {
    const HarmonicCells& cells = levels_.last().answers[channel_of_[c]][i].sides[up ? 0 : 1];
    const auto& pairs = pairs_of(i, up, cell);
    if (cells.value[order].empty()) return 0;
    if (order > 0 || !pairs) return cells.value[order][cell];
    return cells.value[kWithoutPairs][cell] + pairs->value[c];
  }
  [[nodiscard]] double error_of(int c, std::size_t i, bool up, int cell, int order) const {
    const auto& pairs = pairs_of(i, up, cell);
    if (order > 0 || !pairs) return levels_.error(channel_of_[c], i, up, cell, order);
    return levels_.error(channel_of_[c], i, up, cell, kWithoutPairs) + pairs->error[c];
  }

  // The mean of a row over all orders.
  [[nodiscard]] double scale_of(int c, std::size_t i, bool up, int row) const {
    double sum = row_mean(channel_of_[c], i, up, row);
    for (int column = 0; column < grid_.columns(); ++column)
      sum += first_of(i, up)[row * grid_.columns() + column].value[c] / grid_.columns();
    return sum;
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
    return pair_cells(pairs_, grid_, incident_[side.i], side.up, cells, side.allowed,
                      narrowest_feature(stack_), options_.stop);
  }

  // Whether the time allows it. Once begun it goes on: what a later degree adds is little.
  [[nodiscard]] bool may_integrate(const std::vector<PairSide>& sides, std::size_t count) const {
    const int degree = levels_.last().degree;
    if (options_.integrate_from)
      return *options_.integrate_from > 0 && degree >= *options_.integrate_from;
    if (count <= kFewPairCells || accuracy_.integrated_from > 0) return true;
    const double begin = seconds_since(start_);
    std::size_t sampled = 0;
    for (const PairSide& side : sides) {
      std::vector<int> some;
      const std::size_t step = std::max<std::size_t>(1, count / kSampledCells);
      for (std::size_t k = step / 2; k < side.cells.size(); k += step)
        some.push_back(side.cells[k]);
      static_cast<void>(means_of(side, some));
      sampled += some.size();
    }
    if (sampled == 0) return false;
    const double took = seconds_since(start_) - begin;
    return seconds_since(start_) +
               took * static_cast<double>(count) / static_cast<double>(sampled) <
           options_.max_seconds;
  }

  // What mirrors scatter twice, by quadrature, wherever the harmonics leave more of it than a share
  // of the tolerance, unless that would take too long. if_enough: only if that is all that is
  // missing.
  bool solve_pairs(bool if_enough) {
    if (is_bounded_ || pairs_.is_empty()) return false;
    std::vector<PairSide> sides;
    for (std::size_t i = 0; i < incident_.size(); ++i)
      for (const bool up : {true, false}) {
        if (!sees(incident_[i], up)) continue;
        PairSide side{i, up, {}, {}};
        for (int row = 0; row < grid_.rows(); ++row) {
          Rgb scale;
          for (int c = 0; c < 3; ++c) scale[c] = options_.tolerance * scale_of(c, i, up, row);
          side.allowed.push_back(kPairShare * scale);
          for (int column = 0; column < grid_.columns(); ++column) {
            const int cell = row * grid_.columns() + column;
            if (if_enough && !would_reach(i, up, cell, scale)) return false;
            bool is_needed = false;
            for (int c = 0; c < 3; ++c)
              is_needed = is_needed || error_of(c, i, up, cell, 0) > kSecondShare * scale[c];
            if (is_needed && !pairs_of(i, up, cell)) side.cells.push_back(cell);
          }
        }
        sides.push_back(std::move(side));
      }
    std::size_t count = 0;
    for (const PairSide& side : sides) count += side.cells.size();
    if (count == 0 || !may_integrate(sides, count)) return false;
    if (accuracy_.integrated_from == 0) accuracy_.integrated_from = levels_.last().degree;
    for (const PairSide& side : sides) {
      report(levels_.last().degree);
      const auto means = means_of(side, side.cells);
      for (std::size_t k = 0; k < means.size(); ++k)
        pair_means_[2 * side.i + (side.up ? 0 : 1)][side.cells[k]] = means[k];
    }
    return true;
  }

  // Whether all but what mirrors scatter twice is known well enough.
  [[nodiscard]] bool would_reach(std::size_t i, bool up, int cell, Rgb tolerance) const {
    for (int c = 0; c < 3; ++c) {
      double error = kPairShare * tolerance[c] + first_of(i, up)[cell].error[c];
      for (const int part : {1, 2, kWithoutPairs})
        error += levels_.error(channel_of_[c], i, up, cell, part);
      if (error > tolerance[c]) return false;
    }
    return true;
  }

  void judge() {
    accuracy_.error = 0;
    accuracy_.energy_defect = 0;
    for (int c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < incident_.size(); ++i) {
        accuracy_.energy_defect =
            larger_error(accuracy_.energy_defect, std::abs(energies_of(c, i).sum() - 1));
        for (const bool up : {true, false})
          if (sees(incident_[i], up))
            accuracy_.error = larger_error(accuracy_.error, worst(c, i, up));
      }
    accuracy_.node_error = accuracy_.error;
    accuracy_.reached =
        accuracy_.error <= options_.tolerance && accuracy_.energy_defect <= options_.tolerance;
  }

  [[nodiscard]] const HarmonicEnergies& energies_of(int c, std::size_t i) const {
    return levels_.last().answers[channel_of_[c]][i].energies;
  }

  // The largest bound of a cell, relative to the mean of its row.
  [[nodiscard]] double worst(int c, std::size_t i, bool up) const {
    double worst = 0;
    for (int row = 0; row < grid_.rows(); ++row) {
      double error = 0;
      for (int column = 0; column < grid_.columns(); ++column) {
        const int cell = row * grid_.columns() + column;
        double sum = first_of(i, up)[cell].error[c];
        for (const int part : kSummedParts) sum += error_of(c, i, up, cell, part);
        error = larger_error(error, sum);
      }
      const double scale = scale_of(c, i, up, row);
      if (scale > 0) worst = larger_error(worst, error / scale);
    }
    return worst;
  }

  std::vector<RunResult> results() {
    accuracy_.seconds = seconds_since(start_);
    accuracy_.nodes = std::max(32, levels_.last().degree + 8);
    accuracy_.modes = levels_.last().degree + 1;
    accuracy_.harmonics = levels_.last().degree;
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
            run.accuracy->error = larger_error(run.accuracy->error, worst(c, i, up));
      }
      double defect = 0;
      for (int c = 0; c < plan_.channels; ++c) {
        const HarmonicEnergies& e = energies_of(c, i);
        run.uncollided[c] = {e.uncollided, 0};
        if (e.lost > 0)
          run.lost[c] = {e.lost, levels_.bound_of(channel_of_[c], i, [](const HarmonicEnergies& x) {
                           return x.lost;
                         })};
        run.absorbed[c] = {e.absorbed,
                           levels_.bound_of(channel_of_[c], i,
                                            [](const HarmonicEnergies& x) { return x.absorbed; })};
        defect = larger_error(defect, std::abs(e.sum() - 1));
      }
      run.accuracy->energy_defect = defect;
      run.accuracy->reached =
          run.accuracy->error <= options_.tolerance && defect <= options_.tolerance;
    }
    return runs;
  }

  void fill_energies(SideResult& side, std::size_t i, bool up) const {
    const bool is_reflected = up == (incident_[i].z > 0);
    for (int c = 0; c < plan_.channels; ++c) {
      const int channel = channel_of_[c];
      const auto of = [&](const auto& energy) {
        return Estimate{energy(levels_.last().answers[channel][i].energies),
                        levels_.bound_of(channel, i, energy)};
      };
      for (int order = 0; order < 4; ++order)
        side.orders[order][c] =
            of([&](const HarmonicEnergies& e) { return (up ? e.up : e.down)[order]; });
      side.multiple[c] = of([&](const HarmonicEnergies& e) {
        const auto& orders = up ? e.up : e.down;
        double sum = 0;
        for (std::size_t order = 1; order < orders.size(); ++order) sum += orders[order];
        return sum;
      });
      side.total[c] = of([&](const HarmonicEnergies& e) {
        double sum = (up ? e.zero_up : e.zero_down) + (is_reflected ? e.mirrored : 0);
        for (const double x : up ? e.up : e.down) sum += x;
        return sum;
      });
      side.zero[c] = of([&](const HarmonicEnergies& e) {
        return (up ? e.zero_up : e.zero_down) + (is_reflected ? e.mirrored : 0);
      });
      if (is_reflected) side.specular[c] = {energies_of(c, i).mirrored, 0};
    }
  }

  void fill_lobes(SideResult& side, std::size_t i, bool up) const {
    const int cells = grid_.cells();
    for (int lobe = 0; lobe < kLobeOrders; ++lobe) {
      if (is_first_closed_ && (lobe == place(Order::zero) || lobe == place(Order::scattered)))
        continue;
      side.lobes[lobe].value.assign(static_cast<std::size_t>(plan_.channels) * cells, 0);
      side.lobes[lobe].standard_error = side.lobes[lobe].value;
    }
    for (int c = 0; c < plan_.channels; ++c)
      for (int cell = 0; cell < cells; ++cell) {
        const std::size_t at = static_cast<std::size_t>(c) * cells + cell;
        const auto put = [&](Order order, Estimate e) {
          side.lobes[order].value[at] = e.value;
          side.lobes[order].standard_error[at] = e.standard_error;
        };
        const auto part = [&](int which) {
          return Estimate{value_of(c, i, up, cell, which), error_of(c, i, up, cell, which)};
        };
        const auto sum = [](Estimate a, Estimate b) {
          return Estimate{a.value + b.value, a.standard_error + b.standard_error};
        };
        const CellMean& mean = first_of(i, up)[cell];
        const Estimate closed{mean.value[c], mean.error[c]};
        // What is closed is order 1, or of order 0 where a boundary is rough.
        const Estimate first = is_first_closed_ ? closed : part(kFirstPart);
        Estimate multiple;
        for (int order = 0; order < kHarmonicOrders; ++order) {
          put(static_cast<Order>(order + 1), part(order));
          multiple = sum(multiple, part(order));
        }
        put(Order::one, first);
        put(Order::multiple, multiple);
        Estimate all = sum(first, multiple);
        if (!is_first_closed_) {
          const Estimate zero = sum(closed, part(kZeroPart));
          put(Order::scattered, all);
          put(Order::zero, zero);
          all = sum(all, zero);
        }
        put(Order::all, all);
      }
  }

  const Stack& stack_;
  const Plan& plan_;
  CellGrid grid_;
  HarmonicOptions options_;
  bool is_bounded_, is_first_closed_;
  bool is_open_below_ = stack_.is_open_below();
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::vector<Direction> incident_;
  double lowest_ = 1;
  std::vector<int> channels_;
  std::array<int, 3> channel_of_{};
  MirrorPairs pairs_;
  HarmonicLevels levels_;
  std::vector<std::vector<CellMean>> first_;  // what is closed, by direction, up and down
  std::vector<std::vector<std::optional<CellMean>>> pair_means_;
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
