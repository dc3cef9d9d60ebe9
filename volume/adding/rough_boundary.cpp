#include "volume/adding/rough_boundary.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "phase/math/direction.h"
#include "phase/surface/conductor.h"
#include "phase/surface/fresnel_formulas.h"
#include "volume/adding/smooth_boundary.h"
#include "volume/kernel/facet_modes.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

VectorXd asked_out(const DirectionSets& sets) {
  return sets.out.tail(sets.out.size() - sets.nodes());
}
VectorXd asked_in(const DirectionSets& sets) { return sets.in.tail(sets.in.size() - sets.nodes()); }

VectorXd joined(const VectorXd& a, const VectorXd& b) {
  VectorXd both(a.size() + b.size());
  both << a, b;
  return both;
}

// Nothing meets a boundary along directions that its medium does not have.
void clear_absent(MatrixXd& m, const DirectionSets& out, const std::vector<bool>& out_exists,
                  const DirectionSets& in, const std::vector<bool>& in_exists) {
  for (std::size_t i = 0; i < out_exists.size(); ++i)
    if (!out_exists[i]) m.row(out.nodes() + static_cast<Index>(i)).setZero();
  for (std::size_t j = 0; j < in_exists.size(); ++j)
    if (!in_exists[j]) m.col(in.nodes() + static_cast<Index>(j)).setZero();
}

// Beams end at a surface that has none.
BeamShares ended(Index size) {
  BeamShares shares;
  shares.met = shares.gone = VectorXd::Ones(size);
  return shares;
}

}  // namespace

double met_by_facets(const Facets& facets, const FacetProfile::Reflectance& reflectance,
                     Direction w) {
  const double shown = facets.area(w), mu = w.z;
  if (!(shown > 0)) return 0;
  // Slopes in units of the roughness, in polar coordinates about that of w.
  const double along = std::hypot(facets.alpha_x * w.x, facets.alpha_y * w.y);
  const double turn = std::atan2(facets.alpha_y * w.y, facets.alpha_x * w.x);
  const Quadrature &radial = cached_gauss_legendre(64), &angular = cached_gauss_legendre(48);
  double sum = 0;
  for (int a = 0; a < 64; ++a) {
    // The slope tan(pi / 2 u): its square has a density that falls algebraically at most.
    const double angle = kPi / 2 * radial.points[a], slope = std::tan(angle);
    const double measure = radial.weights[a] * kPi / 2 * facets.alpha_x * facets.alpha_y * slope /
                           (std::cos(angle) * std::cos(angle));
    // Facets face the light where the cosine of the azimuth exceeds this.
    const double least = along * slope > 0 ? -mu / (along * slope) : -1;
    const double end = least <= -1 ? kPi : std::acos(std::min(1.0, least));
    for (int b = 0; b < 48; ++b)
      for (const int side : {1, -1}) {
        const double phi = turn + side * end * angular.points[b];
        const double x = facets.alpha_x * slope * std::cos(phi);
        const double y = facets.alpha_y * slope * std::sin(phi);
        const double cosine = 1 / std::sqrt(1 + x * x + y * y);
        const double c = cosine * (mu + x * w.x + y * w.y);
        sum += measure * end * angular.weights[b] * cosine * cosine * cosine *
               facets.density({x * cosine, y * cosine, cosine}) * std::max(0.0, c) *
               reflectance(std::clamp(c, 0.0, 1.0));
      }
  }
  return sum / shown;
}

RoughBoundary::RoughBoundary(const Interface& interface, const DirectionSets& above,
                             const DirectionSets& below, int modes)
    : above_(&above), below_(&below) {
  const bool above_is_rarer = above.index < below.index;
  const DirectionSets& rare = above_is_rarer ? above : below;
  const DirectionSets& dense = above_is_rarer ? below : above;
  const double ratio = dense.index / rare.index;
  Side& from_rare = above_is_rarer ? from_above_ : from_below_;
  Side& from_dense = above_is_rarer ? from_below_ : from_above_;
  // Reflection on either side.
  const auto reflection = [&](const DirectionSets& sets, double n, Side& side) {
    const double critical = n < 1 ? std::sqrt((1 - n) * (1 + n)) : 0;
    const FacetProfile profile(
        interface.facets, interface.masking,
        [n](double cosine) { return refraction(cosine, n).reflectance; }, critical);
    FacetModes facets(profile, sets, asked_out(sets), sets, asked_in(sets), modes, false);
    side.r = std::move(facets.f);
    for (MatrixXd& r : side.r) {
      clear_absent(r, sets, sets.out_exists, sets, sets.in_exists);
    }
    side.lost = RowVectorXd::Ones(sets.in.size()) - facets.energy;
  };
  reflection(rare, ratio, from_rare);
  reflection(dense, 1 / ratio, from_dense);

  // Transmission once, from the rarer side; both ways of it from one matrix, by reciprocity.
  const FacetProfile profile(interface.facets, interface.masking, ratio);
  const Index dense_out = asked_out(dense).size(), rare_in = asked_in(rare).size();
  const FacetModes facets(profile, dense, joined(asked_out(dense), asked_in(dense)), rare,
                          joined(asked_in(rare), asked_out(rare)), modes, false);
  const Index dense_nodes = dense.nodes(), rare_nodes = rare.nodes();
  for (int m = 0; m < modes; ++m) {
    const MatrixXd& all = facets.f[m];
    MatrixXd in = all.topLeftCorner(dense_nodes + dense_out, rare_nodes + rare_in);
    const Index dense_in = all.rows() - dense_nodes - dense_out,
                rare_out = all.cols() - rare_nodes - rare_in;
    MatrixXd back(dense_nodes + dense_in, rare_nodes + rare_out);
    back.topLeftCorner(dense_nodes, rare_nodes) = all.topLeftCorner(dense_nodes, rare_nodes);
    back.topRightCorner(dense_nodes, rare_out) = all.topRightCorner(dense_nodes, rare_out);
    back.bottomLeftCorner(dense_in, rare_nodes) = all.bottomLeftCorner(dense_in, rare_nodes);
    back.bottomRightCorner(dense_in, rare_out) = all.bottomRightCorner(dense_in, rare_out);
    MatrixXd out = back.transpose() / (ratio * ratio);
    clear_absent(in, dense, dense.out_exists, rare, rare.in_exists);
    clear_absent(out, rare, rare.out_exists, dense, dense.in_exists);
    from_rare.t.push_back(std::move(in));
    from_dense.t.push_back(std::move(out));
  }
  from_rare.lost -= dense.flux.transpose() * from_rare.t[0].topRows(dense_nodes);
  from_dense.lost -= rare.flux.transpose() * from_dense.t[0].topRows(rare_nodes);
}

RoughBoundary RoughBoundary::turned() const {
  RoughBoundary other = *this;
  std::swap(other.above_, other.below_);
  std::swap(other.from_above_, other.from_below_);
  return other;
}

PileOperator RoughBoundary::at(int mode) const {
  PileOperator pile{above_, below_, {}, {}, true};
  const auto fill = [&](PileSide& side, const Side& from, const DirectionSets& entry) {
    side.r[0] = side.r[kOrderZero] = from.r[mode];
    side.t[0] = side.t[kOrderZero] = from.t[mode];
    side.in = ended(entry.in.size());
    side.out = ended(entry.out.size());
    if (mode > 0) return;
    side.absorbed = RowVectorXd::Zero(entry.in.size());
    side.lost = from.lost;
  };
  fill(pile.above, from_above_, *above_);
  fill(pile.below, from_below_, *below_);
  return pile;
}

Ground::Ground(std::shared_ptr<const SurfaceLaw> law, int channel, const DirectionSets& sets,
               int modes)
    : sets_(&sets) {
  const VectorXd &in = sets.in, &out = sets.out;
  const auto* conductor = dynamic_cast<const Conductor*>(law.get());
  if (law->is_delta()) {
    const auto mirrored = [&](double mu) {
      RandomStream unused(0, 0, StreamPurpose::walk);
      const auto sample = law->sample({sine(mu), 0, mu}, unused);
      return sample ? sample->weight[channel] : 0;
    };
    mirror_in_ = in.unaryExpr(mirrored);
    mirror_out_ = out.unaryExpr(mirrored);
    return;
  }
  if (conductor) {
    const Conductor::Setting& s = conductor->setting();
    const auto reflectance = [conductor, channel](double cosine) {
      return conductor->reflectance(cosine)[channel];
    };
    const FacetProfile profile(s.facets, s.masking, reflectance, 0);
    FacetModes facets(profile, sets, asked_out(sets), sets, asked_in(sets), modes, true);
    r_ = std::move(facets.f);
    absorbed_ = lost_ = RowVectorXd::Zero(in.size());
    for (Index j = 0; j < in.size(); ++j) {
      const double met =
          s.white ? 1
                  : std::min(1.0, met_by_facets(s.facets, reflectance, {sine(in[j]), 0, in[j]}));
      absorbed_[j] = 1 - met;
      lost_[j] = met - facets.energy[j];
    }
    return;
  }
  r_.assign(modes, MatrixXd(out.size(), in.size()));
  const Quadrature& rule = cached_gauss_legendre(2 * modes + 32);
  oneapi::tbb::parallel_for(Index{0}, in.size(), [&](Index j) {
    RandomStream unused(0, 0, StreamPurpose::walk);
    const Direction wi{sine(in[j]), 0, in[j]};
    for (Index i = 0; i < out.size(); ++i) {
      Eigen::ArrayXd now = rule.weights;
      const Eigen::ArrayXd x = kPi * rule.points.array();
      for (Index k = 0; k < now.size(); ++k)
        now[k] *= law->eval(wi, direction_from_mu_phi(out[i], kPi - x[k]), unused)[channel];
      const Eigen::ArrayXd step = 2 * x.cos();
      Eigen::ArrayXd before = now * step / 2, next;
      for (int m = 0; m < modes; ++m) {
        r_[m](i, j) = now.sum();
        next = step * now - before;
        before.swap(now);
        now.swap(next);
      }
    }
  });
  const Index n = sets.nodes();
  absorbed_ = RowVectorXd::Ones(in.size()) - sets.flux.transpose() * r_[0].topRows(n);
  lost_ = RowVectorXd::Zero(in.size());
}

PileOperator Ground::at(int mode) const {
  if (mirror_in_.size() > 0) return mirror_ground({mirror_in_, mirror_out_}, *sets_, mode);
  PileOperator pile{sets_, sets_, {}, {}, false};
  PileSide& side = pile.above;
  side.r[0] = side.r[1] = r_[mode];
  side.in = ended(sets_->in.size());
  side.out = ended(sets_->out.size());
  if (mode > 0) return pile;
  side.absorbed = absorbed_;
  side.lost = lost_;
  return pile;
}

}  // namespace lamella
