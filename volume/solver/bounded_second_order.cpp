#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "volume/adding/smooth_boundary.h"
#include "volume/quadrature/depth_integrals.h"
#include "volume/solver/second_order_pass.h"
#include "volume/solver/stack_beams.h"

namespace lamella {
namespace {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;

// Light travels down or up before an event and after it.
enum Way : int { kDown, kUp };
constexpr std::array<Way, 2> kWays{kDown, kUp};

double survives(double rate, double depth) {
  return rate == 0 || depth == 0 ? 1 : std::exp(-rate * depth);
}

// How an element passes light along w' on. `kept` is 1 less what two crossings leave.
struct Crossing {
  double reflected, transmitted, down, up, kept;
};

class BoundedPass final : public SecondOrderPass {
 public:
  BoundedPass(const Stack& stack, const SecondKinds& kinds, Direction wi, Direction wo)
      : stack_(stack),
        kinds_(kinds),
        elements_(elements_of(stack)),
        in_(beam_of(elements_, wi, false)),
        out_(beam_of(elements_, wo, true)) {
    separation_ = peak_separation(wi, wo);
    const double above = elements_.front().above, below = elements_.back().below;
    to_ = wo.z > 0 ? above : below;
    for (const SecondKind& kind : kinds.kinds) densest_ = std::max(densest_, kind.index);
    for (const StackElement& e : elements_)
      kind_of_.push_back(e.layer ? kinds.of_layer[e.layer - stack.layers.data()] : -1);
    for (const SecondKind& kind : kinds.kinds) {
      kind_in_.push_back(snell_cosine(std::abs(wi.z), wi.z > 0 ? above : below, kind.index));
      kind_out_.push_back(snell_cosine(std::abs(wo.z), to_, kind.index));
    }
    breaks = {{0},
              {1},
              {snell_cosine(std::abs(wi.z), wi.z > 0 ? above : below, densest_)},
              {snell_cosine(std::abs(wo.z), to_, densest_)}};
    // Light that passes critical angles of several boundaries: no level foretells the next.
    fall = 1;
    for (std::size_t p = 0; p <= elements_.size(); ++p) {
      const double index = p == 0 ? above : elements_[p - 1].below;
      critical_.push_back(index < densest_ ? std::sqrt(1 - index * index / (densest_ * densest_))
                                           : 0);
      indices_.push_back(index);
      breaks.push_back({critical_.back(), true});
    }
    for (const SecondKind& kind : kinds.kinds) {
      first_kernel_.push_back(kernels_);
      visit_profile(stack.layers[kind.layer].medium, [&](const auto& profile) {
        is_even_.push_back(profile.is_even);
        kernels_ += profile.is_even ? 2 : 4;
      });
    }
    for (const SecondKind& kind : kinds.kinds)
      kind_place_.push_back(std::find(indices_.begin(), indices_.end(), kind.index) -
                            indices_.begin());
  }

  [[nodiscard]] double at(const BetweenCosine& between) const override {
    const std::vector<double> mu = cosines(between);
    const MatrixXd coefficient = depths(mu);
    double b_in = 4, b_out = 4;
    each_kernel(mu, [&](Index, const SecondKind&, const auto& profile, double mi, double m,
                        double n, double mo) {
      b_in = std::min(b_in, peak_distance(profile, mi, m, Pair(mi, m)));
      b_out = std::min(b_out, peak_distance(profile, n, mo, Pair(n, mo)));
    });
    const BetweenAzimuths points =
        between_azimuths(separation_, std::max(b_in, 1e-14), std::max(b_out, 1e-14));
    ArrayXXd k1 = ArrayXXd::Zero(points.weight.size(), coefficient.rows()), k2 = k1;
    each_kernel(mu, [&](Index place, const SecondKind& kind, const auto& profile, double mi,
                        double m, double n, double mo) {
      fill_kernel(profile, kind, points.near_in, Pair(mi, m), k1.col(place));
      fill_kernel(profile, kind, points.near_out, Pair(n, mo), k2.col(place));
    });
    k1.colwise() *= points.weight;
    const MatrixXd sums = k1.matrix().transpose() * k2.matrix();
    return between.mu * sums.cwiseProduct(coefficient).sum();
  }

  [[nodiscard]] ArrayXd modes_at(const BetweenCosine& between, int count) const override {
    const std::vector<double> mu = cosines(between);
    const MatrixXd coefficient = depths(mu);
    ArrayXXd k1 = ArrayXXd::Zero(count, coefficient.rows()), k2 = k1;
    ArrayXd values(count);
    double white = 0;
    each_kernel(mu, [&](Index place, const SecondKind& kind, const auto& profile, double mi,
                        double m, double n, double mo) {
      pair_modes(profile, kind.f0, mi, m, values, white);
      k1.col(place) = kind.albedo * values;
      pair_modes(profile, kind.f0, n, mo, values, white);
      k2.col(place) = kind.albedo * values;
    });
    const ArrayXXd seen = (k2.matrix() * coefficient.transpose()).array();
    return between.mu * (k1 * seen).rowwise().sum();
  }

 private:
  // The kernels of the first event, and of the second, by kind and ways: an even one is the same
  // turned upside down.
  [[nodiscard]] Index kernel_of(int kind, Way before, Way after) const {
    return first_kernel_[kind] + (is_even_[kind] ? (before != after) : 2 * before + after);
  }

  // |mu'| at each place between elements; 0: light along w' is reflected before.
  [[nodiscard]] std::vector<double> cosines(const BetweenCosine& between) const {
    std::vector<double> mu(indices_.size());
    for (std::size_t p = 0; p < mu.size(); ++p) {
      const double ratio = densest_ / indices_[p], critical = critical_[p];
      if (critical > 0) {
        const double beyond = between.minus(critical);
        mu[p] = beyond > 0 ? std::min(1.0, ratio * std::sqrt(beyond * (between.mu + critical))) : 0;
      } else {
        mu[p] = snell_cosine(between.mu, densest_, indices_[p]);
      }
    }
    return mu;
  }

  // f(place, kind, profile, mu_i, mu', -mu', mu_o) for all kernels that w' reaches; the first event
  // and the second of a place share no ways but their order.
  template <class F>
  void each_kernel(const std::vector<double>& mu, const F& f) const {
    for (std::size_t k = 0; k < kinds_.kinds.size(); ++k) {
      const double between = mu[kind_place_[k]];
      if (between == 0) continue;
      visit_profile(stack_.layers[kinds_.kinds[k].layer].medium, [&](const auto& profile) {
        for (const Way before : kWays)
          for (const Way after : kWays) {
            if (before == kUp && is_even_[k]) continue;
            // Light that travels down comes from above, and is sent below.
            const double mi = before == kDown ? kind_in_[k] : -kind_in_[k];
            const double sent = after == kDown ? -between : between;
            const double came = before == kDown ? between : -between;
            const double mo = after == kDown ? -kind_out_[k] : kind_out_[k];
            f(kernel_of(static_cast<int>(k), before, after), kinds_.kinds[k], profile, mi, sent,
              came, mo);
          }
      });
    }
  }

  // Coefficients of the kernels of both events (rows: the first) at these |mu'|, all but a factor
  // mu' of the densest medium.
  [[nodiscard]] MatrixXd depths(const std::vector<double>& mu) const {
    const std::size_t n = elements_.size();
    MatrixXd result = MatrixXd::Zero(kernels_, kernels_);
    std::vector<Crossing> crossings(n);
    std::vector<std::array<double, 2>> rate(n);
    // What each layer sends out of its top and bottom, by kernel of the first event.
    std::vector<std::array<RowVectorXd, 2>> sent(n, {RowVectorXd(), RowVectorXd()});
    for (std::size_t e = 0; e < n; ++e) {
      const StackElement& element = elements_[e];
      if (!element.layer) {
        const SmoothShares s = smooth_shares(element.above, mu[e], element.below, mu[e + 1]);
        crossings[e] = {s.reflected, s.transmitted, s.transmitted, s.transmitted, 0};
        continue;
      }
      if (mu[e] == 0) continue;  // nothing gets here
      const double depth = element.layer->depth(), sine = std::sqrt((1 - mu[e]) * (1 + mu[e]));
      for (const Way way : kWays)
        rate[e][way] =
            sigma(element.layer->medium, {sine, 0, way == kDown ? mu[e] : -mu[e]}) / mu[e];
      const double both = rate[e][kDown] + rate[e][kUp];
      crossings[e] = {0, 0, survives(rate[e][kDown], depth), survives(rate[e][kUp], depth),
                      both == 0 ? 0 : -std::expm1(-both * depth)};
      if (kind_of_[e] >= 0) events(e, mu[e], rate[e], sent[e], result);
    }
    // The share of light travelling down at each place that comes back from beyond, 1 less that,
    // and what comes up from the layers beyond.
    std::vector<double> beyond(n + 1, 0.0), gone(n + 1, 1.0);
    std::vector<RowVectorXd> rising(n + 1, RowVectorXd::Zero(kernels_)), falling = rising;
    const auto trapped = [&](std::size_t e) {
      return elements_[e].layer ? 1
                                : crossings[e].transmitted + crossings[e].reflected * gone[e + 1];
    };
    for (std::size_t e = n; e-- > 0;) {
      const Crossing& c = crossings[e];
      const double open = trapped(e);
      if (elements_[e].layer) {
        beyond[e] = c.down * c.up * beyond[e + 1];
        gone[e] = c.kept + c.down * c.up * gone[e + 1];
        rising[e] = c.up * rising[e + 1];
        if (sent[e][kUp].size() > 0)
          rising[e] += sent[e][kUp] + c.up * beyond[e + 1] * sent[e][kDown];
      } else if (open > 0) {
        beyond[e] = c.reflected + c.transmitted * c.transmitted * beyond[e + 1] / open;
        gone[e] = c.transmitted * gone[e + 1] / open;
        rising[e] = c.transmitted / open * rising[e + 1];
      } else {
        beyond[e] = 1;
        gone[e] = 0;
      }
    }
    for (std::size_t e = 0; e < n; ++e) {
      const Crossing& c = crossings[e];
      if (!elements_[e].layer) {
        const double open = trapped(e);
        if (open > 0)
          falling[e + 1] = (c.transmitted * falling[e] + c.reflected * rising[e + 1]) / open;
        continue;
      }
      falling[e + 1] = c.down * falling[e];
      if (sent[e][kDown].size() > 0) falling[e + 1] += sent[e][kDown];
      if (kind_of_[e] < 0 || mu[e] == 0) continue;
      // Light that enters through the top and through the bottom, as the second event sees it.
      const RowVectorXd from_below = beyond[e + 1] * falling[e + 1] + rising[e + 1];
      const double depth = elements_[e].layer->depth();
      for (const Way came : kWays)
        for (const Way leaves : kWays) {
          const double share = leaving(e, leaves);
          if (!(share > 0)) continue;
          const double b = leaves == kUp ? out_.rate_down[e] : out_.rate_up[e];
          const double seen = came == leaves ? crossing_integral(rate[e][came], b, depth)
                                             : decay_integral(rate[e][came] + b, depth);
          result.col(kernel_of(kind_of_[e], came, leaves)) +=
              share * seen / mu[e] * (came == kDown ? falling[e] : from_below).transpose();
        }
    }
    return result;
  }

  // The adjoint beam's share, with its factor of radiance, where light leaves the layer that way.
  [[nodiscard]] double leaving(std::size_t e, Way way) const {
    if (out_.mu[e] == 0) return 0;
    const double index = elements_[e].above;
    return (way == kUp ? out_.down[e] : out_.up[e + 1]) * (to_ / index) * (to_ / index) /
           out_.mu[e];
  }

  // Both events in one layer, and what its first events send out of it.
  void events(std::size_t e, double mu, const std::array<double, 2>& rate,
              std::array<RowVectorXd, 2>& sent, MatrixXd& result) const {
    const double depth = elements_[e].layer->depth(), index = elements_[e].above;
    sent.fill(RowVectorXd::Zero(result.rows()));
    if (in_.mu[e] == 0) return;
    // q dq of the horizontal part q of index times w' is index^2 mu' dmu' in every medium.
    const double factor = densest_ * densest_ / (index * index * in_.mu[e] * mu);
    for (const Way came : kWays) {
      const double arrives = came == kDown ? in_.down[e] : in_.up[e + 1];
      if (!(arrives > 0)) continue;
      const double a = came == kDown ? in_.rate_down[e] : in_.rate_up[e];
      for (const Way between : kWays) {
        const double c = rate[between];
        const Index first = kernel_of(kind_of_[e], came, between);
        sent[between][first] +=
            arrives * factor *
            (came == between ? crossing_integral(a, c, depth) : decay_integral(a + c, depth));
        for (const Way leaves : kWays) {
          const double share = leaving(e, leaves);
          if (!(share > 0)) continue;
          const double b = leaves == kUp ? out_.rate_down[e] : out_.rate_up[e];
          // Turned upside down if need be, w' travels down.
          const double both = came == between
                                  ? (leaves == between ? crossing_integral(a, c, b, depth)
                                                       : decay_integral(a + b, b + c, depth))
                                  : (leaves == between ? decay_integral(a + c, a + b, depth)
                                                       : crossing_integral(b, a + b + c, a, depth));
          result(first, kernel_of(kind_of_[e], between, leaves)) +=
              arrives * factor * share / mu * both;
        }
      }
    }
  }

  const Stack& stack_;
  const SecondKinds& kinds_;
  std::vector<StackElement> elements_;
  StackBeam in_, out_;
  double separation_ = 0, to_ = 1, densest_ = 0;
  std::vector<Index> first_kernel_;  // by kind
  std::vector<bool> is_even_;        // by kind
  Index kernels_ = 0;
  std::vector<int> kind_of_;                // by element
  std::vector<double> indices_, critical_;  // by place; cosine in the densest medium, 0: none
  std::vector<double> kind_in_, kind_out_;  // |mu_i|, |mu_o| in the medium of each kind
  std::vector<std::size_t> kind_place_;     // a place of that index
};

}  // namespace

std::unique_ptr<SecondOrderPass> bounded_second_order(const Stack& stack, const SecondKinds& kinds,
                                                      Direction wi, Direction wo) {
  return std::make_unique<BoundedPass>(stack, kinds, wi, wo);
}

}  // namespace lamella
