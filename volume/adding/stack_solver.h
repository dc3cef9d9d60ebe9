#pragma once

#include <array>
#include <memory>
#include <span>

#include "phase/stack/stack.h"
#include "volume/adding/pile_operator.h"

namespace lamella {

/// Energies of beams along the incoming directions that were asked for, one entry each. Series as
/// in PileSeries, diffuse light and deltas apart.
struct AskedEnergies {
  std::array<Eigen::VectorXd, kPileSeries> reflected, transmitted;
  BeamSeries mirrored;     ///< as beams; empty: none
  Eigen::VectorXd direct;  ///< straight on, of order 0
  Eigen::VectorXd absorbed, lost;
};

/// One azimuthal mode of a stack between the directions that were asked for.
struct AskedMode {
  /// Series as in PileSeries; those of order 0 may be empty matrices.
  std::array<Parts, kPileSeries> series;
  /// For light from above and from below; mode 0 only.
  std::array<AskedEnergies, 2> energies;
};

/// A stack on fixed directions, for one colour channel, mode by mode.
class StackSolver {
 public:
  virtual ~StackSolver() = default;
  /// Makes the kernels of at least that many modes. `mode` needs them. The kernels depend on their
  /// number in the last digits: steps that are the same on any machine keep results so, too.
  virtual void prepare(int modes) = 0;
  /// Doubles the modes that are ready (8 at first), or adds as many as fit into that memory; false
  /// where none does.
  virtual bool prepare_more(std::size_t max_bytes) = 0;
  /// Modes whose kernels are there.
  [[nodiscard]] virtual int ready() const = 0;
  /// Bytes held by the kernels' modes.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
  /// One mode; several may be asked for at once.
  [[nodiscard]] virtual AskedMode asked_mode(int m) const = 0;
  /// The same, perhaps without the energies.
  [[nodiscard]] virtual AskedMode asked_series(int m) const { return asked_mode(m); }
};

/// The block of a matrix between directions that were asked for; nothing of nothing.
[[nodiscard]] inline Eigen::MatrixXd asked_block(const Eigen::MatrixXd& m, Eigen::Index row_nodes,
                                                 Eigen::Index column_nodes) {
  if (m.size() == 0) return {};
  return m.bottomRightCorner(m.rows() - row_nodes, m.cols() - column_nodes);
}

}  // namespace lamella
