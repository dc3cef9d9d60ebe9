#include "volume/adding/pile_operator.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "volume/adding/without_subtraction.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

bool any(const MatrixXd& m) { return m.size() > 0; }
bool any(const VectorXd& v) { return v.size() > 0; }

void add_to(MatrixXd& sum, const MatrixXd& term) {
  if (!any(term)) return;
  if (any(sum))
    sum += term;
  else
    sum = term;
}

void add_to(VectorXd& sum, const VectorXd& term) {
  if (!any(term)) return;
  if (any(sum))
    sum += term;
  else
    sum = term;
}

// Directions of two media: nodes that both have come first, then those that are asked for.
struct Places {
  Index from, to, asked;  // nodes of either, directions that are asked for
  Places(const DirectionSets& a, const DirectionSets& b, Index size)
      : from(a.nodes()), to(b.nodes()), asked(size - a.nodes()) {}
  [[nodiscard]] Index common() const { return std::min(from, to); }
  [[nodiscard]] VectorXd moved(const VectorXd& v) const {
    VectorXd result = VectorXd::Zero(to + asked);
    result.head(common()) = v.head(common());
    result.tail(asked) = v.tail(asked);
    return result;
  }
};

// A list of `a` as one of `b`; what has no place there is 0.
VectorXd moved(const VectorXd& v, const DirectionSets& a, const DirectionSets& b) {
  return any(v) ? Places(a, b, v.size()).moved(v) : v;
}

// Columns of m, which are those of `inner`, for beams that are `share` of what arrives in `outer`.
MatrixXd for_beams(const MatrixXd& m, const VectorXd& share, const DirectionSets& inner,
                   const DirectionSets& outer) {
  if (!any(m) || !any(share)) return {};
  const Places p(inner, outer, m.cols());
  MatrixXd result = MatrixXd::Zero(m.rows(), p.to + p.asked);
  result.leftCols(p.common()) = m.leftCols(p.common()) * share.head(p.common()).asDiagonal();
  result.rightCols(p.asked) = m.rightCols(p.asked) * share.tail(p.asked).asDiagonal();
  return result;
}

// Rows of m, which are those of `inner`, as they go on as beams to `outer`; share: of `inner`.
MatrixXd onto_beams(const VectorXd& share, const MatrixXd& m, const DirectionSets& inner,
                    const DirectionSets& outer) {
  if (!any(m) || !any(share)) return {};
  const Places p(inner, outer, m.rows());
  const double step = outer.index / inner.index;
  const VectorXd radiance = step * step * share;
  MatrixXd result = MatrixXd::Zero(p.to + p.asked, m.cols());
  result.topRows(p.common()) = radiance.head(p.common()).asDiagonal() * m.topRows(p.common());
  result.bottomRows(p.asked) = radiance.tail(p.asked).asDiagonal() * m.bottomRows(p.asked);
  return result;
}

// left[:, nodes] flux right[nodes, :]: light that crosses a plane between two events.
MatrixXd chain(const MatrixXd& left, const MatrixXd& right, const VectorXd& flux,
               const MatrixProduct& product) {
  if (!any(left) || !any(right)) return {};
  const Index n = flux.size();
  return product(left.leftCols(n), flux.asDiagonal() * right.topRows(n));
}

// 1 - a b where 1 - a and 1 - b are known without cancellation.
VectorXd one_less(const VectorXd& a, const VectorXd& rest_a, const VectorXd& rest_b) {
  return rest_a + a.cwiseProduct(rest_b);
}

VectorXd quotient(const VectorXd& a, const VectorXd& b) {
  // Nothing ever gets to directions between two mirrors that let nothing through.
  return a.binaryExpr(b, [](double x, double y) { return y == 0 ? 0 : x / y; });
}

VectorXd or_zero(const VectorXd& v, Index size) {
  return any(v) ? v : VectorXd(VectorXd::Zero(size));
}

// Share of each node's irradiance that a side does not send back: transmitted, absorbed or lost.
RowVectorXd not_reflected(const PileSide& side, const DirectionSets& entry,
                          const DirectionSets& exit) {
  const Index n = entry.nodes();
  RowVectorXd rest = side.absorbed.head(n) + side.lost.head(n);
  if (any(side.in.direct)) rest += side.in.direct.head(n).transpose();
  if (any(side.t[0])) rest += exit.flux.transpose() * side.t[0].topLeftCorner(exit.nodes(), n);
  return rest;
}

// Beams between two piles, by index of the directions outside.
struct Beams {
  BeamSeries on, back;
};

// The beams of one list, and what both piles make of them together.
Beams combine(const BeamShares& near_front, const BeamShares& near_back_there,
              const BeamShares& far_front_there, const DirectionSets& outside,
              const DirectionSets& between, int orders, BeamShares& result) {
  const Index size = near_front.met.size();
  // Where `between` has no such direction nothing arrives.
  const auto here = [&](const VectorXd& v) { return or_zero(moved(v, between, outside), size); };
  const auto times = [](const VectorXd& by, const VectorXd& beam) {
    return any(by) && any(beam) ? VectorXd(by.cwiseProduct(beam)) : VectorXd();
  };
  const VectorXd enter = or_zero(near_front.direct, size), leave = here(near_back_there.direct);
  const VectorXd mirror = here(near_back_there.mirror[kOrderZero]);
  const VectorXd near_met = here(near_back_there.met), near_gone = here(near_back_there.gone);
  const VectorXd through = here(far_front_there.direct);
  const VectorXd far_met = here(far_front_there.met), far_gone = here(far_front_there.gone);
  BeamSeries far;
  for (int k = 0; k < kPileSeries; ++k) far[k] = moved(far_front_there.mirror[k], between, outside);

  Beams b;
  const VectorXd zero_loop = one_less(mirror, near_met + leave, far_met + through);
  b.on[kOrderZero] = quotient(enter, zero_loop);
  b.back[kOrderZero] = times(far[kOrderZero], b.on[kOrderZero]);
  for (int k = 1; k <= orders; ++k) {
    VectorXd source = times(far[k], b.on[kOrderZero]);
    for (int l = 1; l < k; ++l) add_to(source, times(far[l], b.on[k - l]));
    if (!any(source)) continue;
    // What comes back goes to and fro by reflections of order 0.
    b.on[k] = quotient(mirror.cwiseProduct(source), zero_loop);
    b.back[k] = source;
    add_to(b.back[k], times(far[kOrderZero], b.on[k]));
  }
  b.on[0] = quotient(enter, one_less(mirror, near_gone + leave, far_gone + through));
  b.back[0] = times(far[0], b.on[0]);

  result.mirror = near_front.mirror;
  for (int k = 0; k < kPileSeries; ++k) add_to(result.mirror[k], times(leave, b.back[k]));
  if (any(far_front_there.direct)) result.direct = through.cwiseProduct(b.on[kOrderZero]);
  const auto rest = [&](const VectorXd& first, const VectorXd& far_share,
                        const VectorXd& near_share, int k) {
    VectorXd sum = first + far_share.cwiseProduct(b.on[k]);
    add_to(sum, times(near_share, b.back[k]));
    return sum;
  };
  result.met = rest(near_front.met, far_met, near_met, kOrderZero);
  result.gone = rest(near_front.gone, far_gone, near_gone, 0);
  return b;
}

// One way of combining: light that arrives at the front of `near`.
struct Sum {
  const PileSide &near_front, &near_back, &far_front;
  const DirectionSets &outside, &between, &beyond;
  const PileRules& rules;

  [[nodiscard]] PileSide run() const;

 private:
  // Diffuse light between the two, as rows of `between`, going on and back.
  struct Field {
    MatrixXd on, back;
  };
  // Sums over what goes to and fro by reflections of one series.
  class Loop;
};

class Sum::Loop {
 public:
  // series: the index of the reflections that take part.
  Loop(const Sum& sum, int series)
      : s_(sum),
        near_r_(sum.near_back.r[series]),
        far_r_(sum.far_front.r[series]),
        flux_(sum.between.flux) {
    const Index n = flux_.size(), rows = sum.between.out.size();
    const BeamShares &near = sum.near_back.out, &far = sum.far_front.out;
    near_mirror_ = or_zero(near.mirror[series], rows);
    far_mirror_ = or_zero(far.mirror[series], rows);
    const bool all = series == 0;
    rest_ = one_less(near_mirror_, (all ? near.gone : near.met) + or_zero(near.direct, rows),
                     (all ? far.gone : far.met) + or_zero(far.direct, rows));
    is_diagonal_ = !any(near_r_) && !any(far_r_);
    if (is_diagonal_) return;
    // In irradiance.
    const auto reflection = [&](const MatrixXd& r, const VectorXd& mirror) {
      MatrixXd m = any(r) ? MatrixXd(flux_.asDiagonal() * r.topLeftCorner(n, n))
                          : MatrixXd(MatrixXd::Zero(n, n));
      m.diagonal() += mirror.head(n);
      return m;
    };
    far_ = reflection(far_r_, far_mirror_);
    near_ = reflection(near_r_, near_mirror_);
    MatrixXd turn;
    if (any(near_r_))
      turn = s_.rules.product(near_, far_);
    else
      turn = near_mirror_.head(n).asDiagonal() * far_;
    if (series == 0 && s_.rules.mode == 0) {
      const RowVectorXd defect = not_reflected(s_.far_front, s_.between, s_.beyond) +
                                 not_reflected(s_.near_back, s_.between, s_.outside) * far_;
      without_subtraction_.emplace(std::move(turn), defect);
      return;
    }
    MatrixXd m = MatrixXd::Identity(n, n) - turn;
    for (Index k = 0; k < n; ++k)
      if (m(k, k) == 0) m(k, k) = 1;  // nothing ever gets there
    lu_.emplace(m);
  }

  // on = first + near back, back = second + far on.
  [[nodiscard]] Field solve(const MatrixXd& first, const MatrixXd& second) const {
    Field f;
    const Index n = flux_.size();
    if (!any(first) && !any(second)) return f;
    const Index rows = s_.between.out.size(), columns = any(first) ? first.cols() : second.cols();
    const MatrixXd zero = MatrixXd::Zero(rows, columns);
    const MatrixXd& a = any(first) ? first : zero;
    const MatrixXd& b = any(second) ? second : zero;
    MatrixXd source = a, answer = b;
    if (!is_diagonal_) {
      // At the nodes, then what the nodes send to all rows.
      MatrixXd at_nodes = a.topRows(n) + near_mirror_.head(n).asDiagonal() * b.topRows(n);
      if (any(near_r_)) at_nodes += chain(near_r_.topRows(n), b, flux_, s_.rules.product);
      MatrixXd on = flux_.asDiagonal() * at_nodes;
      on = without_subtraction_ ? without_subtraction_->solve(std::move(on))
                                : MatrixXd(lu_->solve(on));
      on = flux_.cwiseInverse().asDiagonal() * on;
      if (any(far_r_)) answer += chain(far_r_, on, flux_, s_.rules.product);
      MatrixXd back = answer.topRows(n) + far_mirror_.head(n).asDiagonal() * on;
      if (any(near_r_)) source += chain(near_r_, back, flux_, s_.rules.product);
      f.on = finish(source, answer);
      f.on.topRows(n) = on;
      f.back = answer + far_mirror_.asDiagonal() * f.on;
      return f;
    }
    f.on = finish(source, answer);
    f.back = answer + far_mirror_.asDiagonal() * f.on;
    return f;
  }

 private:
  // All rows: on = (source + near answer) / (1 - near far), the mirrors' part alone.
  [[nodiscard]] MatrixXd finish(const MatrixXd& source, const MatrixXd& answer) const {
    MatrixXd on = source + near_mirror_.asDiagonal() * answer;
    for (Index i = 0; i < on.rows(); ++i) {
      if (rest_[i] == 0)
        on.row(i).setZero();
      else
        on.row(i) /= rest_[i];
    }
    return on;
  }

  const Sum& s_;
  const MatrixXd &near_r_, &far_r_;
  const VectorXd& flux_;
  VectorXd near_mirror_, far_mirror_, rest_;
  MatrixXd near_, far_;
  bool is_diagonal_ = false;
  std::optional<WithoutSubtraction> without_subtraction_;
  std::optional<Eigen::PartialPivLU<MatrixXd>> lu_;
};

PileSide Sum::run() const {
  PileSide result;
  const Beams beam =
      combine(near_front.in, near_back.in, far_front.in, outside, between, rules.orders, result.in);
  combine(near_front.out, near_back.out, far_front.out, outside, between, rules.orders, result.out);
  const VectorXd& flux = between.flux;
  const auto with_beams = [&](const MatrixXd& m, const VectorXd& share) {
    return for_beams(m, share, between, outside);
  };
  std::array<Field, kPileSeries> field;  // by series
  // What leaves, series k. Adds what series l of the operators makes of series m of the light.
  const auto leave = [&](int k) {
    result.r[k] = near_front.r[k];
    add_to(result.r[k], onto_beams(near_back.out.direct, field[k].back, between, outside));
    result.t[k] = onto_beams(far_front.out.direct, field[k].on, between, beyond);
    return [&, k](int l, int m) {
      add_to(result.r[k], chain(near_back.t[l], field[m].back, flux, rules.product));
      add_to(result.r[k], with_beams(near_back.t[l], beam.back[m]));
      add_to(result.t[k], chain(far_front.t[l], field[m].on, flux, rules.product));
      add_to(result.t[k], with_beams(far_front.t[l], beam.on[m]));
    };
  };

  MatrixXd first = near_front.t[0], second = with_beams(far_front.r[0], beam.on[0]);
  add_to(first, with_beams(near_back.r[0], beam.back[0]));
  field[0] = Loop(*this, 0).solve(first, second);
  leave(0)(0, 0);

  const Loop zero(*this, kOrderZero);
  const auto series = [](int order) { return order == 0 ? kOrderZero : order; };
  for (int k = 0; k <= rules.orders; ++k) {
    first = near_front.t[series(k)];
    second = MatrixXd();
    for (int l = 0; l <= k; ++l) {
      add_to(first, with_beams(near_back.r[series(l)], beam.back[series(k - l)]));
      add_to(second, with_beams(far_front.r[series(l)], beam.on[series(k - l)]));
      if (l == 0) continue;
      const Field& before = field[series(k - l)];
      add_to(first, chain(near_back.r[l], before.back, flux, rules.product));
      add_to(second, chain(far_front.r[l], before.on, flux, rules.product));
      if (any(far_front.out.mirror[l]) && any(before.on))
        add_to(second, MatrixXd(far_front.out.mirror[l].asDiagonal() * before.on));
    }
    field[series(k)] = zero.solve(first, second);
    const auto make = leave(series(k));
    for (int l = 0; l <= k; ++l) make(series(l), series(k - l));
  }

  if (rules.mode == 0) {
    result.absorbed = near_front.absorbed;
    result.lost = near_front.lost;
    const auto add_rows = [&](RowVectorXd& sum, const RowVectorXd& near_row,
                              const RowVectorXd& far_row) {
      const Index n = between.nodes();
      const auto nodes = flux.asDiagonal();
      sum += MatrixXd(with_beams(far_row, beam.on[0])).row(0);
      if (any(beam.back[0])) sum += MatrixXd(with_beams(near_row, beam.back[0])).row(0);
      if (any(field[0].back)) sum += near_row.head(n) * nodes * field[0].back.topRows(n);
      if (any(field[0].on)) sum += far_row.head(n) * nodes * field[0].on.topRows(n);
    };
    add_rows(result.absorbed, near_back.absorbed, far_front.absorbed);
    add_rows(result.lost, near_back.lost, far_front.lost);
  }
  return result;
}

}  // namespace

PileOperator pile_of(LayerOperator layer, const LayerScattering& scattering, double depth,
                     const DirectionSets& sets) {
  PileOperator pile{&sets, &sets, {}, {}, true};
  const auto series = [](Series& from) {
    PileSeries to;
    for (int k = 0; k < kSeries; ++k) to[k] = std::move(from[k]);
    return to;
  };
  // Shares that meet something: 1 - exp(-tau) without cancellation.
  const auto shares = [&](VectorXd direct, const VectorXd& sigma, const VectorXd& mu) {
    BeamShares s;
    s.met = sigma.binaryExpr(mu, [depth](double area, double cosine) {
      return area == 0 ? 0 : -std::expm1(-depth * area / cosine);
    });
    s.gone = s.met;
    s.direct = std::move(direct);
    return s;
  };
  const auto side = [&](OperatorSide& from, int label) {
    PileSide to;
    to.r = series(from.r);
    to.t = series(from.t);
    to.in = shares(std::move(from.direct_in), scattering.sigma_in[label], sets.in);
    to.out = shares(std::move(from.direct_out), scattering.sigma_out[label], sets.out);
    to.absorbed = std::move(from.absorbed);
    to.lost = RowVectorXd::Zero(to.absorbed.size());
    return to;
  };
  pile.above = side(layer.above, 0);
  pile.below = side(layer.below, 1);
  return pile;
}

PileOperator add_piles(const PileOperator& top, const PileOperator& bottom,
                       const PileRules& rules) {
  PileOperator pile{top.top, bottom.bottom, {}, {}, bottom.is_open};
  pile.above =
      Sum{top.above, top.below, bottom.above, *top.top, *top.bottom, *bottom.bottom, rules}.run();
  if (bottom.is_open)
    pile.below =
        Sum{bottom.below, bottom.above, top.below, *bottom.bottom, *bottom.top, *top.top, rules}
            .run();
  return pile;
}

}  // namespace lamella
