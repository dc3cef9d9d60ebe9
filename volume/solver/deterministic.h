#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "phase/lanes/isa.h"
#include "phase/math/order.h"
#include "phase/stack/stack.h"
#include "volume/result/accuracy.h"

namespace lamella {

/// What the solver is doing, for whoever waits.
struct SolverProgress {
  enum class Task { nodes, cells, pairs } task = Task::nodes;
  int nodes = 0;  ///< of the solution in work, per hemisphere
  int modes = 0;  ///< of them solved so far
  double error =
      1;  ///< what coarser nodes reached, relative to DeterministicField::scale; 1: none yet
  double share = 0;    ///< of the cells or pairs that are done
  double seconds = 0;  ///< since the task began
};
/// Called every now and then, in the thread that asked for the solution.
using SolverReport = std::function<void(const SolverProgress&)>;

struct DeterministicOptions {
  double tolerance = 1e-6;  ///< of f, relative to DeterministicField::scale
  int min_nodes = 8;        ///< nodes per hemisphere to begin with
  int max_nodes = 256;
  int max_modes = 1024;  ///< azimuthal modes
  /// Of them with max_nodes, per colour channel: where a run that is repeated ended.
  std::array<int, 3> last_modes{1024, 1024, 1024};
  double max_seconds = 60;  ///< a finer solution is not begun where it would end later, and is cut
                            ///< short at twice that
  std::size_t max_bytes = std::size_t{1} << 30;  ///< of the kernels' tables
  Isa isa = Isa::scalar;  ///< of products of matrices: the last digits depend on it
  const std::atomic<bool>* stop = nullptr;  ///< once set, refinement ends with what was reached
  SolverReport report{};
};

/// The places of an OrderMap that the solver fills in every stack: orders `one` to `all`.
inline constexpr int kSolvedOrders = place(Order::all) + 1;

/// f [1/sr] by order; deltas are left out. Where a boundary is rough all of them hold what
/// ClosedOrders leaves.
struct DeterministicValue {
  OrderMap<Rgb> order;
  Rgb zero;   ///< of order 0, light that met boundaries alone; part of the sum
  Rgb error;  ///< absolute, of all orders together: nodes, and this pair's own tail of modes
  bool exact_second = false;  ///< order 2 was integrated directly
};

/// Shares of what arrives from one direction. absorbed follows from the absorption in the layers,
/// not from the others, so that their sum is a check.
struct DeterministicEnergies {
  OrderMap<Rgb> reflected, transmitted;
  Rgb uncollided, absorbed;
  /// Lost to the depth of a half space (one-sided flakes that face down), by order like the others.
  OrderMap<Rgb> escaped;
  /// Of order 0, which has met boundaries alone; part of the sums over all orders.
  Rgb zero_reflected, zero_transmitted, zero_escaped;
  /// The part of what is reflected that is a delta; `zero` too.
  OrderMap<Rgb> specular_of;
  Rgb lost;  ///< by single scattering at rough boundaries

  [[nodiscard]] Rgb sum() const {
    return reflected[Order::all] + transmitted[Order::all] + uncollided + absorbed +
           escaped[Order::all] + lost;
  }
};

/// The largest mean of cos(m x) over an interval so wide [radians].
[[nodiscard]] inline double share_in_mean(double m, double width) {
  return m * width > 2 ? 2 / (m * width) : 1;
}

/// Solved modes for lists of incoming and outgoing cosines: f at any azimuth is a short sum.
class DeterministicField {
 public:
  /// f for incoming cosine i and outgoing cosine o of the lists. x = pi - phi, phi the azimuth of
  /// w_o relative to w_i. Without closed_orders: order 1 is left at 0 unless a boundary is rough.
  [[nodiscard]] DeterministicValue multiple(std::size_t i, std::size_t o, double x) const;
  /// The error of `multiple` in means over azimuths so far [radians] apart: modes that were left
  /// out count by what such a mean leaves of them.
  [[nodiscard]] double error_of_mean(int channel, std::size_t i, std::size_t o, double width) const;
  /// The same, but where the medium is steep (mirror flakes, a narrow forward peak) and the modes
  /// of order 2 left out would add more than the tolerance, that order is integrated directly
  /// (volume/solver/second_order.h; milliseconds), and the fit of volume/solver/mode_tail.h stands
  /// for what is left out of order 3.
  [[nodiscard]] DeterministicValue multiple_refined(std::size_t i, std::size_t o, double x) const;
  /// Mode m of the orders 2, 3 and 4 and more (1 to 3; 4: their sum) [1/sr]: f = sum over m of
  /// (2 - [m = 0]) f_m cos(m x). What an average over cells of phi needs. Where a boundary is rough
  /// order 0 stands for order 1, 5 for order 0 but for its closed part, and 4 holds them all.
  [[nodiscard]] double mode(int channel, int order, int m, std::size_t i, std::size_t o) const;
  /// Mean over the azimuth of all orders, the first included.
  [[nodiscard]] double mean(int channel, std::size_t i, std::size_t o) const;
  /// What errors are relative to: the mean, or a hundred-millionth of the brightest probe's between
  /// the same two sides where that is more (one-sided flakes seen from behind scatter as good as
  /// nothing).
  [[nodiscard]] double scale(int channel, std::size_t i, std::size_t o) const;
  [[nodiscard]] int modes(int channel) const;

 private:
  friend class DeterministicSolution;
  // Per distinct channel: [mode][order 2, 3, 4+], rows o, columns i; then the mean of all.
  struct Channel;
  std::vector<std::shared_ptr<const Channel>> channels_;
  std::array<int, 3> channel_of_{};
  std::vector<double> mu_i_, mu_o_;
  double tolerance_ = 0, error_ = 0, second_error_ = 0;
  bool is_first_closed_ = true;

  [[nodiscard]] DeterministicValue evaluate(std::size_t i, std::size_t o, double x,
                                            bool may_integrate) const;
};

/// Light in a stack that is symmetric about z, by adding and doubling over azimuthal modes; the
/// derivation is in volume/DETERMINISTIC.md. Single scattering is exact unless a boundary is rough;
/// orders 2, 3 and 4+ come from the modes, where the orders 1 to 3 are followed as such (successive
/// orders) and 4+ is the rest. Directions need not be nodes: each becomes a direction without
/// weight, which receives the exact integral of the source function.
class DeterministicSolution {
 public:
  /// f for one pair, mu = 0 as the limit from above, not both. Many pairs are cheaper by `field`.
  [[nodiscard]] DeterministicValue f(Direction wi, Direction wo) const;
  /// The modes for every pair of these cosines (negative: below). Cost grows with the number of
  /// distinct |mu|, those of mu_o counting most.
  /// second_integrated: where `multiple_refined` would integrate order 2 directly, its modes are
  /// integrated here (milliseconds per pair of cosines), for users of `mode` and `multiple`, who
  /// else owe it the error of the nodes, DeterministicAccuracy::second_error. Where `stop` is set
  /// before that is done, it is left out.
  [[nodiscard]] DeterministicField field(std::span<const double> mu_i, std::span<const double> mu_o,
                                         bool second_integrated = false,
                                         const std::atomic<bool>* stop = nullptr) const;
  /// One entry per incoming cosine.
  [[nodiscard]] std::vector<DeterministicEnergies> energies(std::span<const double> mu_i) const;

  [[nodiscard]] const DeterministicAccuracy& accuracy() const { return accuracy_; }
  /// What was asked for, see DeterministicOptions.
  [[nodiscard]] double tolerance() const { return tolerance_; }
  /// Whether `field` integrates order 2 where it is asked to, as its modes from the nodes are short
  /// of the tolerance.
  [[nodiscard]] bool integrates_second() const;
  [[nodiscard]] const Stack& stack() const { return stack_; }

 private:
  friend DeterministicSolution solve_deterministic(const Stack&, const DeterministicOptions&);
  Stack stack_;
  DeterministicAccuracy accuracy_;
  double tolerance_ = 0;
  Isa isa_ = Isa::scalar;
  bool steep_ = false;
  std::vector<int> channels_;                     // distinct ones
  std::array<int, 3> channel_of_{};               // index into channels_
  std::array<int, 3> modes_{};                    // per distinct channel
  std::array<std::array<double, 4>, 3> faint_{};  // per distinct channel and pair of sides
};

/// Why the method does not apply, if it does not: the stack is not symmetric about z, or holds
/// delta flakes (mirrors at roughness 0).
[[nodiscard]] std::optional<std::string> why_not_deterministic(const Stack& stack);

/// Refines nodes and modes until f changes by less than the tolerance. Throws
/// std::invalid_argument where the method does not apply.
[[nodiscard]] DeterministicSolution solve_deterministic(const Stack& stack,
                                                        const DeterministicOptions& options = {});

}  // namespace lamella
