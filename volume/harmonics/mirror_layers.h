#pragma once

#include <optional>
#include <vector>

#include "phase/lanes/isa.h"
#include "phase/stack/stack.h"
#include "volume/harmonics/circle_task.h"

namespace lamella {

/// About which axis the circles lie that mirror_pairs.h integrates over. automatic: the axis of the
/// flakes, where all mirrors share one that is not the normal.
enum class MirrorCircles { automatic, about_normal };

/// What MirrorPairs knows of a stack before there are directions.
struct MirrorLayers {
  struct Part {
    const Medium* medium;
    int mirror;  ///< which of the mirrors, or -1
    int area;    ///< which of the media
    double depth;
  };
  MirrorLayers(const Stack& stack, Isa isa, MirrorCircles circles);
  MirrorLayers(const MirrorLayers&) = delete;
  MirrorLayers& operator=(const MirrorLayers&) = delete;

  Stack stack;
  std::vector<CircleMirror> mirrors;
  std::vector<const Medium*> of_mirror;
  std::vector<SggxMatrix<double>> inverses;  ///< of mirrors with SGGX
  std::vector<const Medium*> media;          ///< distinct ones, for their projected areas
  std::vector<Part> parts;                   ///< layers of any depth, from above
  Frame<double> frame{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  ///< of circles about n; t.z is 0
  bool about_normal = true;
  /// Where circles lie about the flakes' axis: whether a mirror image in a plane that holds it, or
  /// in the plane across it, leaves all media as they are.
  bool is_symmetric_about_axis = false, is_symmetric_across_axis = false;
  double longest;  ///< part of a circle [radians]
  /// Channels of the circles' sums; where albedos of all mirrors are multiples of one colour, one
  /// channel is enough, and `tint` times its sum is the colour.
  int channels = 1;
  Rgb tint = Rgb(1);
  void (*sum)(const CircleTask& task);

 private:
  void add(const Layer& layer);
  [[nodiscard]] std::optional<Direction> shared_axis() const;
  void find_symmetries();
  void find_colors();
};

/// Of flakes with these normals; null for all others.
template <class Ndf>
[[nodiscard]] const Ndf* normals_of(const Medium& medium) {
  if (const auto* m = std::get_if<MirrorFlakes<Ndf>>(&medium)) return &m->ndf;
  if (const auto* m = std::get_if<LambertFlakes<Ndf>>(&medium)) return &m->ndf;
  return nullptr;
}

}  // namespace lamella
