#include "volume/solver/deterministic_channel.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace lamella {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// Most modes of order 2 integrated per pair, and most in all once the fitted tail is appended: near
// straight transmission they fall algebraically.
constexpr int kMostSecondModes = 400, kMostContinuedModes = 2400;

// Continues modes by their fit until those beyond leave less than `allowed`, or are too many;
// returns what they leave.
double continue_modes(Eigen::ArrayXd& modes, const ModeTail& tail, double allowed) {
  if (tail.amplitude == 0) return 0;
  double left = std::abs(tail.sum(0));
  std::vector<double> more;
  for (int m = tail.first; m < kMostContinuedModes && left > allowed; ++m) {
    more.push_back(tail.at(m));
    left = std::max(0.0, left - 2 * std::abs(more.back()));
  }
  const Index integrated = modes.size();
  modes.conservativeResize(integrated + static_cast<Index>(more.size()));
  std::copy(more.begin(), more.end(), modes.data() + integrated);
  return left;
}

}  // namespace

OuterIndices::OuterIndices(const Stack& stack) : below(stack.index_of(stack.layers.size())) {}

Cosines::Cosines(std::span<const double> mu, const OuterIndices& indices) {
  const auto key = [&](double m) {
    return std::pair(m < 0 ? indices.below : indices.above, std::max(std::abs(m), kGrazingLimit));
  };
  std::vector<std::pair<double, double>> keys;
  for (const double m : mu) keys.push_back(key(m));
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  for (const auto& [index, cosine] : keys) {
    distinct.push_back(cosine);
    asked.push_back({cosine, index});
  }
  for (const double m : mu)
    place.push_back(std::lower_bound(keys.begin(), keys.end(), key(m)) - keys.begin());
}

int part_of(double mu_i, double mu_o) {
  return mu_i > 0 ? (mu_o > 0 ? kAboveToUp : kAboveToDown) : (mu_o > 0 ? kBelowToUp : kBelowToDown);
}

const Series& part_of(const LayerOperator& op, int part) {
  switch (part) {
    case kAboveToUp:
      return op.above.r;
    case kAboveToDown:
      return op.above.t;
    case kBelowToDown:
      return op.below.r;
    default:
      return op.below.t;
  }
}

bool is_steep(const Medium& medium) {
  constexpr double kPeaked = 0.85;
  const MediumTraits t = traits(medium);
  return t.shape == PhaseShape::jump || std::abs(t.mean_cosine) > kPeaked;
}

int DeterministicField::Channel::part(std::size_t i, std::size_t o) const {
  return part_of(sign_in[i], sign_out[o]);
}

DeterministicField::Channel::Tails DeterministicField::Channel::tails(int part, Index row,
                                                                      Index column) const {
  const std::size_t count = modes.size();
  std::vector<double> seconds(count), thirds(count), others(count);
  for (std::size_t m = 0; m < count; ++m) {
    const OrderModes& mode = modes[m];
    const MatrixXd& rest = mode.second_rest[part];
    seconds[m] = mode.second[part](row, column);
    thirds[m] = mode.third[part](row, column);
    others[m] = mode.higher[part](row, column) + (rest.size() > 0 ? rest(row, column) : 0);
    for (const Parts* more : {&mode.zero, &mode.first})
      if ((*more)[part].size() > 0) others[m] += (*more)[part](row, column);
  }
  return {fit_mode_tail(seconds), fit_mode_tail(thirds), fit_mode_tail(others)};
}

void DeterministicField::Channel::integrate_second(double tolerance,
                                                   const std::atomic<bool>* stop) {
  const Index rows = static_cast<Index>(out.distinct.size()),
              columns = static_cast<Index>(in.distinct.size());
  Parts counts, errors, left;
  for (Parts* parts : {&counts, &errors, &left}) parts->fill(MatrixXd::Zero(rows, columns));
  struct CosinePair {
    Index row, column;
    double mu_i, mu_o;
    auto operator<=>(const CosinePair&) const = default;  // NOLINT(modernize-use-nullptr): its 0
  };
  std::vector<CosinePair> pairs;
  for (std::size_t i = 0; i < in.place.size(); ++i)
    for (std::size_t o = 0; o < out.place.size(); ++o)
      pairs.push_back({static_cast<Index>(out.place[o]), static_cast<Index>(in.place[i]),
                       sign_in[i] * in.distinct[in.place[i]],
                       sign_out[o] * out.distinct[out.place[o]]});
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<Eigen::ArrayXd> found(pairs.size());
  oneapi::tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t k) {
    if (stop && *stop) return;
    const auto& [row, column, mu_i, mu_o] = pairs[k];
    const int part = part_of(mu_i, mu_o);
    const double allowed = tolerance * std::max(mean[part](row, column), faint[part]);
    for (int count = static_cast<int>(modes.size());; count += count / 2) {
      SecondOrder::Modes integrated = second->modes(mu_i, mu_o, count, allowed / 4);
      const ModeTail tail = fit_mode_tail({integrated.f.data(), static_cast<std::size_t>(count)});
      const double left_out = tail.error + continue_modes(integrated.f, tail, allowed / 4);
      found[k] = std::move(integrated.f);
      counts[part](row, column) = count;
      errors[part](row, column) = integrated.error;
      left[part](row, column) = left_out;
      if (left_out <= allowed || count >= kMostSecondModes) break;
    }
  });
  // Some pairs without it have no modes to put in their place: all keep the solver's.
  if (stop && *stop) return;
  second_count = std::move(counts);
  second_error = std::move(errors);
  second_left = std::move(left);
  const std::size_t solved = modes.size();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto& [row, column, mu_i, mu_o] = pairs[k];
    const int part = part_of(mu_i, mu_o);
    for (std::size_t m = 0; m < static_cast<std::size_t>(found[k].size()); ++m) {
      if (m >= solved + more_second.size()) {
        more_second.emplace_back();
        more_second.back().fill(MatrixXd::Zero(rows, columns));
      }
      (m < solved ? modes[m].second : more_second[m - solved])[part](row, column) =
          found[k][static_cast<Index>(m)];
    }
  }
}

}  // namespace lamella
