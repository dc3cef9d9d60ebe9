#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "volume/quadrature/depth_integrals.h"
#include "volume/solver/second_order_pass.h"

namespace lamella {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;

double tau(double rate, double depth) { return rate == 0 || depth == 0 ? 0 : rate * depth; }

class OpenPass final : public SecondOrderPass {
 public:
  OpenPass(const Stack& stack, const SecondKinds& kinds, Direction wi, Direction wo)
      : stack_(stack), kinds_(kinds), mu_i_(wi.z), mu_o_(wo.z) {
    breaks = {{-1}, {0}, {1}, {-wi.z}, {wo.z}};
    common = 1 / (std::abs(wi.z) * std::abs(wo.z));
    from_above_ = wi.z > 0;
    reflects_ = (wi.z > 0) == (wo.z > 0);
    separation_ = peak_separation(wi, wo);
    const std::size_t n = stack.layers.size();
    double tau_in = 0, tau_out = 0;
    for (std::size_t step = 0; step < n; ++step) {
      const std::size_t k = from_above_ ? step : n - 1 - step;
      const Layer& layer = stack.layers[k];
      layers_.push_back(&layer);
      kind_of_.push_back(kinds.of_layer[k]);
      a_.push_back(sigma(layer.medium, wi) / std::abs(wi.z));
      b_.push_back(sigma(layer.medium, -wo) / std::abs(wo.z));
      in_.push_back(tau_in);
      out_.push_back(tau_out);
      tau_in += tau(a_.back(), layer.depth());
      tau_out += tau(b_.back(), layer.depth());
    }
    if (reflects_) return;
    double far = 0;
    for (std::size_t step = n; step-- > 0;) {
      out_[step] = far;
      far += tau(b_[step], layers_[step]->depth());
    }
  }

  // Modes of the kernels of both events, a column per kind; combined like the kernels themselves.
  [[nodiscard]] ArrayXd modes_at(const BetweenCosine& between, int count) const override {
    const double mu = between.mu;
    const MatrixXd coefficient = depths(mu);
    const Index kind_count = static_cast<Index>(kinds_.kinds.size());
    Eigen::ArrayXXd k1(count, kind_count), k2(count, kind_count);
    ArrayXd values(count);
    for (Index k = 0; k < kind_count; ++k) {
      const SecondKind& kind = kinds_.kinds[k];
      visit_profile(stack_.layers[kind.layer].medium, [&](const auto& profile) {
        double white = 0;
        pair_modes(profile, kind.f0, mu_i_, mu, values, white);
        k1.col(k) = kind.albedo * values;
        pair_modes(profile, kind.f0, -mu, mu_o_, values, white);
        k2.col(k) = kind.albedo * values;
      });
    }
    ArrayXd sum = ArrayXd::Zero(count);
    for (Index j = 0; j < kind_count; ++j)
      for (Index k = 0; k < kind_count; ++k)
        if (coefficient(j, k) != 0) sum += coefficient(j, k) * k1.col(j) * k2.col(k);
    return sum / std::abs(mu);
  }

  [[nodiscard]] double at(const BetweenCosine& between) const override {
    const double mu = between.mu;
    const MatrixXd coefficient = depths(mu);
    const Pair first(mu_i_, mu), second(-mu, mu_o_);
    const Index kind_count = static_cast<Index>(kinds_.kinds.size());
    double b_in = 4, b_out = 4;
    for (const SecondKind& kind : kinds_.kinds)
      visit_profile(stack_.layers[kind.layer].medium, [&](const auto& profile) {
        b_in = std::min(b_in, peak_distance(profile, mu_i_, mu, first));
        b_out = std::min(b_out, peak_distance(profile, -mu, mu_o_, second));
      });
    const BetweenAzimuths points =
        between_azimuths(separation_, std::max(b_in, 1e-14), std::max(b_out, 1e-14));
    const Index count = points.weight.size();
    Eigen::ArrayXXd k1(count, kind_count), k2(count, kind_count);
    for (Index k = 0; k < kind_count; ++k) {
      const SecondKind& kind = kinds_.kinds[k];
      visit_profile(stack_.layers[kind.layer].medium, [&](const auto& profile) {
        fill_kernel(profile, kind, points.near_in, first, k1.col(k));
        fill_kernel(profile, kind, points.near_out, second, k2.col(k));
      });
    }
    double sum = 0;
    for (Index j = 0; j < kind_count; ++j)
      for (Index k = 0; k < kind_count; ++k)
        if (coefficient(j, k) != 0)
          sum += coefficient(j, k) * (k1.col(j) * k2.col(k) * points.weight).sum();
    return sum / std::abs(mu);
  }

 private:
  // Coefficients of K_j K_k by kind, the integral over both depths, at cosine mu of w'.
  [[nodiscard]] MatrixXd depths(double mu) const {
    const std::size_t n = layers_.size();
    const Index kind_count = static_cast<Index>(kinds_.kinds.size());
    MatrixXd sum = MatrixXd::Zero(kind_count, kind_count);
    const bool onward = (mu > 0) != from_above_;
    const Direction back_along{-std::sqrt((1 - mu) * (1 + mu)), 0, -mu};
    // Light of order 1 on its way along w', by the kind that sent it.
    Eigen::VectorXd carried = Eigen::VectorXd::Zero(kind_count);
    for (std::size_t step = 0; step < n; ++step) {
      const std::size_t s = onward ? step : n - 1 - step;
      const double depth = layers_[s]->depth(), a = a_[s], b = b_[s];
      if (depth == 0) continue;
      const double c = sigma(layers_[s]->medium, back_along) / std::abs(mu);
      const int kind = kind_of_[s];
      const double enter = std::exp(-in_[s]), leave = std::exp(-out_[s]);
      if (kind >= 0) {
        if (a > 0 && enter > 0 && leave > 0) {
          const double both = onward ? (reflects_ ? decay_integral(a + b, b + c, depth)
                                                  : crossing_integral(a, c, b, depth))
                                     : (reflects_ ? decay_integral(a + b, a + c, depth)
                                                  : crossing_integral(a, b, a + b + c, depth));
          sum(kind, kind) += enter * leave * both;
        }
        // Onward light enters at the near face, light on its way back at the far one.
        if (leave > 0) {
          const double seen =
              onward == reflects_ ? decay_integral(b + c, depth) : crossing_integral(c, b, depth);
          sum.col(kind) += leave * seen * carried;
        }
      }
      carried *= std::exp(-tau(c, depth));
      if (kind >= 0 && a > 0 && enter > 0)
        carried[kind] +=
            enter * (onward ? crossing_integral(a, c, depth) : decay_integral(a + c, depth));
    }
    return sum;
  }

  const Stack& stack_;
  const SecondKinds& kinds_;
  double mu_i_, mu_o_;
  bool from_above_, reflects_;
  double separation_;  // azimuth between the two peaks
  // Per layer in the order that light meets them.
  std::vector<const Layer*> layers_;
  std::vector<int> kind_of_;
  std::vector<double> a_, b_, in_, out_;  // rates along w_i and w_o; attenuation outside the layer
};

}  // namespace

std::unique_ptr<SecondOrderPass> open_second_order(const Stack& stack, const SecondKinds& kinds,
                                                   Direction wi, Direction wo) {
  return std::make_unique<OpenPass>(stack, kinds, wi, wo);
}

}  // namespace lamella
