#include "volume/adding/smooth_boundary.h"

#include "phase/medium/lambert_event.h"
#include "phase/surface/fresnel_formulas.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

// Beams along one list of directions in `here` that meet the boundary to `there`.
BeamShares beams(const VectorXd& mu, const std::vector<bool>& exists, const DirectionSets& here,
                 const VectorXd& mu_there, const std::vector<bool>& exists_there,
                 const DirectionSets& there) {
  const Index size = mu.size(), n = here.nodes(), n_there = there.nodes();
  BeamShares shares;
  shares.direct = shares.met = VectorXd::Zero(size);
  VectorXd mirror = VectorXd::Zero(size);
  for (Index k = 0; k < size; ++k) {
    const Index asked = k - n;
    const bool is_here = asked < 0 || exists[asked];
    const bool is_there = asked < 0 ? k < n_there : exists_there[asked];
    if (!is_here) {
      shares.met[k] = 1;
      continue;
    }
    const double beyond = is_there ? mu_there[asked < 0 ? k : n_there + asked] : 0;
    const SmoothShares s = smooth_shares(here.index, mu[k], there.index, beyond);
    mirror[k] = s.reflected;
    shares.direct[k] = s.transmitted;
  }
  shares.gone = shares.met;
  shares.mirror[0] = shares.mirror[kOrderZero] = std::move(mirror);
  return shares;
}

PileSide side(const DirectionSets& here, const DirectionSets& there, int mode) {
  PileSide result;
  result.in = beams(here.in, here.in_exists, here, there.in, there.in_exists, there);
  result.out = beams(here.out, here.out_exists, here, there.out, there.out_exists, there);
  if (mode == 0) result.absorbed = result.lost = RowVectorXd::Zero(here.in.size());
  return result;
}

PileOperator opaque(const DirectionSets& sets, int mode) {
  PileOperator ground{&sets, &sets, {}, {}, false};
  PileSide& side = ground.above;
  side.in.met = side.in.gone = VectorXd::Ones(sets.in.size());
  side.out.met = side.out.gone = VectorXd::Ones(sets.out.size());
  if (mode == 0) {
    side.absorbed = RowVectorXd::Ones(sets.in.size());
    side.lost = RowVectorXd::Zero(sets.in.size());
  }
  return ground;
}

}  // namespace

SmoothShares smooth_shares(double n, double mu, double n2, double mu2) {
  if (mu == 0 || mu2 == 0) return {1, 0};
  // Reflection from the rarer side, where cosines keep their digits; transmission without taking a
  // difference.
  const double reflected =
      n < n2 ? refraction(mu, n2 / n).reflectance : refraction(mu2, n / n2).reflectance;
  const double product = 2 * n * n2 * mu * mu2;
  const double s = n * mu + n2 * mu2, p = n2 * mu + n * mu2;
  return {reflected, product / (s * s) + product / (p * p)};
}

PileOperator smooth_boundary(const DirectionSets& above, const DirectionSets& below, int mode) {
  return {&above, &below, side(above, below, mode), side(below, above, mode), true};
}

PileOperator lambert_ground(double albedo, const DirectionSets& sets, int mode) {
  PileOperator ground = opaque(sets, mode);
  if (mode > 0 || albedo == 0) return ground;
  PileSide& side = ground.above;
  side.r[0] = MatrixXd::Constant(sets.out.size(), sets.in.size(), lambert_radiance(albedo));
  side.r[1] = side.r[0];
  side.absorbed.setConstant(1 - albedo);
  return ground;
}

PileOperator mirror_ground(const Mirror& mirror, const DirectionSets& sets, int mode) {
  PileOperator ground = opaque(sets, mode);
  PileSide& side = ground.above;
  side.in.mirror[0] = side.in.mirror[1] = mirror.in;
  side.out.mirror[0] = side.out.mirror[1] = mirror.out;
  side.in.gone -= mirror.in;
  side.out.gone -= mirror.out;
  if (mode == 0) side.absorbed = side.in.gone.transpose();
  return ground;
}

}  // namespace lamella
