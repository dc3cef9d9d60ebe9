#include "volume/harmonics/axial_normals.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes_of(const Sggx& ndf) {
  const SggxMatrix<double>& a = ndf.matrix();
  Eigen::Matrix3d lower;
  lower << a.a00, 0, 0, a.a10, a.a11, 0, a.a20, a.a21, a.a22;
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(lower * lower.transpose());
}

std::optional<AxialNormals> axial(const Sggx& ndf) {
  const auto solver = axes_of(ndf);
  const Eigen::Vector3d& s = solver.eigenvalues();
  constexpr double kSame = 1e-12;
  // Ascending: the axis is that of the eigenvalue that stands alone.
  const bool low_alone = s[2] - s[1] <= kSame * s[2];
  if (!low_alone && s[1] - s[0] > kSame * s[2]) return std::nullopt;
  const Eigen::Vector3d v = solver.eigenvectors().col(low_alone ? 0 : 2);
  const Direction axis{v[0], v[1], v[2]};
  const Frame<double> frame = frame_around(axis);
  const double ratio = std::sqrt(s[0] / s[2]);
  return AxialNormals{
      axis,
      [ndf, frame](double angle) {
        return ndf.density_of(std::sin(angle) * frame.s + std::cos(angle) * frame.n);
      },
      ratio,
      low_alone ? std::vector<double>{kPi / 2} : std::vector<double>{0, kPi},
      false,
      true};
}

std::optional<AxialNormals> axial(const Vmf& ndf) {
  const Frame<double> frame = frame_around(ndf.axis());
  return AxialNormals{
      ndf.axis(),
      [ndf, frame](double angle) {
        return ndf.density_of(std::sin(angle) * frame.s + std::cos(angle) * frame.n);
      },
      std::min(1.0, ndf.alpha()),
      {0}};
}

struct OfMedium {
  template <class Ndf>
  std::optional<AxialNormals> operator()(const MirrorFlakes<Ndf>& m) const {
    auto normals = axial(m.ndf);
    if (normals) normals->mirrors = true;
    return normals;
  }
  template <class Ndf>
  std::optional<AxialNormals> operator()(const LambertFlakes<Ndf>& m) const {
    return axial(m.ndf);
  }
  template <class Particles>
  std::optional<AxialNormals> operator()(const Particles&) const {
    return std::nullopt;
  }
};

}  // namespace

std::optional<AxialNormals> axial_normals(const Medium& medium) {
  return std::visit(OfMedium(), medium);
}

double width_of_normals(const Medium& medium) {
  if (const auto normals = axial_normals(medium)) return normals->width;
  const auto* mirrors = std::get_if<MirrorFlakes<Sggx>>(&medium);
  const auto solver = axes_of(mirrors ? mirrors->ndf : std::get<LambertFlakes<Sggx>>(medium).ndf);
  return std::sqrt(solver.eigenvalues()[0] / solver.eigenvalues()[2]);
}

bool has_normals(const Medium& medium) { return traits(medium).has_axis; }

}  // namespace lamella
