#include "volume/adding/third_order.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lamella {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// exp(-2 pi (pi / 2) / step) is the trapezoidal rule's error, the least depth that of its ends.
constexpr double kStep = 0.42, kLeastDepth = 1e-10, kOpaque = 40;

// (1 - exp(-x)) / x of small x.
double mean_decay(double x) {
  return 1 - x / 2 * (1 - x / 3 * (1 - x / 4 * (1 - x / 5 * (1 - x / 6 * (1 - x / 7)))));
}
constexpr double kSmall = 0.05;

double finite(double x) { return std::isfinite(x) ? x : 0; }

// Points t in the layer with T - t and weights.
struct Depths {
  ArrayXd t, rest, weight;
  Depths(double depth, double largest_area) {
    const double unit = 1 / largest_area;
    if (std::isinf(depth)) {
      const double low = std::log(kLeastDepth * unit), high = std::log(kOpaque * unit);
      const auto count = static_cast<Index>(std::ceil((high - low) / kStep)) + 1;
      t = ArrayXd::LinSpaced(count, high - kStep * static_cast<double>(count - 1), high).exp();
      rest = ArrayXd::Constant(count, depth);
      weight = kStep * t;
      return;
    }
    // Depth 0 has no points of its own.
    const double reach = std::log(std::max(1.0, depth / unit) / kLeastDepth);
    const auto half = static_cast<Index>(std::ceil(reach / kStep));
    const ArrayXd x = kStep * ArrayXd::LinSpaced(2 * half + 1, -static_cast<double>(half),
                                                 static_cast<double>(half));
    const ArrayXd up = 1 / (1 + (-x).exp()), down = 1 / (1 + x.exp());
    t = depth * up;
    rest = depth * down;
    weight = kStep * depth * up * down;
  }
};

}  // namespace

ThirdOrder::ThirdOrder(const LayerScattering& scattering, const DirectionSets& sets, double depth,
                       const LayerDirections& out, const LayerDirections& in, bool keeps_tables)
    : root_((2 * kPi * sets.weight).cwiseSqrt()), infinite_(std::isinf(depth)) {
  const Index n = sets.nodes();
  const VectorXd sigma = scattering.sigma_in[0].head(n);
  const Depths depths(depth, sigma.maxCoeff());
  t_ = depths.t;
  rest_ = depths.rest;
  weights_ = depths.weight;
  nodes_ = beams(sets.in.head(n), sigma);
  out_ = beams(out.mu, out.sigma);
  in_ = beams(in.mu, in.sigma);
  if (!keeps_tables) return;
  for (Index k = 0; k < n; ++k) {
    kept_in_.push_back(light(k, in_));
    kept_out_.push_back(light(k, out_));
  }
}

ThirdOrder::Beams ThirdOrder::beams(const VectorXd& mu, const VectorXd& sigma) const {
  Beams b{mu, sigma, ArrayXXd(mu.size(), t_.size()), ArrayXXd(mu.size(), t_.size())};
  for (Index d = 0; d < mu.size(); ++d) {
    const double rate = sigma[d] / mu[d];
    b.from_front.row(d) = (-rate * t_).exp();
    b.from_back.row(d) = (-rate * rest_).exp();
  }
  return b;
}

ThirdOrder::Light ThirdOrder::light(Index k, const Beams& d, Light used) const {
  const Index size = d.mu.size(), count = t_.size();
  Light f = std::move(used);
  f.same.resize(size, count);
  f.other.resize(size, count);
  const double mu = nodes_.mu[k], sigma = nodes_.sigma[k], own = sigma / mu;
  const ArrayXd rate = d.sigma.cwiseQuotient(d.mu);
  const ArrayXd per = 1 / mu / d.mu.array();
  const ArrayXd apart = per / (own - rate), sum = 1 / (sigma * d.mu + mu * d.sigma).array();
  for (Index p = 0; p < count; ++p) {
    const double front = nodes_.from_front(k, p), back = nodes_.from_back(k, p);
    for (Index i = 0; i < size; ++i) {
      const double beam = d.from_front(i, p);
      const double x = (own - rate[i]) * t_[p], y = (own + rate[i]) * rest_[p];
      f.same(i, p) = std::abs(x) > kSmall ? (beam - front) * apart[i]
                                          : finite(beam * t_[p] * per[i]) * mean_decay(x);
      f.other(i, p) = y > kSmall ? beam * (1 - back * d.from_back(i, p)) * sum[i]
                                 : finite(beam * rest_[p] * per[i]) * mean_decay(y);
    }
  }
  return f;
}

Lobes ThirdOrder::lobes(const Parts& kernel, const MatrixXd& on_out, const MatrixXd& back_out,
                        const MatrixXd& on_in, const MatrixXd& back_in,
                        const MatrixProduct& product) const {
  const Index n = root_.size(), rows = on_out.rows(), columns = on_in.rows(),
              count = weights_.size();
  const auto root = root_.asDiagonal();
  const MatrixXd on = root * kernel[kAboveToDown].topLeftCorner(n, n) * root;
  const MatrixXd back = root * kernel[kAboveToUp].topLeftCorner(n, n) * root;
  const bool is_kept = !kept_in_.empty();
  Light made;
  const auto light_of = [&](Index k, const Beams& beams,
                            const std::vector<Light>& kept) -> const Light& {
    return is_kept ? kept[k] : made = light(k, beams, std::move(made));
  };
  // Order 1 at the nodes (columns) by column and depth, the sum and the difference of both ways.
  MatrixXd sum(columns * count, n), difference(columns * count, n);
  for (Index k = 0; k < n; ++k) {
    const Light& f = light_of(k, in_, kept_in_);
    const VectorXd with = root_[k] * on_in.col(k), against = root_[k] * back_in.col(k);
    sum.col(k).reshaped(columns, count) = with.asDiagonal() * f.same;
    difference.col(k) = sum.col(k);
    sum.col(k).reshaped(columns, count) += against.asDiagonal() * f.other;
    difference.col(k).reshaped(columns, count) -= against.asDiagonal() * f.other;
  }
  // The source of order 2, in the same way.
  const MatrixXd whole = product(sum, ((on + back) / 2).transpose().eval()),
                 odd = product(difference, ((on - back) / 2).transpose().eval());
  Lobes f{MatrixXd::Zero(rows, columns), MatrixXd::Zero(rows, columns)};
  MatrixXd down(count, columns), up(count, columns), as_it_is(rows, count), turned(rows, count);
  for (Index k = 0; k < n; ++k) {
    const auto a = whole.col(k).reshaped(columns, count), b = odd.col(k).reshaped(columns, count);
    down = weights_.asDiagonal() * (a + b).transpose();
    up = weights_.asDiagonal() * (a - b).transpose();
    const Light& sent = light_of(k, out_, kept_out_);
    const VectorXd with = root_[k] * on_out.col(k), against = root_[k] * back_out.col(k);
    as_it_is = against.asDiagonal() * sent.other;
    if (infinite_) {
      product.add(as_it_is, down, f.r);
      turned = with.asDiagonal() * sent.same;
      product.add(turned, up, f.r);
      continue;
    }
    // Turned over, the layer is the same: r + t and r - t are one product each. They stand in the
    // places of r and t until the end.
    turned = with.asDiagonal() * sent.same.rowwise().reverse();
    product.add(as_it_is + turned, down + up.colwise().reverse(), f.r);
    product.add(as_it_is - turned, down - up.colwise().reverse(), f.t);
  }
  if (infinite_) return f;
  const MatrixXd both = f.r;
  f.r = (both + f.t) / 2;
  f.t = (both - f.t) / 2;
  return f;
}

}  // namespace lamella
