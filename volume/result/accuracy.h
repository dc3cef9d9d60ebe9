#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <string>

namespace lamella {

/// What ended the refinement. numbers: the last solution has numbers that are not finite.
enum class DeterministicLimit { none, nodes, modes, time, memory, interrupted, numbers };

/// "nodes", "modes", "time", "memory", "interrupted" or "numbers"; empty where the tolerance was
/// reached.
[[nodiscard]] std::string to_text(DeterministicLimit limit);

/// The cost of a solution and the error that it reached.
struct DeterministicAccuracy {
  bool reached = false;                                 ///< whether error <= tolerance
  DeterministicLimit limit = DeterministicLimit::none;  ///< what stopped it short of that
  /// Of f, relative to DeterministicField::scale: the largest change under the last refinement of
  /// the nodes at probe directions (mu from 0.01 to 1, both grazing and straight on among them),
  /// plus what the azimuthal modes left out would add; never less than energy_defect. Infinite
  /// where no solution had finite numbers. DeterministicValue carries each pair's own.
  double error = 0;
  double node_error = 0;    ///< the part of `error` that the nodes leave
  double second_error = 0;  ///< of order 2 of steep media by its modes: apart from node_error
  /// The defect of the energies at the probes: the distance of their sum from 1, or of any below 0
  /// from 0, whichever is largest.
  double energy_defect = 0;
  int nodes = 0, modes = 0;  ///< modes: the most of any channel
  /// Degree of the spherical harmonics, where those have solved the stack; 0: adding and doubling.
  int harmonics = 0;
  /// Degree from which on cells have order 2 of mirrors integrated (volume/HARMONICS.md); 0: none.
  int integrated_from = 0;
  std::array<int, 3> channel_modes{};  ///< per colour channel
  double seconds = 0;
  std::size_t bytes = 0;  ///< of the kernels, the largest tables

  /// Whether the solution is an answer at all: its error is known, and the error of the nodes is no
  /// larger than f itself.
  [[nodiscard]] bool is_answer() const {
    return std::isfinite(error) && node_error <= 1 && energy_defect <= 1;
  }
};

}  // namespace lamella
