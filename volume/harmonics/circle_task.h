#pragma once

#include "phase/lanes/isa.h"

namespace lamella {

/// A trigonometric polynomial of an azimuth: of 1, cos, sin, cos 2, sin 2.
struct CircleWave {
  double a = 0, b = 0, c = 0, d = 0, e = 0;
};

/// The kernel of mirrors along a circle of w', D(h) / 4 times Schlick's factor and the albedo, of
/// the first event and the second.
struct CircleMirror {
  bool is_sggx;
  bool is_constant;       ///< D = 1 / pi: flakes without an axis
  CircleWave square[2];   ///< |h|^2
  CircleWave other[2];    ///< SGGX: h^T S^-1 h, vMF: h . axis
  double scale;           ///< D / 4: SGGX's where |h|^2 = h^T S^-1 h, vMF's largest
  double least, largest;  ///< SGGX: of |h|^2 / h^T S^-1 h
  double kappa;
  bool has_schlick;
  double albedo[3], f0[3];
};

/// A layer, in the order that light from w_i meets them.
struct CircleLayer {
  int mirror;           ///< which, or -1
  int area;             ///< which of the projected areas
  double depth;         ///< infinite, too
  double a, b;          ///< rates along w_i and w_o, per depth
  double enter, leave;  ///< attenuation outside of the layer, of the light that comes and goes
};

/// Points on each panel of a circle: of Gauss and Legendre, on (-1, 1).
inline constexpr int kCirclePoints = 8;
struct CircleRule {
  double place[kCirclePoints], weight[kCirclePoints];
};

/// The sum over points of an arc, all on one side of the horizon, of weight K K I / |mu'|
/// (volume/harmonics/mirror_pairs.h), by channel.
struct CircleTask {
  int panels;
  const double *cosine, *sine, *half;  ///< of the panels' middles; half of their lengths, <= pi / 4
  const CircleRule* rule;
  CircleWave mu;  ///< |mu'|
  int mirrors, areas, layers, channels;
  const CircleMirror* mirror;
  const CircleWave* square_of_area;  ///< of SGGX flakes
  const double* const* area;         ///< of others, at the points; null for SGGX
  const CircleLayer* layer;
  bool onward;      ///< whether w' goes on as the light came
  bool reflects;    ///< whether w_o is on the side of w_i
  double* scratch;  ///< circle_scratch numbers
  double* sum;
};

[[nodiscard]] constexpr int circle_scratch(int mirrors, int areas, int channels) {
  return kCirclePoints * (2 * mirrors * channels + areas + channels);
}

/// On lanes; circle_sum.h has it with doubles.
LAMELLA_LANE_FUNCTION(void, circle_sum_lanes, (const CircleTask& task))

}  // namespace lamella
