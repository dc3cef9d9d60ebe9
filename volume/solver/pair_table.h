#pragma once

#include <memory>
#include <optional>
#include <span>

#include "volume/solver/deterministic.h"

namespace lamella {

/// Cosines of a pair of directions, neither 0; below the stack they are negative.
struct CosinePair {
  double mu_i, mu_o;
};

/// f [1/sr] of orders 2 and up, and what DeterministicField::multiple has of the orders below, for
/// very many scattered pairs of directions: the modes of a field on a table of elevations, with
/// polynomials of degree 7 between them, in both elevations and panel by panel.
///
/// Panels are halved towards grazing, where light varies like mu log mu; within the lowest one the
/// elevation grows as the cube of the parameter. Where fewer incident cosines are asked for than a
/// table would have, they are the table's, and nothing is interpolated between them.
///
/// The error of a pair is the largest of the field's own bounds in its panels, plus four times the
/// largest deviation from the field at kTests x kTests of the pairs' own cosines, the extreme ones
/// among them, relative to DeterministicField::scale.
class PairTable {
 public:
  /// Cosines of each side at which a table is held against the field: two or three for each of the
  /// nine panels of the first table, at the price of less than 576 pairs that share their cosines.
  static constexpr int kTests = 24;

  /// The coarsest table whose deviation leaves the error that the solution has within its
  /// tolerance, or at most doubles it. Nothing where there is none, where so few pairs are cheaper
  /// one by one, and of steep media, whose order 2 each pair may integrate for itself.
  [[nodiscard]] static std::optional<PairTable> make(const DeterministicSolution& solution,
                                                     std::span<const CosinePair> pairs);

  /// The sum over all orders and its error. x = pi - phi. Nothing where both directions are in the
  /// lowest panels, or where modes that are left out, which a pair that is solved for itself may
  /// account for, are above twice the solution's error and bring the bound above its tolerance.
  [[nodiscard]] std::optional<DeterministicValue> at(CosinePair pair, double x) const;

  /// What four times the largest deviation was.
  [[nodiscard]] double deviation() const { return deviation_; }
  /// Cosines of the table, incident and outgoing.
  [[nodiscard]] std::size_t incident() const;
  [[nodiscard]] std::size_t outgoing() const;

 private:
  struct Table;
  std::shared_ptr<const Table> table_;
  double deviation_ = 0, allowed_ = 0;
};

}  // namespace lamella
