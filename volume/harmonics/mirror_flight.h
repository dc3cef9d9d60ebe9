#pragma once

#include <vector>

#include "volume/harmonics/circle_points.h"
#include "volume/harmonics/mirror_layers.h"

namespace lamella {

/// One pair of directions of MirrorPairs: the integrand, circle by circle.
class MirrorFlight {
 public:
  /// layers: outlives this.
  MirrorFlight(const MirrorLayers& layers, Direction wi, Direction wo);
  MirrorFlight(const MirrorFlight&) = delete;
  MirrorFlight& operator=(const MirrorFlight&) = delete;

  /// The integral over the circle of w' with this cosine with the axis, but for 1 / (|mu_i|
  /// |mu_o|). Relative error about 3e-8.
  [[nodiscard]] Rgb circle(double cosine);
  /// Cosines, sorted, from -1 to 1, between which the integrals are smooth.
  [[nodiscard]] const std::vector<double>& breaks() const { return breaks_; }

 private:
  // Vectors p + q cos + r sin.
  struct Circle;

  void event(std::size_t k, int which, Direction fixed, double sign, const Circle& circle);
  void add_arc(const Circle& circle, bool above, double* sum);
  [[nodiscard]] double near_horizon(Direction w) const;

  const MirrorLayers& layers_;
  Direction wi_, wo_;
  bool from_above_;
  double longest_;  // panel
  std::vector<CircleLayer> met_;
  std::vector<double> breaks_;
  CirclePanels panels_;
  // Of one circle.
  std::vector<CircleMirror> mirrors_;
  std::vector<CircleWave> squares_;
  std::vector<std::vector<double>> areas_;
  std::vector<const double*> of_areas_;
  std::vector<CircleZero> zeros_;
  std::vector<double> scratch_;
  CircleTask task_{};
};

}  // namespace lamella
