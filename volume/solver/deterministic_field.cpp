#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "volume/adding/make_stack_solver.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/deterministic_channel.h"
#include "volume/solver/mode_tail.h"
#include "volume/solver/second_split.h"

namespace lamella {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// What sums of modes alone owe.
double whole(const ModeTail& tail) { return std::abs(tail.sum(0)) + tail.error; }

void check_sides(const Stack& stack, std::span<const double> mu_i) {
  if (!stack.is_open_below())
    for (const double mu : mu_i)
      if (mu < 0)
        throw std::invalid_argument("light from below on a half space or an opaque substrate");
}

// A direction with cosine mu and azimuth phi.
Direction at(double mu, double phi) {
  return with_grazing_limit(direction_from_mu_phi(std::clamp(mu, -1.0, 1.0), phi));
}

}  // namespace

double DeterministicField::mode(int channel, int order, int m, std::size_t i, std::size_t o) const {
  const Channel& c = *channels_[channel_of_[channel]];
  const Index row = static_cast<Index>(c.out.place[o]), column = static_cast<Index>(c.in.place[i]);
  const int part = c.part(i, o);
  const std::size_t solved = c.modes.size();
  if (static_cast<std::size_t>(m) >= solved)
    return order == 1 || order > 3 ? c.more_second[m - solved][part](row, column) : 0;
  const OrderModes& mode = c.modes[m];
  const auto second = [&] {
    const MatrixXd& rest = mode.second_rest[part];
    return mode.second[part](row, column) + (rest.size() > 0 ? rest(row, column) : 0);
  };
  const auto present = [&](const Parts& parts) {
    return parts[part].size() > 0 ? parts[part](row, column) : 0;
  };
  switch (order) {
    case 0:
      return present(mode.first);
    case 5:
      return present(mode.zero);
    case 1:
      return second();
    case 2:
      return mode.third[part](row, column);
    case 3:
      return mode.higher[part](row, column);
    default:
      return second() + mode.third[part](row, column) + mode.higher[part](row, column) +
             present(mode.first) + present(mode.zero);
  }
}

double DeterministicField::mean(int channel, std::size_t i, std::size_t o) const {
  const Channel& c = *channels_[channel_of_[channel]];
  return c.mean[c.part(i, o)](static_cast<Index>(c.out.place[o]),
                              static_cast<Index>(c.in.place[i]));
}

double DeterministicField::scale(int channel, std::size_t i, std::size_t o) const {
  const Channel& c = *channels_[channel_of_[channel]];
  return std::max(mean(channel, i, o), c.faint[c.part(i, o)]);
}

int DeterministicField::modes(int channel) const {
  const Channel& c = *channels_[channel_of_[channel]];
  return static_cast<int>(c.modes.size() + c.more_second.size());
}

DeterministicValue DeterministicField::multiple(std::size_t i, std::size_t o, double x) const {
  return evaluate(i, o, x, false);
}

DeterministicValue DeterministicField::multiple_refined(std::size_t i, std::size_t o,
                                                        double x) const {
  return evaluate(i, o, x, true);
}

DeterministicValue DeterministicField::evaluate(std::size_t i, std::size_t o, double x,
                                                bool may_integrate) const {
  struct Sums {
    OrderMap<double> order{};
    double zero = 0, error = 0;
    bool exact = false;
  };
  std::vector<Sums> sums(channels_.size());
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    const Channel& c = *channels_[k];
    const int part = c.part(i, o);
    const Index row = static_cast<Index>(c.out.place[o]),
                column = static_cast<Index>(c.in.place[i]);
    const std::size_t count = c.modes.size();
    const double step = 2 * std::cos(x);
    double before = step / 2, now = 1, second = 0, second_rest = 0, third = 0, higher = 0;
    double zero = 0, first = 0;
    for (std::size_t m = 0; m < count; ++m) {
      const OrderModes& mode = c.modes[m];
      const double weight = m == 0 ? 1 : 2 * now;
      const double s = mode.second[part](row, column), t = mode.third[part](row, column),
                   h = mode.higher[part](row, column);
      const double r = mode.second_rest[part].size() > 0 ? mode.second_rest[part](row, column) : 0;
      second += weight * s;
      second_rest += weight * r;
      third += weight * t;
      higher += weight * h;
      if (mode.first[part].size() > 0) first += weight * mode.first[part](row, column);
      if (mode.zero[part].size() > 0) zero += weight * mode.zero[part](row, column);
      const double next = step * now - before;
      before = now;
      now = next;
    }
    for (const Parts& more : c.more_second) {
      second += 2 * now * more[part](row, column);
      const double next = step * now - before;
      before = now;
      now = next;
    }
    Sums& sum = sums[k];
    const double scale = c.scale(part, row, column);
    const auto [second_tail, third_tail, other_tail] = c.tails(part, row, column);
    sum.error = error_ * scale + c.below_zero(part, row, column) + other_tail.error;
    const bool integrated = c.has_integrated_modes();
    const double left_out =
        integrated      ? c.second_error[part](row, column) + c.second_left[part](row, column)
        : may_integrate ? second_tail.error
                        : whole(second_tail);
    if (may_integrate) {
      third += third_tail.sum(x);
      sum.error += third_tail.error;
    } else {
      sum.error += whole(third_tail);
    }
    if (may_integrate && c.second &&
        (left_out > tolerance_ / 4 * scale || is_second_integrated(second_error_, tolerance_))) {
      const SecondOrder::Value direct =
          (*c.second)(at(mu_i_[i], 0), at(mu_o_[o], kPi - x), tolerance_ / 20 * scale);
      second = direct.f;
      sum.error += direct.error;
      sum.exact = true;
    } else {
      if (may_integrate && !integrated) second += second_tail.sum(x);
      sum.error += left_out + (c.second && !integrated ? second_error_ * scale : 0);
    }
    sum.order = {first, second + second_rest, third, higher, second + second_rest + third + higher};
    if (!is_first_closed_) {
      sum.order[Order::all] += first + zero;
      // Two facets in turn have peaks far above the mean, between the probes: a share of f itself.
      sum.error += error_ * std::max(0.0, std::abs(sum.order[Order::all]) - scale);
    }
    sum.zero = zero;
  }
  DeterministicValue value;
  for (int channel = 0; channel < 3; ++channel) {
    const Sums& sum = sums[channel_of_[channel]];
    for (int order = 0; order < kSolvedOrders; ++order)
      value.order[order][channel] = sum.order[order];
    value.zero[channel] = sum.zero;
    value.error[channel] = sum.error;
    value.exact_second |= sum.exact;
  }
  return value;
}

double DeterministicField::error_of_mean(int channel, std::size_t i, std::size_t o,
                                         double width) const {
  const Channel& c = *channels_[channel_of_[channel]];
  const int part = c.part(i, o);
  const Index row = static_cast<Index>(c.out.place[o]), column = static_cast<Index>(c.in.place[i]);
  const double scale = c.scale(part, row, column);
  const auto [second, third, others] = c.tails(part, row, column);
  const double solved = share_in_mean(static_cast<double>(c.modes.size()), width);
  double error =
      error_ * scale + c.below_zero(part, row, column) + solved * (whole(third) + others.error);
  if (c.has_integrated_modes())
    error +=
        c.second_error[part](row, column) +
        share_in_mean(c.second_count[part](row, column), width) * c.second_left[part](row, column);
  else
    error += solved * whole(second) + (c.second ? second_error_ * scale : 0);
  return error;
}

bool DeterministicSolution::integrates_second() const {
  return steep_ && is_second_integrated(accuracy_.second_error, tolerance_);
}

DeterministicField DeterministicSolution::field(std::span<const double> mu_i,
                                                std::span<const double> mu_o,
                                                bool second_integrated,
                                                const std::atomic<bool>* stop) const {
  check_sides(stack_, mu_i);
  DeterministicField field;
  field.channel_of_ = channel_of_;
  field.mu_i_.assign(mu_i.begin(), mu_i.end());
  field.mu_o_.assign(mu_o.begin(), mu_o.end());
  field.tolerance_ = tolerance_;
  field.error_ = std::max(accuracy_.node_error, accuracy_.energy_defect);
  field.second_error_ = accuracy_.second_error;
  field.is_first_closed_ = is_first_closed(stack_);
  const OuterIndices outer(stack_);
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    auto channel = std::make_shared<DeterministicField::Channel>(
        DeterministicField::Channel{{},
                                    {},
                                    faint_[k],
                                    Cosines(mu_i, outer),
                                    Cosines(mu_o, outer),
                                    {},
                                    {},
                                    std::nullopt,
                                    {},
                                    {},
                                    {},
                                    {}});
    for (const double m : mu_i) channel->sign_in.push_back(m < 0 ? -1 : 1);
    for (const double m : mu_o) channel->sign_out.push_back(m < 0 ? -1 : 1);
    const std::unique_ptr<StackSolver> solver = make_stack_solver(
        stack_, channels_[k], accuracy_.nodes, channel->out.asked, channel->in.asked, 3, isa_);
    std::optional<SecondSplit> split;
    if (steep_) {
      channel->second.emplace(stack_, channels_[k]);
      split.emplace(stack_, channels_[k], accuracy_.nodes, channel->out.asked, channel->in.asked,
                    isa_);
    }
    solver->prepare(modes_[k]);
    channel->modes.resize(modes_[k]);
    const auto solve = [&](int m) {
      const AskedMode mode = solver->asked_series(m);
      OrderModes& orders = channel->modes[m];
      for (int part = 0; part < 4; ++part) {
        const auto s = [&](int series) -> const MatrixXd& { return mode.series[series][part]; };
        orders.second[part] = s(2);
        orders.third[part] = s(3);
        orders.higher[part] = s(0) - s(1) - s(2) - s(3);
        if (!field.is_first_closed_) {
          orders.first[part] = s(1);
          if (s(kOrderZero).size() > 0) {
            orders.zero[part] = s(kOrderZero);
            orders.higher[part] -= s(kOrderZero);
          }
        }
        if (m == 0) channel->mean[part] = s(0);
      }
    };
    // One by one: some modes take far longer than others.
    oneapi::tbb::parallel_for(0, modes_[k], solve, oneapi::tbb::simple_partitioner());
    if (split)
      for (int m = 0; m < modes_[k]; ++m)
        if (std::optional<Parts> counted = split->counted(m))
          for (int part = 0; part < 4; ++part) {
            OrderModes& orders = channel->modes[m];
            orders.second_rest[part] = orders.second[part] - (*counted)[part];
            orders.second[part] = std::move((*counted)[part]);
          }
    if (second_integrated && integrates_second()) channel->integrate_second(tolerance_ / 5, stop);
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
  DeterministicValue value = field(mu_i, mu_o).multiple_refined(0, 0, kPi - phi);
  const ClosedOrders closed = closed_orders(stack_, wi, wo);
  value.order[0] += closed.one;
  value.zero += closed.zero;
  value.order[Order::all] += closed.all();
  return value;
}

std::vector<DeterministicEnergies> DeterministicSolution::energies(
    std::span<const double> mu_i) const {
  check_sides(stack_, mu_i);
  std::vector<DeterministicEnergies> result(mu_i.size());
  const Cosines in(mu_i, OuterIndices(stack_));
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    const std::unique_ptr<StackSolver> solver =
        make_stack_solver(stack_, channels_[k], accuracy_.nodes, {}, in.asked, 3, isa_);
    solver->prepare(1);
    const AskedMode mode = solver->asked_mode(0);
    for (std::size_t i = 0; i < mu_i.size(); ++i) {
      const AskedEnergies& side = mode.energies[mu_i[i] < 0];
      const Index place = static_cast<Index>(in.place[i]);
      const auto beam = [&](int series) {
        return side.mirrored[series].size() > 0 ? side.mirrored[series][place] : 0;
      };
      const auto split = [&](const auto& diffuse, bool with_beams, double& zero) {
        const auto energy = [&](int series) {
          return diffuse[series][place] + (with_beams ? beam(series) : 0);
        };
        std::array<double, kSolvedOrders> e{energy(1), energy(2), energy(3), 0, energy(0)};
        zero = energy(kOrderZero);
        e[3] = e[4] - e[0] - e[1] - e[2] - zero;
        return e;
      };
      double zero_reflected = 0, zero_transmitted = 0;
      const auto reflected = split(side.reflected, true, zero_reflected);
      const auto transmitted = split(side.transmitted, false, zero_transmitted);
      for (int channel = 0; channel < 3; ++channel) {
        if (channel_of_[channel] != static_cast<int>(k)) continue;
        DeterministicEnergies& e = result[i];
        for (int order = 0; order < kSolvedOrders; ++order) {
          e.reflected[order][channel] = reflected[order];
          if (stack_.is_open_below()) e.transmitted[order][channel] = transmitted[order];
          if (stack_.is_half_space()) e.escaped[order][channel] = transmitted[order];
        }
        e.zero_reflected[channel] = zero_reflected;
        if (stack_.is_open_below()) e.zero_transmitted[channel] = zero_transmitted;
        if (stack_.is_half_space()) e.zero_escaped[channel] = zero_transmitted;
        for (int order = 1; order < kSeries; ++order)
          e.specular_of[order - 1][channel] = beam(order);
        e.specular_of[Order::all][channel] = beam(0);
        e.specular_of[Order::zero][channel] = beam(kOrderZero);
        e.specular_of[3][channel] = beam(0) - beam(1) - beam(2) - beam(3) - beam(kOrderZero);
        e.uncollided[channel] = side.direct[place];
        e.absorbed[channel] = side.absorbed[place];
        e.lost[channel] = side.lost[place];
      }
    }
  }
  return result;
}

}  // namespace lamella
