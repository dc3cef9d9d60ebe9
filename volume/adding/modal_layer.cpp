#include "volume/adding/modal_layer.h"

#include <Eigen/LU>
#include <cmath>

#include "volume/adding/thin_layer.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd from(const VectorXd& v, Index first) { return v.tail(v.size() - first); }

LayerDirections tail_of(const LayerDirections& d, Index count, double depth) {
  return {d.mu.tail(count), d.sigma.tail(count), depth};
}

PairTables right_of(const PairTables& pairs, Index count) {
  const Index skipped = pairs.back.cols() - count;
  PairTables right = pairs;
  right.back = pairs.back.rightCols(count);
  right.on = pairs.on.rightCols(count);
  right.apart = pairs.apart.rightCols(count);
  right.near.clear();
  for (const auto& [row, column] : pairs.near)
    if (column >= skipped) right.near.push_back({row, column - skipped});
  return right;
}

}  // namespace

ModalLayer::ModalLayer(const LayerScattering& scattering, const DirectionSets& sets, double depth,
                       Scope scope, int orders)
    : sets_(sets),
      depth_(depth),
      orders_(orders),
      first_(scope == Scope::asked ? sets.nodes() : 0),
      first_third_(scope == Scope::all ? 0 : sets.nodes()),
      free_(scattering, sets),
      out_(from(sets.out, first_), from(scattering.sigma_out[0], first_), depth),
      in_(from(sets.in, first_), from(scattering.sigma_in[0], first_), depth),
      pairs_(out_, in_, depth) {
  if (orders > 1) {
    free_out_.emplace(out_, free_.nu, depth);
    free_in_.emplace(in_, free_.nu, depth);
  }
  if (orders > 2)
    third_.emplace(scattering, sets, depth, tail_of(out_, sets.out.size() - first_third_, depth),
                   tail_of(in_, sets.in.size() - first_third_, depth), scope != Scope::all);
}

Lobes ModalLayer::all_orders(const LayerEigenmodes& modes, const Parts& kernel,
                             const MatrixXd& on_out, const MatrixXd& back_out,
                             const MatrixProduct& product) const {
  const Index n = sets_.nodes(), asked = sets_.in.size() - n, nodes = n - first_;
  const bool infinite = std::isinf(depth_);
  const MatrixXd on_in = kernel[kAboveToDown].topRightCorner(n, asked).transpose();
  const MatrixXd back_in = kernel[kAboveToUp].topRightCorner(n, asked).transpose();
  const Amplitudes out(on_out, back_out, modes, sets_, product);
  const Amplitudes in(on_in, back_in, modes, sets_, product);
  const LayerDirections asked_in = tail_of(in_, asked, depth_);
  const FlightTables flights_out(out_, modes.nu, depth_), flights_in(asked_in, modes.nu, depth_);

  // Amplitudes at the faces that no light enters by but the beams: c from the front, d from behind,
  //   c = first - Q E d, d = second - Q E c, Q = forward^-1 backward, E = exp(-T / nu).
  const Eigen::PartialPivLU<MatrixXd> faces(modes.forward);
  const MatrixXd turn = faces.solve(modes.backward);
  MatrixXd first(n, nodes + asked);
  if (nodes > 0) {
    const VectorXd beams = (2 * kPi * sets_.weight).cwiseSqrt().cwiseQuotient(sets_.flux);
    first.leftCols(nodes) = faces.solve(MatrixXd(beams.asDiagonal()));
  }
  first.rightCols(asked) = -product(turn, in.backward.cwiseProduct(flights_in.against).transpose());
  MatrixXd c = first, d = MatrixXd::Zero(n, nodes + asked);
  if (!infinite) {
    const VectorXd decay = (-depth_ * modes.nu.cwiseInverse().array()).exp();
    const MatrixXd back = turn * decay.asDiagonal();
    d.rightCols(asked) = -product(turn, in.forward.cwiseProduct(flights_in.along).transpose());
    c -= product(back, d);
    c = (MatrixXd::Identity(n, n) - product(back, back)).partialPivLu().solve(c);
    d -= product(back, c);
  }

  const MatrixXd against = out.backward.cwiseProduct(flights_out.against) * modes.nu.asDiagonal();
  Lobes f;
  f.r = product(against, c);
  if (infinite) {
    f.t = MatrixXd::Zero(f.r.rows(), f.r.cols());
  } else {
    const MatrixXd along = out.forward.cwiseProduct(flights_out.along) * modes.nu.asDiagonal();
    product.add(along, d, f.r);
    f.t = product(along, c);
    product.add(against, d, f.t);
  }
  if (asked == 0) return f;
  const PairTables pairs = nodes == 0 ? pairs_ : right_of(pairs_, asked);
  const Lobes inside = along_modes(out, in, flights_out, flights_in, out_, asked_in, pairs,
                                   modes.nu, depth_, product);
  f.r.rightCols(asked) += inside.r;
  f.t.rightCols(asked) += inside.t;
  const auto corner = [&](Part part) {
    return kernel[part]
        .bottomRightCorner(out_.mu.size(), asked)
        .cwiseProduct(part == kAboveToUp ? pairs.back : pairs.on);
  };
  f.r.rightCols(asked) += corner(kAboveToUp);
  f.t.rightCols(asked) += corner(kAboveToDown);
  return f;
}

std::optional<std::array<Series, 2>> ModalLayer::series(const LayerScattering& scattering, int mode,
                                                        const MatrixProduct& product) const {
  const std::optional<LayerEigenmodes> modes = layer_eigenmodes(scattering, mode, sets_);
  if (!modes) return std::nullopt;
  // Near albedo 1 the last mode of azimuthal mode 0 decays slowly, and with the square of its depth
  // rounding grows.
  constexpr double kDeepest = 300;
  if (mode == 0 && modes->nu.maxCoeff() * scattering.sigma_in[0].minCoeff() > kDeepest)
    return std::nullopt;
  const Index n = sets_.nodes(), rows = out_.mu.size(), columns = in_.mu.size();
  const Parts& kernel = scattering.modes[mode];
  const MatrixXd on_out = kernel[kAboveToDown].bottomLeftCorner(rows, kernel[0].cols()).leftCols(n);
  const MatrixXd back_out = kernel[kAboveToUp].bottomLeftCorner(rows, kernel[0].cols()).leftCols(n);
  std::array<Series, 2> result;
  Series &r = result[0], &t = result[1];
  const auto put = [&](int order, Lobes&& f) {
    r[order] = std::move(f.r);
    t[order] = std::move(f.t);
  };
  put(0, all_orders(*modes, kernel, on_out, back_out, product));
  if (orders_ < 1) return result;
  put(1, {kernel[kAboveToUp].bottomRightCorner(rows, columns).cwiseProduct(pairs_.back),
          kernel[kAboveToDown].bottomRightCorner(rows, columns).cwiseProduct(pairs_.on)});
  if (orders_ < 2) return result;
  const MatrixXd on_in = kernel[kAboveToDown].topRightCorner(n, columns).transpose();
  const MatrixXd back_in = kernel[kAboveToUp].topRightCorner(n, columns).transpose();
  put(2, along_modes({on_out, back_out, free_}, {on_in, back_in, free_}, *free_out_, *free_in_,
                     out_, in_, pairs_, free_.nu, depth_, product));
  if (orders_ < 3) return result;
  const Index rows3 = sets_.out.size() - first_third_, columns3 = sets_.in.size() - first_third_;
  Lobes third = third_->lobes(kernel, on_out.bottomRows(rows3), back_out.bottomRows(rows3),
                              on_in.bottomRows(columns3), back_in.bottomRows(columns3), product);
  for (MatrixXd* f : {&third.r, &third.t}) {
    if (first_ == first_third_) break;
    MatrixXd all = MatrixXd::Zero(rows, columns);
    all.bottomRightCorner(rows3, columns3) = *f;
    *f = std::move(all);
  }
  put(3, std::move(third));
  return result;
}

std::optional<LayerOperator> ModalLayer::layer(const LayerScattering& scattering, int mode,
                                               const MatrixProduct& product) const {
  std::optional<std::array<Series, 2>> found = series(scattering, mode, product);
  if (!found) return std::nullopt;
  LayerOperator layer;
  layer.above.r = std::move((*found)[0]);
  layer.above.t = std::move((*found)[1]);
  set_direct(layer, scattering, depth_, sets_);
  if (std::isinf(depth_)) {
    layer.above.direct_in.setZero();
    layer.above.direct_out.setZero();
  }
  layer.below = layer.above;
  return layer;
}

}  // namespace lamella
