#pragma once

#include <memory>
#include <optional>

#include "volume/adding/layer_operator.h"
#include "volume/adding/modal_flights.h"
#include "volume/adding/third_order.h"

namespace lamella {

/// A homogeneous layer by its eigenmodes, in the place of doublings: the same equations on the same
/// nodes, solved exactly. For layers that are the same from both sides; what they absorb, and
/// energies to the last digit at albedo 1, are for doubling to say.
class ModalLayer {
 public:
  /// Between which directions: all; all, but order 3 between asked ones alone, as layers without
  /// interfaces need no more of it; asked ones alone.
  enum class Scope { all, layers, asked };

  /// Makes tables that serve all modes, but for those of order 3 in the scope `all`. orders: as in
  /// OperatorRules.
  ModalLayer(const LayerScattering& scattering, const DirectionSets& sets, double depth,
             Scope scope, int orders);

  /// Series of r and t, for light from either side; rows and columns: those of `sets`, or their
  /// asked ones. Nothing where there are no eigenmodes, or where albedo 1 and mode 0 cost them more
  /// than five digits. Several modes may be asked for at once.
  [[nodiscard]] std::optional<std::array<Series, 2>> series(const LayerScattering& scattering,
                                                            int mode,
                                                            const MatrixProduct& product) const;
  /// The same as an operator; not for the scope `asked`.
  [[nodiscard]] std::optional<LayerOperator> layer(const LayerScattering& scattering, int mode,
                                                   const MatrixProduct& product) const;

 private:
  // Order 1 and up between all columns and rows.
  [[nodiscard]] Lobes all_orders(const LayerEigenmodes& modes, const Parts& kernel,
                                 const Eigen::MatrixXd& on_out, const Eigen::MatrixXd& back_out,
                                 const MatrixProduct& product) const;

  const DirectionSets& sets_;
  double depth_;
  int orders_;
  Eigen::Index first_;        // row and column
  Eigen::Index first_third_;  // of order 3
  FreeFlights free_;
  LayerDirections out_, in_;
  PairTables pairs_;
  std::optional<FlightTables> free_out_, free_in_;
  std::optional<ThirdOrder> third_;
};

}  // namespace lamella
