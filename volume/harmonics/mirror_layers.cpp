#include "volume/harmonics/mirror_layers.h"

#include <algorithm>
#include <cmath>

#include "volume/harmonics/axial_normals.h"
#include "volume/harmonics/circle_sum.h"

namespace lamella {
namespace {

// Of a vector with three components: the sum of the squares of a matrix's numbers bounds it.
double squares(const SggxMatrix<double>& m) {
  return m.a00 * m.a00 + m.a10 * m.a10 + m.a11 * m.a11 + m.a20 * m.a20 + m.a21 * m.a21 +
         m.a22 * m.a22;
}

bool are_parallel(Direction a, Direction b) {
  constexpr double kSame = 1e-12;
  const Direction off = cross(a, b);
  return dot(off, off) <= kSame * kSame;
}

// SGGX with S = I.
bool is_without_axis(const Medium& medium) {
  const Sggx* ndf = normals_of<Sggx>(medium);
  if (!ndf) return false;
  constexpr double kSame = 1e-12;
  const SggxMatrix<double>& a = ndf->matrix();
  return std::abs(a.a00 - 1) <= kSame && std::abs(a.a11 - 1) <= kSame &&
         std::abs(a.a22 - 1) <= kSame && std::abs(a.a10) <= kSame && std::abs(a.a20) <= kSame &&
         std::abs(a.a21) <= kSame;
}

}  // namespace

MirrorLayers::MirrorLayers(const Stack& given, Isa isa, MirrorCircles circles)
    : stack(given), longest(2 * kPi), sum(&circle_sum) {
  if (const auto on_lanes = circle_sum_lanes_for(isa)) sum = on_lanes;
  for (const Layer& layer : stack.layers)
    if (!layer.interface && layer.depth() > 0) add(layer);
  find_colors();
  if (circles == MirrorCircles::about_normal) return;
  constexpr double kUpright = 1e-3;  // sine of the angle to the normal
  const std::optional<Direction> axis = shared_axis();
  if (!axis) return;
  const double s = std::hypot(axis->x, axis->y);
  if (s < kUpright) return;
  about_normal = false;
  // Circles begin where they are highest.
  frame.n = *axis;
  frame.t = {-axis->y / s, axis->x / s, 0};
  frame.s = cross(frame.n, frame.t);
  find_symmetries();
}

void MirrorLayers::add(const Layer& layer) {
  const Medium& medium = layer.medium;
  Part part{&medium, -1, 0, layer.depth()};
  const auto same =
      std::find_if(media.begin(), media.end(), [&](const Medium* m) { return *m == medium; });
  part.area = static_cast<int>(same - media.begin());
  if (same == media.end()) media.push_back(&medium);
  CircleMirror mirror{};
  SggxMatrix<double> inverse{};
  mirror.has_schlick = !(layer.f0 == Rgb(1));
  for (int c = 0; c < 3; ++c) {
    mirror.albedo[c] = layer.albedo[c];
    mirror.f0[c] = layer.f0[c];
  }
  const auto* of_sggx = std::get_if<MirrorFlakes<Sggx>>(&medium);
  const auto* of_vmf = std::get_if<MirrorFlakes<Vmf>>(&medium);
  if (of_sggx) {
    const SggxMatrix<double>& a = of_sggx->ndf.matrix();
    inverse = a.inverse();
    mirror.is_sggx = true;
    mirror.is_constant = is_without_axis(medium);
    mirror.scale = 1 / (4 * kPi * a.determinant());
    mirror.least = 1 / squares(inverse);
    mirror.largest = squares(a);
  } else if (of_vmf) {
    mirror.kappa = vmf_concentration(of_vmf->ndf.alpha());
    mirror.scale = of_vmf->ndf.density_of(of_vmf->ndf.axis()) / 4;
    longest = std::min(longest, 2 * of_vmf->ndf.alpha());
  }
  if (of_sggx || of_vmf) {
    part.mirror = static_cast<int>(mirrors.size());
    mirrors.push_back(mirror);
    of_mirror.push_back(&medium);
    inverses.push_back(inverse);
  }
  parts.push_back(part);
}

void MirrorLayers::find_colors() {
  constexpr double kSame = 1e-15;
  Rgb strongest;
  for (const CircleMirror& m : mirrors) {
    const Rgb albedo(m.albedo[0], m.albedo[1], m.albedo[2]);
    if (albedo.max() > strongest.max()) strongest = albedo;
  }
  const double most = strongest.max();
  if (most == 0) return;
  const Rgb color = (1 / most) * strongest;
  const auto is_of_color = [&](const CircleMirror& m) {
    const double own = std::max({m.albedo[0], m.albedo[1], m.albedo[2]});
    for (int c = 0; c < 3; ++c)
      if (m.f0[c] != m.f0[0] || std::abs(m.albedo[c] - own * color[c]) > kSame) return false;
    return true;
  };
  if (!std::all_of(mirrors.begin(), mirrors.end(), is_of_color)) {
    channels = 3;
    return;
  }
  tint = color * color;
  for (CircleMirror& m : mirrors) m.albedo[0] = std::max({m.albedo[0], m.albedo[1], m.albedo[2]});
}

void MirrorLayers::find_symmetries() {
  is_symmetric_about_axis = is_symmetric_across_axis = true;
  for (const Medium* medium : media) {
    if (!has_normals(*medium)) continue;
    const std::optional<AxialNormals> normals = axial_normals(*medium);
    if (is_without_axis(*medium)) continue;
    if (!normals || !are_parallel(normals->axis, frame.n))
      is_symmetric_about_axis = is_symmetric_across_axis = false;
    if (normals_of<Vmf>(*medium)) is_symmetric_across_axis = false;
  }
}

std::optional<Direction> MirrorLayers::shared_axis() const {
  std::optional<Direction> shared;
  for (const Medium* medium : of_mirror) {
    const std::optional<AxialNormals> normals = axial_normals(*medium);
    if (is_without_axis(*medium)) continue;
    if (!normals) return std::nullopt;
    if (!shared) shared = normals->axis;
    if (!are_parallel(*shared, normals->axis)) return std::nullopt;
  }
  return shared;
}

}  // namespace lamella
