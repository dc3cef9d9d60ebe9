#include "volume/solver/second_order.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "volume/kernel/azimuthal_kernel.h"
#include "volume/kernel/kernel_profiles.h"
#include "volume/quadrature/depth_integrals.h"

namespace lamella {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;

// Tanh-sinh: points beyond carry less than 1e-12 of an interval.
constexpr double kReach = 2.9;
constexpr int kFinest = 6;  // steps 1/2 ... 2^-kFinest

double tau(double rate, double depth) { return rate == 0 || depth == 0 ? 0 : rate * depth; }

// Points of the azimuth of w' as distances y from that of -w_i; 4 sin^2(y / 2) to both peaks.
struct Azimuths {
  ArrayXd near_in, near_out, weight;
};

// b_in, b_out: distance of the nearest singularity of either kernel. separation: azimuth between
// the peaks, in [0, pi].
Azimuths azimuths(double separation, double b_in, double b_out) {
  struct Half {
    double length, b;
    bool from_in;  // measured from the peak of the first event
    double sign;   // of the other peak's place
  };
  const double wide = kPi - separation / 2, narrow = separation / 2;
  // The other peak lies close behind the start of a wide half where the two are close.
  const double wide_in = std::min(b_in, std::hypot(separation, b_out));
  const double wide_out = std::min(b_out, std::hypot(separation, b_in));
  const Half halves[4] = {{wide, wide_in, true, -1},
                          {wide, wide_out, false, -1},
                          {narrow, b_in, true, 1},
                          {narrow, b_out, false, 1}};
  const auto points = [](const Half& half) {
    return half.length == 0 ? 0 : static_cast<int>(18 + 5 * std::asinh(half.length / half.b));
  };
  Index count = 0;
  for (const Half& half : halves) count += points(half);
  Azimuths result{ArrayXd(count), ArrayXd(count), ArrayXd(count)};
  Index k = 0;
  const auto chord2 = [](double y) {
    const double s = std::sin(y / 2);
    return 4 * s * s;
  };
  for (const Half& half : halves) {
    const int n = points(half);
    if (n == 0) continue;
    const Quadrature& rule = cached_gauss_legendre(n);
    const double stretch = std::asinh(half.length / half.b);
    for (int l = 0; l < n; ++l, ++k) {
      const double e = std::exp(stretch * rule.points[l]);
      const double y = half.b * (e - 1 / e) / 2;
      result.weight[k] = rule.weights[l] * stretch * half.b * (e + 1 / e) / 2;
      const double here = chord2(y), there = chord2(separation - half.sign * y);
      result.near_in[k] = half.from_in ? here : there;
      result.near_out[k] = half.from_in ? there : here;
    }
  }
  return result;
}

// Integral over mu' from -1 to 1 of an integrand with singularities at -1, 0, 1, -mu_i and mu_o, on
// ever finer levels until `is_enough(level, integral)`.
template <class Sum, class At, class IsEnough>
void integrate(double mu_i, double mu_o, const Sum& zero, const At& at, const IsEnough& is_enough) {
  std::vector<double> breaks{-1, 0, 1, -mu_i, mu_o};
  std::sort(breaks.begin(), breaks.end());
  Sum sum = zero;
  for (int level = 1; level <= kFinest; ++level) {
    const double step = std::ldexp(1.0, -level);
    Sum added = zero;
    for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
      const double half = (breaks[k + 1] - breaks[k]) / 2;
      if (half < 1e-14) continue;
      const int last = static_cast<int>(kReach / step);
      for (int n = -last; n <= last; ++n) {
        if (level > 1 && n % 2 == 0) continue;
        const double t = n * step, s = kPi / 2 * std::sinh(t);
        // Distance from the nearer end, without cancellation.
        const double to_end = half * std::exp(-std::abs(s)) / std::cosh(s);
        const double mu = s < 0 ? breaks[k] + to_end : breaks[k + 1] - to_end;
        if (mu == 0) continue;
        const double weight = half * kPi / 2 * std::cosh(t) / (std::cosh(s) * std::cosh(s));
        added += weight * at(mu);
      }
    }
    sum = level == 1 ? Sum(added * step) : Sum(sum / 2 + added * step);
    if (is_enough(level, sum)) break;
  }
}

}  // namespace

// One pair of directions.
struct SecondOrder::Pass {
  const SecondOrder& self;
  Direction wi, wo;
  bool from_above, reflects;
  double separation;  // azimuth between the two peaks
  // Per layer in the order that light meets them.
  std::vector<const Layer*> layers;
  std::vector<int> kinds;
  std::vector<double> a, b, in, out;  // rates along w_i and w_o; attenuation outside the layer

  Pass(const SecondOrder& s, Direction i, Direction o) : self(s), wi(i), wo(o) {
    from_above = wi.z > 0;
    reflects = (wi.z > 0) == (wo.z > 0);
    const double phi = std::atan2(wi.x * wo.y - wi.y * wo.x, wi.x * wo.x + wi.y * wo.y);
    separation = kPi - std::abs(phi);
    const std::size_t n = s.stack_.layers.size();
    double tau_in = 0, tau_out = 0;
    for (std::size_t step = 0; step < n; ++step) {
      const std::size_t k = from_above ? step : n - 1 - step;
      const Layer& layer = s.stack_.layers[k];
      layers.push_back(&layer);
      kinds.push_back(s.kind_of_[k]);
      a.push_back(sigma(layer.medium, wi) / std::abs(wi.z));
      b.push_back(sigma(layer.medium, -wo) / std::abs(wo.z));
      in.push_back(tau_in);
      out.push_back(tau_out);
      tau_in += tau(a.back(), layer.depth());
      tau_out += tau(b.back(), layer.depth());
    }
    if (!reflects) {
      double far = 0;
      for (std::size_t step = n; step-- > 0;) {
        out[step] = far;
        far += tau(b[step], layers[step]->depth());
      }
    }
  }

  // Coefficients of K_j K_k by kind, the integral over both depths, at cosine mu of w'.
  [[nodiscard]] MatrixXd depths(double mu) const {
    const std::size_t n = layers.size();
    const Index kind_count = static_cast<Index>(self.kinds_.size());
    MatrixXd sum = MatrixXd::Zero(kind_count, kind_count);
    const bool onward = (mu > 0) != from_above;
    const Direction back_along{-std::sqrt((1 - mu) * (1 + mu)), 0, -mu};
    // Light of order 1 on its way along w', by the kind that sent it.
    Eigen::VectorXd carried = Eigen::VectorXd::Zero(kind_count);
    for (std::size_t step = 0; step < n; ++step) {
      const std::size_t s = onward ? step : n - 1 - step;
      const double depth = layers[s]->depth();
      if (depth == 0) continue;
      const double c = sigma(layers[s]->medium, back_along) / std::abs(mu);
      const int kind = kinds[s];
      const double enter = std::exp(-in[s]), leave = std::exp(-out[s]);
      if (kind >= 0) {
        if (a[s] > 0 && enter > 0 && leave > 0) {
          const double both =
              onward ? (reflects ? decay_integral(a[s] + b[s], b[s] + c, depth)
                                 : crossing_integral(a[s], c, b[s], depth))
                     : (reflects ? decay_integral(a[s] + b[s], a[s] + c, depth)
                                 : crossing_integral(a[s], b[s], a[s] + b[s] + c, depth));
          sum(kind, kind) += enter * leave * both;
        }
        // Onward light enters at the near face, light on its way back at the far one.
        if (leave > 0) {
          const double seen = onward == reflects ? decay_integral(b[s] + c, depth)
                                                 : crossing_integral(c, b[s], depth);
          sum.col(kind) += leave * seen * carried;
        }
      }
      carried *= std::exp(-tau(c, depth));
      if (kind >= 0 && a[s] > 0 && enter > 0)
        carried[kind] +=
            enter * (onward ? crossing_integral(a[s], c, depth) : decay_integral(a[s] + c, depth));
    }
    return sum;
  }

  // Modes of the kernels of both events, a column per kind; combined like the kernels themselves.
  [[nodiscard]] ArrayXd modes_at(double mu, int count) const {
    const MatrixXd coefficient = depths(mu);
    const Index kind_count = static_cast<Index>(self.kinds_.size());
    Eigen::ArrayXXd k1(count, kind_count), k2(count, kind_count);
    ArrayXd values(count);
    for (Index k = 0; k < kind_count; ++k) {
      const Kind& kind = self.kinds_[k];
      visit_profile(self.stack_.layers[kind.layer].medium, [&](const auto& profile) {
        double white = 0;
        pair_modes(profile, kind.f0, wi.z, mu, values, white);
        k1.col(k) = kind.albedo * values;
        pair_modes(profile, kind.f0, -mu, wo.z, values, white);
        k2.col(k) = kind.albedo * values;
      });
    }
    ArrayXd sum = ArrayXd::Zero(count);
    for (Index j = 0; j < kind_count; ++j)
      for (Index k = 0; k < kind_count; ++k)
        if (coefficient(j, k) != 0) sum += coefficient(j, k) * k1.col(j) * k2.col(k);
    return sum / std::abs(mu);
  }

  // The integrand over mu', all but the common factor.
  [[nodiscard]] double at(double mu) const {
    const MatrixXd coefficient = depths(mu);
    const Pair first(wi.z, mu), second(-mu, wo.z);
    const Index kind_count = static_cast<Index>(self.kinds_.size());
    double b_in = 4, b_out = 4;
    for (const Kind& kind : self.kinds_)
      visit_profile(self.stack_.layers[kind.layer].medium, [&](const auto& profile) {
        const auto reach = [](double squared, const Pair& pair) {
          return std::sqrt(squared / std::max(pair.product, 1e-300));
        };
        b_in = std::min(b_in, reach(profile.reach(wi.z, mu, first.gap), first));
        b_out = std::min(b_out, reach(profile.reach(-mu, wo.z, second.gap), second));
      });
    const Azimuths points = azimuths(separation, std::max(b_in, 1e-14), std::max(b_out, 1e-14));
    const Index count = points.weight.size();
    Eigen::ArrayXXd k1(count, kind_count), k2(count, kind_count);
    for (Index k = 0; k < kind_count; ++k) {
      const Kind& kind = self.kinds_[k];
      visit_profile(self.stack_.layers[kind.layer].medium, [&](const auto& profile) {
        const auto fill = [&](auto column, const ArrayXd& chord2, const Pair& pair) {
          for (Index p = 0; p < count; ++p) {
            const double hxy2 = pair.gap + pair.product * chord2[p];
            double value = profile.value(hxy2, pair.hz);
            if (kind.f0 != 1)
              value *=
                  kind.f0 + (1 - kind.f0) * schlick_weight(std::sqrt(hxy2 + pair.hz * pair.hz) / 2);
            column[p] = kind.albedo * value;
          }
        };
        fill(k1.col(k), points.near_in, first);
        fill(k2.col(k), points.near_out, second);
      });
    }
    double sum = 0;
    for (Index j = 0; j < kind_count; ++j)
      for (Index k = 0; k < kind_count; ++k)
        if (coefficient(j, k) != 0)
          sum += coefficient(j, k) * (k1.col(j) * k2.col(k) * points.weight).sum();
    return sum / std::abs(mu);
  }
};

SecondOrder::SecondOrder(const Stack& stack, int channel) : stack_(stack) {
  for (std::size_t l = 0; l < stack.layers.size(); ++l) {
    const Layer& layer = stack.layers[l];
    const double albedo = layer.albedo[channel], f0 = layer.f0[channel];
    int kind = -1;
    if (albedo > 0 && visit_profile(layer.medium, [](const auto&) {})) {
      const auto same = [&](const Kind& k) {
        return k.albedo == albedo && k.f0 == f0 && stack.layers[k.layer].medium == layer.medium;
      };
      const auto it = std::find_if(kinds_.begin(), kinds_.end(), same);
      kind = static_cast<int>(it - kinds_.begin());
      if (it == kinds_.end()) kinds_.push_back({l, albedo, f0});
    }
    kind_of_.push_back(kind);
  }
}

bool SecondOrder::is_dark(double mu_i, double mu_o) const {
  return kinds_.empty() || (!stack_.is_open_below() && (mu_i < 0 || mu_o < 0));
}

SecondOrder::Value SecondOrder::operator()(Direction wi, Direction wo, double tolerance) const {
  if (is_dark(wi.z, wo.z)) return {};
  const Pass pass(*this, wi, wo);
  const double common = 1 / (std::abs(wi.z) * std::abs(wo.z));
  Value result;
  integrate(
      wi.z, wo.z, 0.0, [&](double mu) { return pass.at(mu); },
      [&](int level, double sum) {
        const double f = common * sum;
        result.error = std::abs(f - result.f);
        result.f = f;
        // The error falls like the square or faster: the change bounds that of the last level.
        return level > 2 && result.error < tolerance;
      });
  return result;
}

SecondOrder::Modes SecondOrder::modes(double mu_i, double mu_o, int count, double tolerance) const {
  Modes result{ArrayXd::Zero(count)};
  if (is_dark(mu_i, mu_o)) return result;
  const Pass pass(*this, direction_from_mu_phi(mu_i, 0), direction_from_mu_phi(mu_o, 0));
  const double common = 2 * kPi / (std::abs(mu_i) * std::abs(mu_o));
  double before = 0;  // change under the doubling before
  integrate(
      mu_i, mu_o, ArrayXd(ArrayXd::Zero(count)),
      [&](double mu) { return pass.modes_at(mu, count); },
      [&](int level, const ArrayXd& sum) {
        const ArrayXd difference = (common * sum - result.f).abs();
        const double change = 2 * difference.sum() - difference[0];
        result.f = common * sum;
        result.error = before > 0 ? change * std::clamp(change / before, 1e-2, 1.0) : change;
        before = change;
        return level > 2 && result.error < tolerance;
      });
  return result;
}

}  // namespace lamella
