#include "volume/deterministic.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "phase/single_scattering.h"
#include "volume/stack_modes.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Apart from each other: where w_o = -w_i mirror flakes have a singularity, and each pair's own
// tail of modes enters its error.
const std::vector<double> kProbesIn{0.01, 0.07, 0.3, 0.6, 0.9};
const std::vector<double> kProbesOut{0.02, 0.13, 0.45, 0.75, 1.0};

// The block of a series between directions that were asked for.
MatrixXd asked(const MatrixXd& m, Index nodes) {
  return m.bottomRightCorner(m.rows() - nodes, m.cols() - nodes);
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

int part_of(double mu_i, double mu_o) {
  return mu_i > 0 ? (mu_o > 0 ? kAboveToUp : kAboveToDown) : (mu_o > 0 ? kBelowToUp : kBelowToDown);
}

// What a series adds beyond its last term, from the largest of its last four terms and of the four
// before: geometric or algebraic decay.
double series_tail(double older, double newer) {
  if (newer == 0) return 0;
  const double q = std::min(0.98, std::pow(newer / std::max(older, newer), 0.25));
  return newer * q / (1 - q);
}

// Whether an outgoing probe is within reach of the forward singularity of an incoming one.
bool is_near_forward(Index o, Index i) {
  return std::abs(std::acos(kProbesOut[o]) - std::acos(kProbesIn[i])) < 0.12;
}

// What the probes see at one number of nodes: modes of the orders 2 and up, and the mean of all.
struct ProbeModes {
  std::vector<Parts> modes;
  Parts mean;
  double tail = 0;  // of the series of modes, relative to the mean
};

// Largest ratio of an entry of a to that of b, where b is a number above rounding; near-forward
// pairs apart in transmission.
double largest_ratio(const MatrixXd& a, const MatrixXd& b, int part) {
  const bool through = part == kAboveToDown || part == kBelowToUp;
  double largest = 0;
  for (Index i = 0; i < a.cols(); ++i)
    for (Index o = 0; o < a.rows(); ++o)
      if (b(o, i) > 1e-200 && !(through && is_near_forward(o, i)))
        largest = std::max(largest, std::abs(a(o, i)) / b(o, i));
  return largest;
}

ProbeModes solve_probes(StackModes& stack, int parts, double tolerance, int max_modes) {
  ProbeModes result;
  const Index nodes = stack.sets().nodes();
  int quiet = 0;
  std::vector<double> sizes;
  // Modes that vary faster than the nodes can follow would be noise.
  const int limit = std::min(max_modes, 4 * static_cast<int>(nodes) + 24);
  for (int m = 0; m < limit; ++m) {
    const LayerOperator op = stack.mode(m);
    Parts rest;
    double size = 0;
    for (int part = 0; part < parts; ++part) {
      const Series& series = part_of(op, part);
      rest[part] = asked(series[0] - series[1], nodes);
      if (m == 0) result.mean[part] = asked(series[0], nodes);
      size = std::max(size, 2 * largest_ratio(rest[part], result.mean[part], part));
    }
    result.modes.push_back(std::move(rest));
    sizes.push_back(size);
    // Odd and even modes may differ: several small ones in a row end the series.
    quiet = size < tolerance ? quiet + 1 : 0;
    if (quiet == 4) break;
  }
  sizes.resize(std::max<std::size_t>(sizes.size(), 8), 0);
  const auto largest = [&](std::ptrdiff_t from) {
    return *std::max_element(sizes.end() - from, sizes.end() - from + 4);
  };
  result.tail = series_tail(largest(8), largest(4));
  return result;
}

double change_between(const ProbeModes& coarse, const ProbeModes& fine, int parts) {
  double largest = 0;
  for (int part = 0; part < parts; ++part) {
    MatrixXd sum = MatrixXd::Zero(fine.mean[part].rows(), fine.mean[part].cols());
    // Modes that only one of the two has belong to the tail.
    const std::size_t common = std::min(coarse.modes.size(), fine.modes.size());
    for (std::size_t m = 0; m < common; ++m)
      sum += (m == 0 ? 1 : 2) * (fine.modes[m][part] - coarse.modes[m][part]).cwiseAbs();
    largest = std::max(largest, largest_ratio(sum, fine.mean[part], part));
  }
  return largest;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The distinct |mu| of a list, and the place of each entry among them.
struct Cosines {
  std::vector<double> distinct;
  std::vector<std::size_t> place;

  explicit Cosines(std::span<const double> mu) {
    for (const double m : mu) distinct.push_back(std::max(std::abs(m), kGrazingLimit));
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    for (const double m : mu)
      place.push_back(
          std::lower_bound(distinct.begin(), distinct.end(), std::max(std::abs(m), kGrazingLimit)) -
          distinct.begin());
  }
};

bool channels_equal(const Stack& stack, int a, int b) {
  return std::all_of(
             stack.layers.begin(), stack.layers.end(),
             [&](const Layer& l) { return l.albedo[a] == l.albedo[b] && l.f0[a] == l.f0[b]; }) &&
         (!stack.substrate || stack.substrate->albedo[a] == stack.substrate->albedo[b]);
}

}  // namespace

struct DeterministicField::Channel {
  // What the modes beyond the last would add to one pair, from the decay of the last eight:
  // geometric or algebraic.
  [[nodiscard]] double tail(int which, Index o, Index i) const {
    const std::size_t count = modes.size();
    if (count < 8) return 0;
    double window[2] = {0, 0};  // newer, older
    for (std::size_t m = count - 8; m < count; ++m) {
      double all = 0;
      for (const Parts& order : modes[m]) all += order[which](o, i);
      double& largest = window[m < count - 4 ? 1 : 0];
      largest = std::max(largest, std::abs(all));
    }
    return 2 * series_tail(window[1], window[0]);
  }

  std::vector<std::array<Parts, 3>> modes;  // [mode][order 2, 3, 4+][part]
  Parts mean;                               // of all orders
  Cosines in, out;
  std::vector<int> sign_in, sign_out;

  [[nodiscard]] int part(std::size_t i, std::size_t o) const {
    return part_of(sign_in[i], sign_out[o]);
  }
};

double DeterministicField::mode(int channel, int order, int m, std::size_t i, std::size_t o) const {
  const Channel& c = *channels_[channel_of_[channel]];
  const auto at = [&](int k) {
    return c.modes[m][k][c.part(i, o)](static_cast<Index>(c.out.place[o]),
                                       static_cast<Index>(c.in.place[i]));
  };
  if (order == 0) return 0;
  return order == 4 ? at(0) + at(1) + at(2) : at(order - 1);
}

double DeterministicField::mean(int channel, std::size_t i, std::size_t o) const {
  const Channel& c = *channels_[channel_of_[channel]];
  return c.mean[c.part(i, o)](static_cast<Index>(c.out.place[o]),
                              static_cast<Index>(c.in.place[i]));
}

int DeterministicField::modes(int channel) const {
  return static_cast<int>(channels_[channel_of_[channel]]->modes.size());
}

DeterministicValue DeterministicField::multiple(std::size_t i, std::size_t o, double x) const {
  DeterministicValue value;
  std::vector<std::array<double, kSolvedOrders>> sums(channels_.size());
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    const Channel& c = *channels_[k];
    const int part = c.part(i, o);
    const Index row = static_cast<Index>(c.out.place[o]),
                column = static_cast<Index>(c.in.place[i]);
    const double step = 2 * std::cos(x);
    double before = step / 2, now = 1;
    auto& sum = sums[k];
    for (std::size_t m = 0; m < c.modes.size(); ++m) {
      const double weight = m == 0 ? 1 : 2 * now;
      for (int order = 0; order < 3; ++order)
        sum[order + 1] += weight * c.modes[m][order][part](row, column);
      const double next = step * now - before;
      before = now;
      now = next;
    }
    sum[4] = sum[1] + sum[2] + sum[3];
  }
  for (int channel = 0; channel < 3; ++channel) {
    for (int order = 1; order < kSolvedOrders; ++order)
      value.order[order][channel] = sums[channel_of_[channel]][order];
    const Channel& c = *channels_[channel_of_[channel]];
    value.error[channel] =
        error_ * mean(channel, i, o) +
        c.tail(c.part(i, o), static_cast<Index>(c.out.place[o]), static_cast<Index>(c.in.place[i]));
  }
  return value;
}

std::optional<std::string> why_not_deterministic(const Stack& stack) {
  if (!stack.is_symmetric_about_z()) return "the stack is not symmetric about the normal";
  for (const Layer& layer : stack.layers)
    if (is_delta(layer.medium)) return "mirror flakes at roughness 0 scatter into a delta";
  return std::nullopt;
}

DeterministicSolution solve_deterministic(const Stack& stack, const DeterministicOptions& options) {
  if (const auto reason = why_not_deterministic(stack)) throw std::invalid_argument(*reason);
  const auto start = std::chrono::steady_clock::now();
  DeterministicSolution solution;
  solution.stack_ = stack;
  for (int c = 0; c < 3; ++c) {
    int same = 0;
    while (!channels_equal(stack, same, c)) ++same;
    if (same == c) solution.channels_.push_back(c);
    solution.channel_of_[c] =
        static_cast<int>(std::find(solution.channels_.begin(), solution.channels_.end(), same) -
                         solution.channels_.begin());
  }
  const int parts = stack.is_open_below() ? 4 : 1;
  const std::size_t channels = solution.channels_.size();
  std::vector<ProbeModes> coarse(channels);
  DeterministicAccuracy& accuracy = solution.accuracy_;
  double tail = 1;
  for (int nodes = options.min_nodes, step = 0;; ++step) {
    const double begun = seconds_since(start), tail_before = tail;
    double change = step == 0 ? 1 : 0;
    tail = 0;
    accuracy.nodes = nodes;
    accuracy.modes = 0;
    for (std::size_t k = 0; k < channels; ++k) {
      StackModes modes(stack, solution.channels_[k], DirectionSets(nodes, kProbesOut, kProbesIn),
                       1);
      ProbeModes fine = solve_probes(modes, parts, options.tolerance / 10, options.max_modes);
      if (step > 0) change = std::max(change, change_between(coarse[k], fine, parts));
      tail = std::max(tail, fine.tail);
      solution.modes_[k] = static_cast<int>(fine.modes.size());
      accuracy.modes = std::max(accuracy.modes, solution.modes_[k]);
      accuracy.bytes = std::max(accuracy.bytes, modes.bytes());
      coarse[k] = std::move(fine);
    }
    accuracy.node_error = change;
    accuracy.error = change + tail;
    accuracy.reached = step > 0 && accuracy.error <= options.tolerance;
    const double now = seconds_since(start);
    const int next = nodes % 3 == 0 ? nodes / 3 * 4 : nodes * 3 / 2;
    // A tail of modes that falls slowly is not worth a finer solution; nor is one that takes longer
    // than what is left (cost grows at most like the fourth power of the nodes).
    const bool limited = change <= options.tolerance && tail > tail_before / 4;
    if (accuracy.reached || limited || next > options.max_nodes ||
        now + 5 * (now - begun) > options.max_seconds)
      break;
    nodes = next;
  }
  accuracy.seconds = seconds_since(start);
  return solution;
}

namespace {

void check_sides(const Stack& stack, std::span<const double> mu_i) {
  if (!stack.is_open_below())
    for (const double mu : mu_i)
      if (mu < 0)
        throw std::invalid_argument("light from below on a half space or an opaque substrate");
}

}  // namespace

DeterministicField DeterministicSolution::field(std::span<const double> mu_i,
                                                std::span<const double> mu_o) const {
  check_sides(stack_, mu_i);
  DeterministicField field;
  field.channel_of_ = channel_of_;
  field.error_ = accuracy_.node_error;
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    auto channel = std::make_shared<DeterministicField::Channel>(
        DeterministicField::Channel{{}, {}, Cosines(mu_i), Cosines(mu_o), {}, {}});
    for (const double m : mu_i) channel->sign_in.push_back(m < 0 ? -1 : 1);
    for (const double m : mu_o) channel->sign_out.push_back(m < 0 ? -1 : 1);
    StackModes modes(stack_, channels_[k],
                     DirectionSets(accuracy_.nodes, channel->out.distinct, channel->in.distinct),
                     3);
    for (int m = 0; m < modes_[k]; ++m) {
      const LayerOperator op = modes.mode(m);
      std::array<Parts, 3> orders;
      for (int part = 0; part < 4; ++part) {
        const Series& s = part_of(op, part);
        orders[0][part] = asked(s[2], modes.sets().nodes());
        orders[1][part] = asked(s[3], modes.sets().nodes());
        orders[2][part] = asked(s[0] - s[1] - s[2] - s[3], modes.sets().nodes());
        if (m == 0) channel->mean[part] = asked(s[0], modes.sets().nodes());
      }
      channel->modes.push_back(std::move(orders));
    }
    field.channels_.push_back(std::move(channel));
  }
  return field;
}

DeterministicValue DeterministicSolution::f(Direction wi, Direction wo) const {
  if (wi.z == 0 && wo.z == 0)
    throw std::invalid_argument("both directions graze: f has no limit there");
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  const double mu_i[] = {wi.z}, mu_o[] = {wo.z};
  const double phi = std::atan2(wi.x * wo.y - wi.y * wo.x, wi.x * wo.x + wi.y * wo.y);
  DeterministicValue value = field(mu_i, mu_o).multiple(0, 0, kPi - phi);
  const SingleScattering single = single_scattering(stack_, wi, wo);
  value.order[0] = single.layers + single.substrate;
  value.order[4] += value.order[0];
  return value;
}

std::vector<DeterministicEnergies> DeterministicSolution::energies(
    std::span<const double> mu_i) const {
  check_sides(stack_, mu_i);
  std::vector<DeterministicEnergies> result(mu_i.size());
  const Cosines in(mu_i);
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    StackModes modes(stack_, channels_[k], DirectionSets(accuracy_.nodes, {}, in.distinct), 3);
    const LayerOperator op = modes.mode(0);
    const Index nodes = modes.sets().nodes();
    const Eigen::VectorXd& flux = modes.sets().flux;
    for (std::size_t i = 0; i < mu_i.size(); ++i) {
      const OperatorSide& side = mu_i[i] < 0 ? op.below : op.above;
      const Index column = nodes + static_cast<Index>(in.place[i]);
      const auto energy = [&](const Series& series, int order) {
        return flux.dot(series[order].col(column).head(nodes));
      };
      const auto split = [&](const Series& series) {
        std::array<double, kSolvedOrders> e{energy(series, 1), energy(series, 2), energy(series, 3),
                                            0, energy(series, 0)};
        e[3] = e[4] - e[0] - e[1] - e[2];
        return e;
      };
      const auto reflected = split(side.r), transmitted = split(side.t);
      for (int channel = 0; channel < 3; ++channel) {
        if (channel_of_[channel] != static_cast<int>(k)) continue;
        DeterministicEnergies& e = result[i];
        for (int order = 0; order < kSolvedOrders; ++order) {
          e.reflected[order][channel] = reflected[order];
          if (stack_.is_open_below()) e.transmitted[order][channel] = transmitted[order];
          if (stack_.is_half_space()) e.escaped[order][channel] = transmitted[order];
        }
        e.uncollided[channel] = side.direct_in[column];
        e.absorbed[channel] = side.absorbed[column];
      }
    }
  }
  return result;
}

}  // namespace lamella
