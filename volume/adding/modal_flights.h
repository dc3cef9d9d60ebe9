#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/adding/layer_eigenmodes.h"
#include "volume/algebra/matrix_product.h"

namespace lamella {

/// Directions at a layer: cosines, projected areas, and the share of a beam that crosses it.
struct LayerDirections {
  Eigen::VectorXd mu, sigma, direct;
  LayerDirections(Eigen::VectorXd cosines, Eigen::VectorXd areas, double depth);
};

/// Integrals over the depth t of a layer (0 to T) of mode k's exponentials and the beam exp(-beta
/// t), beta = sigma / mu, of directions (rows).
struct FlightTables {
  Eigen::MatrixXd against;  ///< integral of exp(-t / nu) exp(-beta t) dt / (mu nu)
  Eigen::MatrixXd along;    ///< integral of exp(-t / nu) exp(-beta (T - t)) dt / (mu nu)
  Eigen::MatrixXd meet;     ///< 1 / (mu + nu sigma)
  FlightTables(const LayerDirections& directions, const Eigen::VectorXd& nu, double depth);
};

/// The same for two beams, rows: w_o, columns: w_i.
struct PairTables {
  Eigen::MatrixXd back;   ///< integral of exp(-(alpha + beta) t) dt / (mu_i mu_o)
  Eigen::MatrixXd on;     ///< integral of exp(-alpha t) exp(-beta (T - t)) dt / (mu_i mu_o)
  Eigen::MatrixXd apart;  ///< 1 / (sigma_o mu_i - sigma_i mu_o), 0 for the pairs that are near
  struct Place {
    Eigen::Index row, column;
  };
  std::vector<Place> near;  ///< pairs whose alpha and beta are too close for a difference
  PairTables(const LayerDirections& out, const LayerDirections& in, double depth);
};

/// By how much the event of a unit beam excites each mode, or each mode's event a direction: rows:
/// directions, columns: modes.
struct Amplitudes {
  Eigen::MatrixXd forward;   ///< the mode that runs the beam's way
  Eigen::MatrixXd backward;  ///< the mode that runs the other way
  /// on, back: the kernel between directions (rows) and nodes (columns).
  Amplitudes(const Eigen::Ref<const Eigen::MatrixXd>& on,
             const Eigen::Ref<const Eigen::MatrixXd>& back, const LayerEigenmodes& modes,
             const DirectionSets& sets, const MatrixProduct& product);
  Amplitudes(const Eigen::Ref<const Eigen::MatrixXd>& on,
             const Eigen::Ref<const Eigen::MatrixXd>& back, const FreeFlights& flights);
};

/// f of reflected and transmitted light [1/sr].
struct Lobes {
  Eigen::MatrixXd r, t;
};

/// Light that is scattered, runs along the modes inside the layer, and is scattered out; what the
/// layer's faces let go does not come back. With free flights this is order 2.
[[nodiscard]] Lobes along_modes(const Amplitudes& out, const Amplitudes& in,
                                const FlightTables& flights_out, const FlightTables& flights_in,
                                const LayerDirections& directions_out,
                                const LayerDirections& directions_in, const PairTables& pairs,
                                const Eigen::VectorXd& nu, double depth,
                                const MatrixProduct& product);

}  // namespace lamella
