#include "volume/adding/layer_operator.h"

#include <oneapi/tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "phase/medium/lambert_event.h"
#include "volume/adding/without_subtraction.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

// Adds left[:, nodes] flux right[nodes, :]: light that crosses a plane between two events.
struct Chain {
  const VectorXd& flux;
  const MatrixProduct& product;

  void add(const Eigen::Ref<const MatrixXd>& left, const MatrixXd& right, MatrixXd& to) const {
    const Index n = flux.size();
    product.add(left.leftCols(n), flux.asDiagonal() * right.topRows(n), to);
  }
};

// Incoming directions are independent of each other: blocks of them are shared out where they are
// worth it. What a block answers does not depend on who works on it.
constexpr Index kBlockColumns = 16, kFewestSharedNodes = 24;

template <class Work>
void for_each_block(Index columns, Index nodes, const Work& work) {
  const Index blocks = (columns + kBlockColumns - 1) / kBlockColumns;
  const auto one = [&](Index block) {
    const Index first = block * kBlockColumns;
    work(first, std::min(kBlockColumns, columns - first));
  };
  if (nodes < kFewestSharedNodes) {
    for (Index block = 0; block < blocks; ++block) one(block);
  } else {
    oneapi::tbb::parallel_for(Index{0}, blocks, one);
  }
}

// Share of each node's irradiance that a pile does not reflect: transmitted or absorbed.
RowVectorXd not_reflected(const OperatorSide& side, const VectorXd& flux) {
  const Index n = flux.size();
  RowVectorXd lost = flux.transpose() * side.t[0].topLeftCorner(n, n);
  lost += side.direct_in.head(n).transpose();
  lost += side.absorbed.head(n);
  return lost;
}

// Multiple reflections between two layers, (I - turn)^-1.
class Between {
 public:
  Between(const MatrixXd& turn, const std::optional<RowVectorXd>& defect) {
    if (defect)
      exact_.emplace(turn, *defect);
    else
      plain_.emplace(MatrixXd::Identity(turn.rows(), turn.cols()) - turn);
  }
  [[nodiscard]] MatrixXd solve(MatrixXd source) const {
    return exact_ ? exact_->solve(std::move(source)) : MatrixXd(plain_->solve(source));
  }

 private:
  std::optional<WithoutSubtraction> exact_;
  std::optional<Eigen::PartialPivLU<MatrixXd>> plain_;
};

}  // namespace

OperatorSide add_sides(const OperatorSide& near_front, const OperatorSide& near_back,
                       const OperatorSide& far_front, const OperatorRules& rules) {
  const Index n = rules.sets.nodes(), columns = rules.sets.in.size(), rows = rules.sets.out.size();
  const VectorXd& flux = rules.sets.flux;
  const Chain chain{flux, rules.product};

  // Between the two: `onward` goes towards far, `back` comes from it. In irradiance
  // onward = source + (flux R_near) (flux R_far) onward.
  const MatrixXd near_r = flux.asDiagonal() * near_back.r[0].topLeftCorner(n, n);
  const MatrixXd far_r = flux.asDiagonal() * far_front.r[0].topLeftCorner(n, n);
  MatrixXd turn(n, n);
  for_each_block(n, n, [&](Index first, Index count) {
    turn.middleCols(first, count) = rules.product(near_r, far_r.middleCols(first, count));
  });
  std::optional<RowVectorXd> defect;
  if (rules.mode == 0)
    defect = not_reflected(far_front, flux) + not_reflected(near_back, flux) * far_r;
  const Between between(turn, defect);

  OperatorSide result;
  for (int k = 0; k <= rules.orders; ++k)
    for (Series* series : {&result.r, &result.t}) (*series)[k].resize(rows, columns);
  if (rules.mode == 0) result.absorbed.resize(columns);
  for_each_block(columns, n, [&](Index first, Index count) {
    const auto of = [&](const MatrixXd& all) { return all.middleCols(first, count); };
    const auto beam = near_front.direct_in.segment(first, count).asDiagonal();
    Series onward, back;
    back[0] = of(far_front.r[0]) * beam;
    MatrixXd source = of(near_front.t[0]).topRows(n);
    chain.add(near_back.r[0].topRows(n), back[0], source);
    const MatrixXd crossing =
        flux.cwiseInverse().asDiagonal() * between.solve(flux.asDiagonal() * source);
    chain.add(far_front.r[0], crossing, back[0]);
    onward[0] = of(near_front.t[0]);
    chain.add(near_back.r[0], back[0], onward[0]);
    for (int k = 1; k <= rules.orders; ++k) {
      onward[k] = of(near_front.t[k]);
      back[k] = of(far_front.r[k]) * beam;
      for (int l = 1; l < k; ++l) {
        chain.add(near_back.r[l], back[k - l], onward[k]);
        chain.add(far_front.r[l], onward[k - l], back[k]);
      }
    }
    for (int k = 0; k <= rules.orders; ++k) {
      MatrixXd r = of(near_front.r[k]) + near_back.direct_out.asDiagonal() * back[k];
      MatrixXd t = far_front.direct_out.asDiagonal() * onward[k] + of(far_front.t[k]) * beam;
      for (int l = k == 0 ? 0 : 1; l < std::max(k, 1); ++l) {
        const int m = k == 0 ? 0 : k - l;
        chain.add(near_back.t[l], back[m], r);
        chain.add(far_front.t[l], onward[m], t);
      }
      result.r[k].middleCols(first, count) = r;
      result.t[k].middleCols(first, count) = t;
    }
    if (rules.mode > 0) return;
    const auto nodes = flux.asDiagonal();
    result.absorbed.segment(first, count) =
        near_front.absorbed.segment(first, count) +
        far_front.absorbed.segment(first, count) * beam +
        near_back.absorbed.head(n) * nodes * back[0].topRows(n) +
        far_front.absorbed.head(n) * nodes * onward[0].topRows(n);
  });
  result.direct_in = near_front.direct_in.cwiseProduct(far_front.direct_in);
  result.direct_out = near_front.direct_out.cwiseProduct(far_front.direct_out);
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
