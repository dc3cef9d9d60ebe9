#include "compare/truth/lobe_table.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "analytic/model/model.h"
#include "compare/request/errors.h"
#include "compare/request/first_look.h"
#include "compare/truth/estimator_choice.h"
#include "compare/truth/lobe_cells.h"
#include "phase/surface/conductor.h"
#include "volume/harmonics/harmonic_scope.h"
#include "volume/solver/answer_check.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

using Grid = HalfVectorGrid;

// Of the solver: what it aims for at its best, and what is still far better than walks are; both
// relative to the mean over the azimuth.
constexpr double kTolerance = 1e-4, kStillUseful = 5e-3;
// What `auto` lets the solver spend. Nodes and modes end it, not the clock: equal runs are equal.
constexpr int kMostNodes = 64, kMostModes = 96;
constexpr double kMostSeconds = 30;
// Of walks whose number is not asked for.
constexpr double kWalkSeconds = 60;
// Incoming cosines between which solved modes are interpolated: less than a degree apart.
constexpr int kSolvedCosines = 120;

bool is_narrow(const Facets& f) {
  return f.shape != FacetShape::smooth && std::max(f.alpha_x, f.alpha_y) < kLeastLobe;
}

const Conductor* conductor_of(const Stack& stack) {
  return stack.substrate ? dynamic_cast<const Conductor*>(stack.substrate->law.get()) : nullptr;
}

bool has_narrow_lobes(const Stack& stack) {
  const Conductor* metal = conductor_of(stack);
  return (metal && is_narrow(metal->setting().facets)) ||
         std::any_of(stack.layers.begin(), stack.layers.end(), [](const Layer& layer) {
           return layer.interface && is_narrow(layer.interface->facets);
         });
}

bool has_delta_flakes(const Stack& stack) {
  return std::any_of(stack.layers.begin(), stack.layers.end(),
                     [](const Layer& layer) { return !layer.interface && is_delta(layer.medium); });
}

bool has_reciprocal_substrate(const Stack& stack) {
  if (!stack.substrate || stack.substrate->model.empty()) return true;
  const ModelInfo* form = find_model(stack.substrate->model);
  return !form || form->reciprocal;
}

// The error of an energy that is not at hand.
constexpr double kUnknown = std::numeric_limits<double>::infinity();

// Scales stand at this many places for every step between two nodes in mu_o.
constexpr std::size_t kScalesPerNode = 8;

// A place among equally spaced values, by the cubic through the four nearest.
double interpolated(const std::vector<double>& v, double place) {
  const auto node = static_cast<std::size_t>(place);
  const std::size_t from = std::min(node > 0 ? node - 1 : 0, v.size() - 4);
  const double x = place - static_cast<double>(from);
  return (-v[from] * (x - 1) * (x - 2) * (x - 3) + 3 * v[from + 1] * x * (x - 2) * (x - 3) -
          3 * v[from + 2] * x * (x - 1) * (x - 3) + v[from + 3] * x * (x - 1) * (x - 2)) /
         6;
}

}  // namespace

Stack LobeTable::drawn_stack(Stack stack) {
  for (Layer& layer : stack.layers)
    if (layer.interface && is_narrow(layer.interface->facets)) {
      layer.interface->facets = {.shape = FacetShape::smooth};
      layer.interface->multiple = false;
    }
  if (const Conductor* metal = conductor_of(stack); metal && is_narrow(metal->setting().facets)) {
    Conductor::Setting setting = metal->setting();
    setting.facets = {.shape = FacetShape::smooth};
    setting.multiple = false;
    stack.substrate->law = std::make_shared<Conductor>(setting);
  }
  return stack;
}

Direction LobeTable::outgoing(const Sector& sector, int out) {
  return direction_from_mu_phi(Grid::node_mu(out), sector.azimuth);
}

Direction LobeTable::incoming(const Sector& sector, int out, int alpha, int beta, int side) {
  Direction w = Grid::node_wi(Grid::node_mu(out), alpha, beta);
  if (side == 1) w.y = -w.y;
  if (sector.azimuth == 0) return w;
  const double c = std::cos(sector.azimuth), s = std::sin(sector.azimuth);
  return {c * w.x - s * w.y, s * w.x + c * w.y, w.z};
}

// What is not closed of one w_o, scaled to its energy.
std::function<Rgb(Direction)> LobeTable::rest_towards(const Sector& sector, Direction wo) const {
  const double place = kScalesPerNode * Grid::place_of_mu(wo.z);
  const auto k = std::min(static_cast<std::size_t>(place), sector.scales.size() - 2);
  const double x = place - static_cast<double>(k);
  const Rgb scale = (1 - x) * sector.scales[k] + x * sector.scales[k + 1];
  if (!has_azimuth())
    return [scale, rest = sector.rest.towards(wo)](Direction wi) { return scale * rest(wi); };
  // Straight on, the plane is that of the sector.
  const bool is_vertical = wo.x == 0 && wo.y == 0;
  const double px = is_vertical ? std::cos(sector.azimuth) : wo.x,
               py = is_vertical ? std::sin(sector.azimuth) : wo.y;
  return [scale, px, py, left = sector.rest.towards(wo), right = sector.right.towards(wo)](
             Direction wi) { return scale * (px * wi.y - py * wi.x >= 0 ? left : right)(wi); };
}

// Away from the limit: where both directions graze, single scattering has none.
std::function<Rgb(Direction)> LobeTable::towards(Direction wo) const {
  if (!shares_.empty()) {
    std::vector<std::pair<double, std::function<Rgb(Direction)>>> parts;
    for (const Share& s : shares_) parts.emplace_back(s.share, s.table->towards(wo));
    return [parts = std::move(parts)](Direction wi) {
      Rgb sum(0);
      for (const auto& [share, f] : parts) sum += share * f(wi);
      return sum;
    };
  }
  return [this, o = raised_to(wo, Grid::kLeastMu), rest = rest_towards(wo)](Direction wi) {
    return closed(raised_to(wi, Grid::kLeastMu), o) + rest(wi);
  };
}

std::function<Rgb(Direction)> LobeTable::rest_towards(Direction wo) const {
  const Direction o = raised_to(wo, Grid::kLeastMu);
  if (!has_azimuth())
    return [rest = rest_towards(tables_.front(), o)](Direction wi) {
      return rest(raised_to(wi, Grid::kLeastMu));
    };
  const double turn = (azimuth(o) - symmetry_.azimuth) / (2 * kPi),
               place = (turn - std::floor(turn)) * kSectors;
  const int from = std::min(static_cast<int>(place), kSectors - 1);
  const double x = place - from;
  return [x, first = rest_towards(tables_[from], o),
          second = rest_towards(tables_[(from + 1) % kSectors], o)](Direction wi) {
    const Direction i = raised_to(wi, Grid::kLeastMu);
    return (1 - x) * first(i) + x * second(i);
  };
}

Rgb LobeTable::closed_of(const Stack& drawn, Direction wi, Direction wo) const {
  switch (closed_) {
    case Closed::order_one:
      return closed_orders(drawn, wi, wo).one;
    case Closed::zero:
      return closed_orders(drawn, wi, wo).zero;
    case Closed::nothing:
      break;
  }
  return {};
}

LobeTable LobeTable::mean(std::vector<Share> shares, std::string source) {
  LobeTable table;
  table.shares_ = std::move(shares);
  table.source_ = std::move(source);
  return table;
}

bool LobeTable::has_specular() const {
  return stack_.has_boundaries() || std::any_of(shares_.begin(), shares_.end(), [](const Share& s) {
           return s.table->has_specular();
         });
}

bool LobeTable::has_azimuth() const {
  return tables_.size() > 1 || std::any_of(shares_.begin(), shares_.end(),
                                           [](const Share& s) { return s.table->has_azimuth(); });
}

Rgb LobeTable::specular(Direction wo) const {
  if (!shares_.empty()) {
    Rgb sum(0);
    for (const Share& s : shares_) sum += s.share * s.table->specular(wo);
    return sum;
  }
  return mirrored_share(stack_, raised_to(wo, Grid::kLeastMu));
}

std::optional<std::string> LobeTable::solve(const TruthRequest& request, bool must,
                                            const StopFlag* stop, const SolverReport& report) {
  const Stack& stack = stack_;
  DeterministicOptions options;
  options.isa = request.isa;
  options.tolerance = std::max(kTolerance, request.tolerance);
  options.stop = stop;
  options.report = report;
  if (!must) {
    options.max_nodes = kMostNodes;
    options.max_modes = kMostModes;
    options.max_seconds = kMostSeconds;
  }
  const DeterministicSolution solution = solve_deterministic(stack, options);
  if (auto reason = why_no_answer(solution.accuracy())) return reason;
  const double reached = solution.accuracy().error;
  if (!must && !(reached <= kStillUseful)) return fmt::format("its error is {:.1e}", reached);
  const auto solved_mu = [](int k) {
    return Grid::node_mu(k * (Grid::kOut - 1.0) / (kSolvedCosines - 1));
  };
  std::vector<double> in, out;
  for (int k = 0; k < kSolvedCosines; ++k) in.push_back(solved_mu(k));
  for (int k = 0; k < Grid::kOut; ++k) out.push_back(Grid::node_mu(k));
  const DeterministicField field = solution.field(in, out);
  tbb::parallel_for(0, Grid::kOut, [&](int o) {
    for (int a = 0; a < Grid::kAlpha; ++a)
      for (int b = 0; b < Grid::kBeta; ++b) {
        const Direction wi = Grid::node_wi(Grid::node_mu(o), a, b);
        const double place = Grid::place_of_mu(wi.z) * (kSolvedCosines - 1) / (Grid::kOut - 1.0);
        const int i = std::clamp(static_cast<int>(place), 0, kSolvedCosines - 2);
        const double x = place - i, angle = kPi - azimuth(wi);
        const auto value = [&](int node) {
          return field.multiple(static_cast<std::size_t>(node), static_cast<std::size_t>(o), angle)
              .order[Order::all];
        };
        tables_.front().rest.at(o, a, b) = (1 - x) * value(i) + x * value(i + 1);
      }
  });
  for (int o = 0; o < Grid::kOut; ++o)
    for (int a = 0; a < Grid::kAlpha; ++a)
      for (int b = 0; b < Grid::kBeta; ++b)
        if (const Rgb f = tables_.front().rest.at(o, a, b); !std::isfinite(f.r + f.g + f.b))
          return "its numbers are not finite";
  for (const DeterministicEnergies& e : solution.energies(out)) {
    RestEnergy energy;
    // Beams are in no table.
    energy.total = e.reflected[Order::all] - e.specular_of[Order::all];
    energy.direct = energy.total - (e.reflected[0] - e.specular_of[0]);
    for (int c = 0; c < 3; ++c) {
      energy.direct_error[c] = closed_ == Closed::order_one ? reached * energy.direct[c] : kUnknown;
      energy.total_error[c] = std::abs(e.sum()[c] - 1);
    }
    tables_.front().energies.push_back(energy);
  }
  source_ = fmt::format("adding and doubling, {} {:.1g}",
                        solution.accuracy().reached ? "tolerance" : "no further than",
                        solution.accuracy().reached ? options.tolerance : reached);
  return std::nullopt;
}

void LobeTable::walk(const TruthRequest& request, const StopFlag* stop) {
  const Plan plan = plan_of(request);
  const bool boundaries = stack_.has_boundaries();
  // Orders that the table holds.
  const int first = closed_ == Closed::order_one ? 1 : 0;
  const int end = closed_ == Closed::order_one || !boundaries ? kTallyOrders : kZeroSlot + 1;
  double mirrored_by_flakes = 0;
  FirstLook look(request, Grid::kOut * tables_.size(), kWalkSeconds, kPreviewWalks);
  std::uint64_t fewest = request.effort.walks;
  constexpr int kOneSide = Grid::kAlpha * Grid::kBeta;
  for (std::size_t k = 0; k < tables_.size(); ++k) {
    if (has_azimuth() && mirror_sector(static_cast<int>(k))) continue;
    Sector& sector = tables_[k];
    for (int o = 0; o < Grid::kOut; ++o) {
      if (is_set(stop)) return;
      // Reflection is reciprocal here: the walks begin where the viewer is.
      std::vector<Direction> points;
      for (int side = 0; side < sides(); ++side)
        for (int a = 0; a < Grid::kAlpha; ++a)
          for (int b = 0; b < Grid::kBeta; ++b) points.push_back(incoming(sector, o, a, b, side));
      const Direction wo = outgoing(sector, o);
      Simulation simulation(request.stack, plan, wo, points, request.seed);
      run(simulation, look.next(), {}, stop);
      fewest = std::min(fewest, simulation.walks());
      const Rgb mirrored = specular(wo);
      RestEnergy energy;
      for (int c = 0; c < 3; ++c) {
        const int channel = std::min(c, plan.channels - 1);
        for (std::size_t j = 0; j < points.size(); ++j) {
          const auto rest = [&](const BatchTally& b) {
            double sum = 0;
            for (int order = first; order < end; ++order)
              sum += b.f[static_cast<std::size_t>(order * plan.channels + channel) * points.size() +
                         j];
            return sum;
          };
          const int at = static_cast<int>(j) % kOneSide;
          HalfVectorGrid& grid = static_cast<int>(j) < kOneSide ? sector.rest : sector.right;
          double& value = grid.at(o, at / Grid::kBeta, at % Grid::kBeta)[c];
          value = batch_estimate(simulation.batches(), rest).value;
          if (closed_ == Closed::zero) value -= closed(wo, points[j])[c];
        }
        const auto reflected = [&](int from) {
          return batch_estimate(simulation.batches(), [&](const BatchTally& b) {
            double sum = 0;
            for (int order = from; order < kTallyOrders; ++order)
              sum += b.energy.up[order][channel];
            return sum;
          });
        };
        // What thinning has taken is 0 on average. With it a half space that absorbs nothing
        // reflects 1 in every batch, without noise.
        const Estimate total = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
          double sum = b.energy.thinned[channel];
          for (int order = 0; order < kTallyOrders; ++order) sum += b.energy.up[order][channel];
          return sum + b.energy.zero_up[channel];
        });
        const Estimate direct = reflected(1);
        energy.total[c] = total.value - mirrored[c];
        energy.total_error[c] = total.standard_error;
        energy.direct[c] = direct.value;
        energy.direct_error[c] = boundaries ? kUnknown : direct.standard_error;
        if (!boundaries || has_delta_flakes(stack_))
          for (const BatchTally& b : simulation.batches())
            mirrored_by_flakes += b.energy.specular_up[channel];
      }
      sector.energies.push_back(energy);
    }
  }
  source_ =
      fmt::format("{} next-event walks for each of {} outgoing {}{}", fewest,
                  Grid::kOut * tables_.size(), has_azimuth() ? "directions" : "cosines",
                  fewest < request.effort.walks && !is_set(stop)
                      ? fmt::format(" or more, of {} in {:g} s", request.effort.walks, kWalkSeconds)
                      : "");
  // Straight on every azimuth is the same: what walks found at each of them is one value.
  if (!has_azimuth())
    for (int a = 0; a < Grid::kAlpha; ++a) {
      Rgb mean;
      for (int b = 0; b < Grid::kBeta; ++b)
        mean += 1.0 / Grid::kBeta * tables_.front().rest.at(0, a, b);
      for (int b = 0; b < Grid::kBeta; ++b) tables_.front().rest.at(0, a, b) = mean;
    }
  // Light that met mirrors only leaves as a delta, which no picture here has: energies with it say
  // nothing of the table.
  if (mirrored_by_flakes > 0) {
    for (Sector& sector : tables_) sector.energies.clear();
    source_ += ", without the mirror image of its delta flakes";
  }
}

void LobeTable::scale_to_energies(Sector& sector, const StopFlag* stop) {
  const std::size_t count = kScalesPerNode * (Grid::kOut - 1) + 1;
  sector.scales.assign(count, Rgb(1));
  if (sector.energies.empty()) return;
  std::vector<Rgb> first(count), shape(count), mirrored(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t k) {
    if (is_set(stop)) return;
    const double mu = Grid::node_mu(static_cast<double>(k) / kScalesPerNode);
    const Direction wo = direction_from_mu_phi(mu, sector.azimuth);
    const auto raised = [](Direction wi) { return raised_to(wi, Grid::kLeastMu); };
    mirrored[k] = specular(wo);
    // lobe_cells knows one side of the plane of w_o = (sine, 0, mu).
    const double c = std::cos(sector.azimuth), s = std::sin(sector.azimuth);
    const auto rest = rest_towards(sector, wo);
    for (int side = 0; side < sides(); ++side) {
      const auto turned = [&](Direction w) {
        if (side == 1) w.y = -w.y;
        return raised({c * w.x - s * w.y, s * w.x + c * w.y, w.z});
      };
      const double share = 1.0 / sides();
      first[k] +=
          share * lobe_cells([&](Direction wi) { return closed(turned(wi), wo); }, mu).energy;
      shape[k] += share * lobe_cells([&](Direction wi) { return rest(turned(wi)); }, mu).energy;
    }
  });
  if (is_set(stop)) return;
  for (int c = 0; c < 3; ++c) {
    // At the nodes: of the table's orders, and of all.
    std::vector<double> rest, all;
    bool total_is_better = true;
    for (std::size_t o = 0; o < sector.energies.size(); ++o) {
      const RestEnergy& e = sector.energies[o];
      const double closed_energy = first[kScalesPerNode * o][c];
      const bool better = e.total_error[c] + kLobeTolerance * closed_energy < e.direct_error[c];
      total_is_better = total_is_better && better;
      rest.push_back(std::max(better ? e.total[c] - closed_energy : e.direct[c], 0.0));
      all.push_back(e.total[c] + mirrored[kScalesPerNode * o][c]);
    }
    for (std::size_t k = 0; k < count; ++k) {
      if (!(shape[k][c] > 0)) continue;
      // What is closed is known everywhere: where the energy of all orders is better known it is
      // what is interpolated, so that a white half space stays white between the nodes.
      const double place = static_cast<double>(k) / kScalesPerNode;
      const double wanted = total_is_better
                                ? interpolated(all, place) - mirrored[k][c] - first[k][c]
                                : interpolated(rest, place);
      sector.scales[k][c] = std::max(wanted, 0.0) / shape[k][c];
    }
  }
}

LobeTable LobeTable::make(const TruthRequest& request, const StopFlag* stop,
                          const SolverReport& report) {
  LobeTable table;
  TruthRequest drawn = request;
  drawn.stack = drawn_stack(request.stack);
  const Stack& stack = table.stack_ = drawn.stack;
  const SurfaceLaw* law = stack.substrate ? stack.substrate->law.get() : nullptr;
  table.closed_ = !is_first_closed(stack)       ? Closed::zero
                  : law && law->is_stochastic() ? Closed::nothing
                                                : Closed::order_one;
  check_estimator(drawn);
  const bool is_turned = !stack.is_symmetric_about_z();
  if (is_turned) {
    table.symmetry_ = sector_symmetry(stack);
    table.tables_.resize(kSectors);
    for (int k = 0; k < kSectors; ++k)
      table.tables_[k].azimuth = table.symmetry_.azimuth + 2 * kPi * k / kSectors;
  }
  const bool in_harmonics = is_turned && !why_not_harmonic(stack) && !stack.has_boundaries();
  const bool solvable =
      (is_turned ? in_harmonics : !why_not_deterministic(stack)) && request.given.empty();
  const bool must = request.estimator == Estimator::deterministic;
  std::optional<std::string> unsolved = "not tried";
  if (is_turned && must && !in_harmonics)
    throw UsageError(
        fmt::format("--estimator: found \"deterministic\" for the table of {}, but {}; allowed: "
                    "auto, next-event",
                    stack.name, why_not_harmonic(stack).value_or("interfaces are left to walks")));
  if (in_harmonics && (must || (solvable && !request.estimator))) {
    table.solve_in_harmonics(request, stop);
    unsolved.reset();
  } else if (must || (solvable && !request.estimator)) {
    unsolved = table.solve(request, must, stop, report);
    if (unsolved && must) refuse_answer(stack, *unsolved);
  }
  if (unsolved) table.walk(drawn, stop);
  for (Sector& sector : table.tables_) table.scale_to_energies(sector, stop);
  if (has_narrow_lobes(request.stack))
    table.source_ += fmt::format("; roughness below {} drawn as smooth", kLeastLobe);
  return table;
}

void check_preview(const std::string& what, const Stack& stack, const std::vector<Stack>& texels) {
  for (const Stack& texel : texels) check_preview(what, texel);
  const bool leans = std::any_of(stack.layers.begin(), stack.layers.end(), [](const Layer& layer) {
    const Direction n = traits(layer.medium).mean_normal.value;
    return !layer.interface && (n.x != 0 || n.y != 0);
  });
  const char* found = stack.grains()     ? "explicit geometry"
                      : stack.has_grid() ? "a density grid"
                      : leans ? "one-sided flakes that lean, whose reflection is not reciprocal"
                      : !has_reciprocal_substrate(stack)
                          ? "a substrate whose closed form is not reciprocal"
                          : nullptr;
  if (found)
    throw UsageError(
        fmt::format("{} {}: found {}; allowed: homogeneous layers and interfaces over none or a "
                    "reciprocal substrate{}",
                    what, stack.name, found,
                    stack.grains() || stack.has_grid()
                        ? ""
                        : "; preview --shape takes what is not reciprocal, too"));
}

}  // namespace lamella
