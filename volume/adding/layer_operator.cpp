#include "volume/adding/layer_operator.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "phase/medium/lambert_event.h"
#include "volume/adding/without_subtraction.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

// left[:, nodes] flux right[nodes, :]: light that crosses a plane between two events.
struct Chain {
  const VectorXd& flux;
  const MatrixProduct& product;

  MatrixXd operator()(const Eigen::Ref<const MatrixXd>& left, const MatrixXd& right) const {
    const Index n = flux.size();
    return product(left.leftCols(n), flux.asDiagonal() * right.topRows(n));
  }
};

// Share of each node's irradiance that a pile does not reflect: transmitted or absorbed.
RowVectorXd not_reflected(const OperatorSide& side, const VectorXd& flux) {
  const Index n = flux.size();
  RowVectorXd lost = flux.transpose() * side.t[0].topLeftCorner(n, n);
  lost += side.direct_in.head(n).transpose();
  lost += side.absorbed.head(n);
  return lost;
}

}  // namespace

OperatorSide add_sides(const OperatorSide& near_front, const OperatorSide& near_back,
                       const OperatorSide& far_front, const OperatorRules& rules) {
  const Index n = rules.sets.nodes();
  const VectorXd& flux = rules.sets.flux;
  const Chain chain{flux, rules.product};
  const auto beam = near_front.direct_in.asDiagonal();

  // Between the two: `onward` goes towards far, `back` comes from it. In irradiance
  // onward = source + (flux R_near) (flux R_far) onward.
  Series onward, back;
  back[0] = far_front.r[0] * beam;
  const MatrixXd source =
      flux.asDiagonal() * (near_front.t[0].topRows(n) + chain(near_back.r[0].topRows(n), back[0]));
  const MatrixXd far_r = flux.asDiagonal() * far_front.r[0].topLeftCorner(n, n);
  const MatrixXd turn =
      rules.product(flux.asDiagonal() * near_back.r[0].topLeftCorner(n, n), far_r);
  MatrixXd crossing;
  if (rules.mode == 0) {
    const RowVectorXd defect =
        not_reflected(far_front, flux) + not_reflected(near_back, flux) * far_r;
    crossing = WithoutSubtraction(turn, defect).solve(source);
  } else {
    crossing = (MatrixXd::Identity(n, n) - turn).partialPivLu().solve(source);
  }
  crossing = flux.cwiseInverse().asDiagonal() * crossing;
  back[0] += chain(far_front.r[0], crossing);
  onward[0] = near_front.t[0] + chain(near_back.r[0], back[0]);
  for (int k = 1; k <= rules.orders; ++k) {
    onward[k] = near_front.t[k];
    back[k] = far_front.r[k] * beam;
    for (int l = 1; l < k; ++l) {
      onward[k] += chain(near_back.r[l], back[k - l]);
      back[k] += chain(far_front.r[l], onward[k - l]);
    }
  }

  OperatorSide result;
  for (int k = 0; k <= rules.orders; ++k) {
    result.r[k] = near_front.r[k] + near_back.direct_out.asDiagonal() * back[k];
    result.t[k] = far_front.direct_out.asDiagonal() * onward[k] + far_front.t[k] * beam;
    for (int l = k == 0 ? 0 : 1; l < std::max(k, 1); ++l) {
      const int m = k == 0 ? 0 : k - l;
      result.r[k] += chain(near_back.t[l], back[m]);
      result.t[k] += chain(far_front.t[l], onward[m]);
    }
  }
  result.direct_in = near_front.direct_in.cwiseProduct(far_front.direct_in);
  result.direct_out = near_front.direct_out.cwiseProduct(far_front.direct_out);
  if (rules.mode == 0) {
    result.absorbed = near_front.absorbed + far_front.absorbed * beam;
    const auto nodes = flux.asDiagonal();
    result.absorbed += near_back.absorbed.head(n) * nodes * back[0].topRows(n);
    result.absorbed += far_front.absorbed.head(n) * nodes * onward[0].topRows(n);
  }
  return result;
}

LayerOperator add_layers(const LayerOperator& top, const LayerOperator& bottom,
                         const OperatorRules& rules) {
  return {add_sides(top.above, top.below, bottom.above, rules),
          add_sides(bottom.below, bottom.above, top.below, rules)};
}

LayerOperator empty_layer(const OperatorRules& rules) {
  const Index rows = rules.sets.out.size(), columns = rules.sets.in.size();
  OperatorSide side;
  side.r.fill(MatrixXd::Zero(rows, columns));
  side.t.fill(MatrixXd::Zero(rows, columns));
  side.direct_in = VectorXd::Ones(columns);
  side.direct_out = VectorXd::Ones(rows);
  side.absorbed = RowVectorXd::Zero(columns);
  return {side, side};
}

LayerOperator lambert_substrate(double albedo, const OperatorRules& rules) {
  LayerOperator result = empty_layer(rules);
  for (OperatorSide* side : {&result.above, &result.below}) {
    side->direct_in.setZero();
    side->direct_out.setZero();
    side->absorbed.setOnes();
  }
  if (rules.mode == 0) {
    result.above.r[0].setConstant(lambert_radiance(albedo));
    result.above.r[1] = result.above.r[0];
    result.above.absorbed.setConstant(1 - albedo);
  }
  return result;
}

}  // namespace lamella
