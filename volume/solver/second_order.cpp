#include "volume/solver/second_order.h"

#include <algorithm>
#include <cmath>

#include "volume/solver/second_order_pass.h"

namespace lamella {

using Eigen::ArrayXd;

SecondKinds::SecondKinds(const Stack& stack, int channel) {
  for (std::size_t l = 0; l < stack.layers.size(); ++l) {
    const Layer& layer = stack.layers[l];
    const double albedo = layer.albedo[channel], f0 = layer.f0[channel], index = stack.index_of(l);
    int kind = -1;
    if (!layer.interface && albedo > 0 && visit_profile(layer.medium, [](const auto&) {})) {
      const auto same = [&](const SecondKind& k) {
        return k.albedo == albedo && k.f0 == f0 && k.index == index &&
               stack.layers[k.layer].medium == layer.medium;
      };
      const auto it = std::find_if(kinds.begin(), kinds.end(), same);
      kind = static_cast<int>(it - kinds.begin());
      if (it == kinds.end()) kinds.push_back({l, albedo, f0, index});
    }
    of_layer.push_back(kind);
  }
}

SecondOrder::SecondOrder(const Stack& stack, int channel)
    : stack_(stack), kinds_(std::make_shared<const SecondKinds>(stack, channel)) {}

bool SecondOrder::is_empty() const { return kinds_->kinds.empty(); }

bool SecondOrder::is_dark(double mu_i, double mu_o) const {
  return is_empty() || (!stack_.is_open_below() && (mu_i < 0 || mu_o < 0));
}

std::unique_ptr<SecondOrderPass> SecondOrder::pass(Direction wi, Direction wo) const {
  return stack_.has_interfaces() ? bounded_second_order(stack_, *kinds_, wi, wo)
                                 : open_second_order(stack_, *kinds_, wi, wo);
}

SecondOrder::Value SecondOrder::operator()(Direction wi, Direction wo, double tolerance) const {
  if (is_dark(wi.z, wo.z)) return {};
  const auto pair = pass(wi, wo);
  Value result;
  integrate_between(
      pair->breaks, 0.0, [&](const BetweenCosine& between) { return pair->at(between); },
      [&](int level, double sum) {
        const double f = pair->common * sum;
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
  const auto pair = pass(direction_from_mu_phi(mu_i, 0), direction_from_mu_phi(mu_o, 0));
  double before = 0;  // change under the doubling before
  integrate_between(
      pair->breaks, ArrayXd(ArrayXd::Zero(count)),
      [&](const BetweenCosine& between) { return pair->modes_at(between, count); },
      [&](int level, const ArrayXd& sum) {
        const ArrayXd f = 2 * kPi * pair->common * sum;
        const ArrayXd difference = (f - result.f).abs();
        const double change = 2 * difference.sum() - difference[0];
        result.f = f;
        result.error = before > 0 ? change * std::clamp(change / before, pair->fall, 1.0) : change;
        before = change;
        return level > 2 && result.error < tolerance;
      });
  return result;
}

}  // namespace lamella
