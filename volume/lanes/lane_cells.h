#pragma once

// The cell that leaving light counts in. Only for sources of lamella_lanes().

#include "phase/lanes/lane_math.h"
#include "volume/lanes/lane_task.h"

namespace lamella::LAMELLA_ISA {

/// Row times columns plus column of light that leaves along -w_i, see CellGrid.
LAMELLA_INLINE Words cell_of(const LaneCells& cells, Vec3<Floats> wi) {
  // w_o = -w_i: half a turn further than w_i.
  Floats turns = turns_of(wi.y, wi.x) + Floats(0.5f - cells.azimuth_turns);
  turns = turns - floor(turns);
  if (cells.folded) turns = min(turns, Floats(1) - turns);
  const Floats row = min(nonnegative((Floats(1) - wi.z * wi.z) * Floats(cells.rows)),
                         Floats(static_cast<float>(cells.rows) - 0.5f));
  const Floats column =
      min(turns * Floats(cells.phi_cells), Floats(static_cast<float>(cells.columns) - 0.5f));
  return to_words(row) * Words(cells.columns) + to_words(column);
}

}  // namespace lamella::LAMELLA_ISA
