#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "compare/files/exr_image.h"
#include "phase/math/direction.h"
#include "volume/result/run_result.h"

namespace lamella {

/// Numbers of several incident directions in one block, [direction][channel] or
/// [direction][channel][cell], with their standard errors, or the solver's bounds; none where they
/// are not known.
struct LobeBlock {
  std::string side;  ///< "reflect" or "transmit"; empty where an energy has none
  /// "1", "2", "3", "4+", "all", "0", "1+", "2+"; of energies "specular", ..., too
  std::string name;
  std::vector<double> value, standard_error;
};

/// The lobes of several incident directions of one stack on the same cells.
struct LobeSet {
  std::vector<Direction> directions;
  CellGrid grid;
  int channels = 1;
  std::vector<LobeBlock> lobes;     ///< cosine-weighted means of f [1/sr] over the cells
  std::vector<LobeBlock> energies;  ///< shares of the light that comes in
  /// As the header of an EXR file has them, but for the names of files.
  std::map<std::string, std::string> attributes;

  /// The block, or nullptr. `name` may be what an EXR file calls it: "order1", "order4plus".
  [[nodiscard]] const LobeBlock* lobe(const std::string& side, const std::string& name) const;
};

/// Takes the lobes out of the runs, one after the other, so that no second copy of all of them is
/// ever there; the rest of the runs stays. The runs have equal grids and channels. Attributes are
/// left empty.
[[nodiscard]] LobeSet take_lobes(std::vector<RunResult>& runs);

/// Adds what each lobe's cells sum to as its energy, the error not known.
void add_cell_energies(LobeSet& set);

/// The channels of an EXR file, with the set's attributes.
[[nodiscard]] ExrImage lobe_image(const LobeSet& set);

/// Reads a file of `simulate` or `compare` back: the values are floats then, and energies are those
/// of lobes, the sums over their cells. `part`: of a file of `compare`, "truth" (also if empty),
/// "model", "difference" or "z". Throws OutputError with the file's name.
[[nodiscard]] LobeSet read_lobes(const std::filesystem::path& path, const std::string& part = "");

}  // namespace lamella
