#pragma once

#include <functional>
#include <vector>

#include "phase/math/color.h"

namespace lamella {

/// A range of mu in [0, 1] and of phi [radians].
struct MuPhiRange {
  double mu0, mu1, phi0, phi1;
};

/// Where peaks are narrow, and drawn out along mu: parts that touch the azimuth `phi` are halved
/// until they are no wider than `width`, and about a peak until they are no longer than `length`
/// either (radians; width 0: there is no ridge).
struct Ridge {
  double phi = 0, width = 0, length = 0;
};

/// Cosine-weighted mean over a range of mu and phi.
struct CellMean {
  Rgb value;
  Rgb error;               ///< estimate, absolute
  bool exhausted = false;  ///< stopped short of the tolerance, at the largest number of parts
};

/// Mean of f(mu, phi), weighted by mu, over a range: tensor Gauss-Legendre rules of 4 x 4 points on
/// parts that are halved both ways where they differ most from 3 x 3 points, until those
/// differences sum to less than `tolerance` (absolute, per channel). `peak`: where f may be sharp,
/// (mu, phi); parts that hold it, edges included, are halved towards it before any is judged.
/// `kinks`: ascending cosines at which f behaves like the root of the distance; parts end there.
/// `ridge`: an azimuth along which f may be narrow for many mu.
[[nodiscard]] CellMean cell_mean(const std::function<Rgb(double mu, double phi)>& f,
                                 const MuPhiRange& range, Rgb tolerance,
                                 const std::vector<std::pair<double, double>>& peaks,
                                 const std::vector<double>& kinks = {}, const Ridge& ridge = {});

}  // namespace lamella
