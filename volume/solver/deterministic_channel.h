#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "volume/adding/stack_modes.h"
#include "volume/adding/stack_solver.h"
#include "volume/solver/deterministic.h"
#include "volume/solver/mode_tail.h"
#include "volume/solver/second_order.h"

// What the solution and its fields share; not for users of volume/solver/deterministic.h.

namespace lamella {

/// Indices of refraction above a stack and below it.
struct OuterIndices {
  double above = 1, below = 1;
  explicit OuterIndices(const Stack& stack);
};

/// The distinct |mu| of a list, by side where the indices differ, and the place of each entry among
/// them.
struct Cosines {
  std::vector<double> distinct;
  std::vector<AskedCosine> asked;  ///< the same with their indices
  std::vector<std::size_t> place;
  Cosines(std::span<const double> mu, const OuterIndices& indices);
};

/// Orders 2, 3 and 4+ of one azimuthal mode. Order 2 in two parts: what SecondOrder counts, and
/// the rest (empty matrices where there is none). Orders 0 and 1 where a boundary is rough, else
/// empty: what closed_orders does not have.
struct OrderModes {
  Parts second, second_rest, third, higher;
  Parts zero, first;
};

struct DeterministicField::Channel {
  std::vector<OrderModes> modes;
  Parts mean;  // of all orders
  std::array<double, 4> faint;
  Cosines in, out;
  std::vector<int> sign_in, sign_out;
  std::optional<SecondOrder> second;  // of steep media
  // Where the modes of order 2 were integrated directly: its modes beyond `modes`, the last of them
  // continued by their fit; how many of a pair's were integrated, their error, and what the fit's
  // error and the modes beyond leave, absolute. Else empty.
  std::vector<Parts> more_second;
  Parts second_count, second_error, second_left;

  [[nodiscard]] int part(std::size_t i, std::size_t o) const;
  /// What a pair's errors are relative to, see DeterministicField::scale; of a mean below 0, its
  /// size.
  [[nodiscard]] double scale(int part, Eigen::Index row, Eigen::Index column) const {
    return std::max(std::abs(mean[part](row, column)), faint[part]);
  }
  /// How far a mean is below 0, where no light is: that much at least it is wrong by.
  [[nodiscard]] double below_zero(int part, Eigen::Index row, Eigen::Index column) const {
    return std::max(0.0, -mean[part](row, column));
  }
  /// What the modes of a pair leave to those beyond, by how they fall.
  struct Tails {
    ModeTail second, third, others;
  };
  [[nodiscard]] Tails tails(int part, Eigen::Index row, Eigen::Index column) const;
  [[nodiscard]] bool has_integrated_modes() const { return second_error[0].size() > 0; }
  /// Replaces the modes of order 2 that `second` counts, as many as it needs. tolerance: relative
  /// to scale. Where `stop` is set before all are there, all stay as they are.
  void integrate_second(double tolerance, const std::atomic<bool>* stop);
};

/// Whether order 2 is integrated directly at every pair, given the error of its modes from the
/// nodes: beyond six digits that is cheaper than nodes enough for its kernels.
[[nodiscard]] inline bool is_second_integrated(double second_error, double tolerance) {
  return tolerance < 1e-6 && second_error > tolerance / 4;
}

[[nodiscard]] int part_of(double mu_i, double mu_o);
[[nodiscard]] const Series& part_of(const LayerOperator& op, int part);

/// Whether a kernel is too steep for few modes: mirror flakes, a narrow forward peak.
[[nodiscard]] bool is_steep(const Medium& medium);

}  // namespace lamella
