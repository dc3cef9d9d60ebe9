#include "volume/kernel/pair_modes.h"

#include <map>
#include <utility>

namespace lamella {
namespace {

// Modes whose cosines are kept with a rule: some hundreds of kilobytes per rule and thread.
constexpr int kMostTabulated = 128;

AzimuthRule make_rule(double b, int modes) {
  const double stretch = std::asinh(kPi / b);
  // Points for the singularity, and for cosines (pi / 4 per mode at least, for the product with the
  // kernel's own modes twice that).
  const double near = 24 + 5 * stretch, uniform = 1.6 * modes + 8;
  const int n = static_cast<int>(near + uniform);
  const Quadrature& gauss = cached_gauss_legendre(n);
  AzimuthRule rule{Eigen::ArrayXd(n), Eigen::ArrayXd(n), {}, {}, {}};
  double y = 0;
  for (int k = 0; k < n; ++k) {
    // near / stretch asinh(y / b) + uniform y / pi = (near + uniform) u: concave, so that Newton's
    // steps from the point before never overshoot.
    const double target = (near + uniform) * gauss.points[k];
    const auto slope = [&] { return near / stretch / std::hypot(y, b) + uniform / kPi; };
    for (int step = 0; step < 100; ++step) {
      const double change =
          (target - near / stretch * std::asinh(y / b) - uniform * y / kPi) / slope();
      y += change;
      if (std::abs(change) <= 1e-15 * y) break;
    }
    rule.y[k] = y;
    rule.weight[k] = gauss.weights[k] * (near + uniform) / slope() / kPi;
  }
  rule.sine2 = (rule.y / 2).sin().square();
  rule.cosine2 = (rule.y / 2).cos().square();
  if (modes > kMostTabulated) return rule;
  rule.cosines.resize(modes, n);
  const Eigen::ArrayXd step = 2 * rule.y.cos();
  Eigen::ArrayXd now = Eigen::ArrayXd::Ones(n), before = step / 2;  // cos(0 y), cos(-y)
  for (int m = 0; m < modes; ++m) {
    rule.cosines.row(m) = now;
    const Eigen::ArrayXd next = step * now - before;
    before.swap(now);
    now = next;
  }
  return rule;
}

}  // namespace

void sum_modes(const AzimuthRule& rule, bool peak_at_zero_x, const Eigen::ArrayXd& values,
               Eigen::Ref<Eigen::ArrayXd> result) {
  const Eigen::Index modes = result.size();
  if (rule.cosines.size() > 0) {
    result.matrix().noalias() = rule.cosines * values.matrix();
    if (!peak_at_zero_x)
      for (Eigen::Index m = 1; m < modes; m += 2) result[m] *= -1;
    return;
  }
  const Eigen::ArrayXd step = (peak_at_zero_x ? 2 : -2) * rule.y.cos();
  Eigen::ArrayXd now = values, before = now * step / 2, next;  // cos(-x), cos(0 x)
  for (Eigen::Index m = 0; m < modes; ++m) {
    result[m] = now.sum();
    next = step * now - before;
    before.swap(now);
    now.swap(next);
  }
}

const AzimuthRule& azimuth_rule(double b, int modes) {
  // Where b is no number, the kernel's values are none either and tell so: any rule will do.
  const double within = b > 1e-8 ? std::min(b, 2.0) : 1e-8;
  const int power = static_cast<int>(std::floor(2 * std::log2(within)));
  thread_local std::map<std::pair<int, int>, AzimuthRule> rules;
  const auto it = rules.find({power, modes});
  if (it != rules.end()) return it->second;
  return rules.emplace(std::pair(power, modes), make_rule(std::exp2(power / 2.0), modes))
      .first->second;
}

}  // namespace lamella
