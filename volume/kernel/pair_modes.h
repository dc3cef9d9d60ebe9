#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "phase/math/color.h"
#include "phase/math/direction.h"
#include "volume/algebra/matrix_product.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {

/// A pair of directions seen through h = w_i + w_o: its horizontal part squared at x = 0 and twice
/// the product of the sines, so that |h_xy|^2 = gap + 2 product (1 - cos x).
struct Pair {
  double hz, gap, product;
  Pair(double mu_i, double mu_o) : hz(mu_i + mu_o), product(sine(mu_i) * sine(mu_o)) {
    // s_i - s_o without cancellation
    const double sum = sine(mu_i) + sine(mu_o);
    const double difference = sum > 0 ? (mu_o - mu_i) * (mu_o + mu_i) / sum : 0;
    gap = difference * difference;
  }
};

/// The medium as the azimuthal quadrature sees it. value: the kernel by |h_xy|^2 and h_z. reach: by
/// mu_i, mu_o and the gap, the square of the imaginary part of the kernel's nearest singularity in
/// x, times the product of the sines. peak_at_zero_x: whether the singularity is near x = 0; else
/// near pi. is_even: whether the value is the same for -h_z.
template <class F, class G>
struct Profile {
  F value;
  G reach;
  bool peak_at_zero_x = true;
  bool is_even = true;
};
template <class F, class G>
Profile(F, G, bool, bool) -> Profile<F, G>;

/// Points in the azimuth for kernels whose nearest singularity is at distance b from y = 0 in the
/// imaginary direction, and for the cosines of `modes` modes.
struct AzimuthRule {
  Eigen::ArrayXd y, weight;
  Eigen::ArrayXd sine2, cosine2;  ///< of y / 2, squared
  Eigen::MatrixXd cosines;        ///< cos(m y), rows: modes; empty for many of them
};

/// Gauss-Legendre in a variable whose density over y in (0, pi) is that of asinh(y / b), for the
/// singularity, plus a uniform one, for the cosines. b is rounded down to a power of sqrt(2), and
/// each rule is made once per thread.
[[nodiscard]] const AzimuthRule& azimuth_rule(double b, int modes);

/// The kernel of one pair at the points of its rule times their weights. white: the sum without
/// Schlick's factor.
template <class P>
const AzimuthRule& pair_values(const P& profile, double f0, const Pair& pair,
                               const AzimuthRule& rule, Eigen::Ref<Eigen::ArrayXd> values,
                               double& white) {
  const Eigen::ArrayXd hxy2 =
      pair.gap + 4 * pair.product * (profile.peak_at_zero_x ? rule.sine2 : rule.cosine2);
  values = rule.weight;
  for (Eigen::Index k = 0; k < values.size(); ++k) values[k] *= profile.value(hxy2[k], pair.hz);
  white = values.sum();
  if (f0 != 1)  // the cosine of the half angle is |h| / 2
    for (Eigen::Index k = 0; k < values.size(); ++k)
      values[k] *= f0 + (1 - f0) * schlick_weight(std::sqrt(hxy2[k] + pair.hz * pair.hz) / 2);
  return rule;
}

template <class P>
const AzimuthRule& rule_of_pair(const P& profile, double mu_i, double mu_o, const Pair& pair,
                                int modes) {
  const double reach = profile.reach(mu_i, mu_o, pair.gap);
  return azimuth_rule(std::sqrt(reach / std::max(pair.product, 1e-300)), modes);
}

/// Sums of values times cos(m x) over the points of a rule, for the first result.size() modes.
void sum_modes(const AzimuthRule& rule, bool peak_at_zero_x, const Eigen::ArrayXd& values,
               Eigen::Ref<Eigen::ArrayXd> result);

/// The first result.size() modes of one pair, and the white mode 0.
template <class P>
void pair_modes(const P& profile, double f0, double mu_i, double mu_o, Eigen::ArrayXd& result,
                double& white) {
  const Pair pair(mu_i, mu_o);
  const AzimuthRule& rule =
      rule_of_pair(profile, mu_i, mu_o, pair, static_cast<int>(result.size()));
  Eigen::ArrayXd values(rule.y.size());
  pair_values(profile, f0, pair, rule, values, white);
  sum_modes(rule, profile.peak_at_zero_x, values, result);
}

/// Signed cosines of w_i and w_o.
struct CosinePair {
  double mu_i, mu_o;
};

/// The same for many pairs: rows: the modes and, last, the white mode 0; columns: pairs. Those that
/// share a rule are one product of matrices.
template <class P>
Eigen::MatrixXd many_pair_modes(const P& profile, double f0, const std::vector<CosinePair>& pairs,
                                int modes, const MatrixProduct& product) {
  struct Group {
    const AzimuthRule* rule;
    std::vector<Eigen::Index> places{};
  };
  std::vector<Group> groups;
  const auto count = static_cast<Eigen::Index>(pairs.size());
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto [mu_i, mu_o] = pairs[k];
    const AzimuthRule& rule = rule_of_pair(profile, mu_i, mu_o, Pair(mu_i, mu_o), modes);
    auto group =
        std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.rule == &rule; });
    if (group == groups.end()) group = groups.insert(group, {&rule});
    group->places.push_back(k);
  }
  Eigen::MatrixXd result(modes + 1, count);
  for (const Group& group : groups) {
    const bool is_table = group.rule->cosines.size() > 0;
    const auto size = static_cast<Eigen::Index>(group.places.size());
    Eigen::MatrixXd values(group.rule->y.size(), size);
    Eigen::ArrayXd one(is_table ? 0 : modes);
    for (Eigen::Index k = 0; k < size; ++k) {
      const auto [mu_i, mu_o] = pairs[group.places[k]];
      double white = 0;
      pair_values(profile, f0, Pair(mu_i, mu_o), *group.rule, values.col(k).array(), white);
      result(modes, group.places[k]) = white;
      if (is_table) continue;
      sum_modes(*group.rule, profile.peak_at_zero_x, values.col(k), one);
      result.col(group.places[k]).head(modes) = one;
    }
    if (!is_table) continue;
    const Eigen::MatrixXd sums = product(group.rule->cosines, values);
    for (Eigen::Index k = 0; k < size; ++k) result.col(group.places[k]).head(modes) = sums.col(k);
    if (!profile.peak_at_zero_x)
      for (const Eigen::Index place : group.places)
        for (int m = 1; m < modes; m += 2) result(m, place) *= -1;
  }
  return result;
}

}  // namespace lamella
