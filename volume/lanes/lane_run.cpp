#include "volume/lanes/lane_run.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "volume/lanes/lane_dispatch.h"
#include "volume/result/number_bytes.h"
#include "volume/walk/walk.h"

namespace lamella {
namespace {

constexpr int kOrders = kTallyOrders;
static_assert(kRouletteOrder == kTallyOrders);

std::size_t padded(std::size_t count) { return (count + 15) / 16 * 16; }

// How many sets of ways a batch holds at a time: few fit into the caches, but at the end of every
// task lanes fall idle.
std::uint64_t sets_per_task(int targets, std::size_t batches) {
  const std::uint64_t room = (1 << 17) / (static_cast<std::uint64_t>(targets) * batches);
  return std::clamp<std::uint64_t>(room, 16, 256);
}

// f of order 0 in whole numbers, so that sums do not depend on how walks are dealt out: multiples
// of 2^-6 and what remains in multiples of 2^-40.
struct ZeroTerm {
  std::int64_t coarse, fine;
  explicit ZeroTerm(double f)
      : coarse(std::llround(f * 0x1p6)),
        fine(std::llround((f - static_cast<double>(coarse) * 0x1p-6) * 0x1p40)) {}
};

bool is_next_event(LaneEstimate estimate) {
  return estimate == LaneEstimate::points || estimate == LaneEstimate::cells_next_event;
}

}  // namespace

LaneRun::LaneRun(LaneEstimate estimate, const Stack& stack, const Plan& plan, Direction incident,
                 std::uint64_t seed, int batches)
    : setting_(stack, plan, incident, seed, !is_next_event(estimate)),
      sampling_(plan.sampling),
      bounded_(plan.boundaries),
      thinning_(plan.thinning),
      incident_(incident),
      counts_(batches) {
  task_.weights = !setting_.common_albedo;
  task_.one_medium = setting_.parts.size() == 1 && !task_.weights && !bounded_;
  task_.estimate = estimate;
  if (forces_flights(stack)) setting_.force_flights();
  task_.walk = setting_.walk;
  walk_ = lane_loop_of(task_, plan.isa);
  task_.channels = plan.channels;
  task_.index_stride = static_cast<std::uint32_t>(batches);
  if (!task_.weights && task_.channels > 1) {
    task_.order_cap = static_cast<std::uint32_t>(plan.max_order);
    for (int c = 0; c < task_.channels; ++c) tabulate_weights(c);
    task_.end_weight = end_weight_.data();
    task_.event_weight = event_weight_.data();
  }
  for (Counts& c : counts_) {
    c.ends.resize(rows() * (kOrders + 1));
    if (task_.weighs()) c.weights.resize(c.ends.size() * task_.channels);
    if (task_.walk.forced_flights == 0) continue;
    c.shares.resize(c.ends.size());
    c.forced.resize(std::size_t{3} * (kForcedFlights - 1));
  }
}

bool LaneRun::forces_flights(const Stack& stack) const {
  if (!is_next_event(task_.estimate) || sampling_ != Sampling::rqmc || thinning_.is_on())
    return false;
  if (task_.weights || bounded_ || stack.substrate) return false;
  // Points of several layers lose more by longer walks, each in its own layer, than they gain.
  return task_.one_medium || task_.estimate == LaneEstimate::cells_next_event;
}

void LaneRun::tabulate_weights(int channel) {
  // Beyond, each event counts the same factor: the roulette has taken over. A power each would take
  // longer than the walks.
  constexpr std::uint32_t kPowers = 1 << 16;
  static_assert(kPowers > kRouletteOrder);
  const double albedo = setting_.albedo[channel];
  const double brightest = *std::max_element(setting_.albedo.begin(), setting_.albedo.end());
  double before = 1, weight = 1;
  for (std::uint32_t k = 0; k <= task_.order_cap; ++k, before = weight) {
    if (k <= kPowers)
      weight = setting_.weight_after(channel, k);
    else if (albedo != brightest)
      weight = before * (albedo / brightest);
    end_weight_.push_back(std::llround(weight * kPointUnits));
    event_weight_.push_back(static_cast<float>(k == 0 ? 1 : before * albedo));
  }
}

LaneRun::LaneRun(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed,
                 int batches, const CellTargets& cells, Estimator estimator)
    : LaneRun(estimator == Estimator::analog ? LaneEstimate::cells_counted
                                             : LaneEstimate::cells_next_event,
              stack, plan, incident, seed, batches) {
  cells_ = cells;
  const CellGrid& grid = cells.grid;
  LaneCells& to = task_.cells;
  to.on = true;
  to.folded = grid.folded;
  to.both_sides = cells.both_sides;
  to.symmetric = stack.is_symmetric_about_z();
  to.rows = grid.rows();
  to.columns = grid.columns();
  to.phi_cells = grid.phi_cells;
  to.azimuth_turns = static_cast<float>(cells.incident_azimuth / (2 * kPi));
  if (estimator == Estimator::analog) {
    for (Counts& c : counts_)
      c.cells.resize(static_cast<std::size_t>(slots()) * task_.channels * cells.count() +
                     c.ends.size());
    return;
  }
  if (bounded_) {
    task_.term_scale = static_cast<float>(std::ldexp(1.0, -coarser_bits_along_ways(stack, plan)));
    ways_.emplace(stack, plan, seed, batches, cells_);
    aim_along_ways(plan.isa);
    for (Counts& c : counts_)
      c.cells.resize(static_cast<std::size_t>(slots()) * task_.channels * cells.count() +
                     c.ends.size());
    return;
  }
  task_.term_scale = static_cast<float>(std::ldexp(1.0, -coarser_bits_in_cells(stack, plan, grid)));
  const std::size_t columns = padded(grid.columns()), rows = padded(grid.rows());
  to.padded_columns = static_cast<int>(columns);
  for (std::size_t j = 0; j < columns; ++j) {
    const double phi = cells.incident_azimuth + 2 * kPi * static_cast<double>(j) / grid.phi_cells;
    column_cos_.push_back(static_cast<float>(std::cos(phi)));
    column_sin_.push_back(static_cast<float>(std::sin(phi)));
  }
  to.column_cos = column_cos_.data();
  to.column_sin = column_sin_.data();
  for (Counts& c : counts_) {
    c.targets.resize(kOrders * task_.channels * (cells.both_sides ? 2 : 1) * grid.rows() * columns);
    c.scratch.resize(kLaneScratchRows * rows + 2 * columns);
  }
}

LaneRun::LaneRun(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed,
                 int batches, const std::vector<Direction>& points)
    : LaneRun(points.empty() ? LaneEstimate::energies : LaneEstimate::points, stack, plan, incident,
              seed, batches) {
  if (points.empty()) return;
  if (bounded_) {
    task_.term_scale = static_cast<float>(std::ldexp(1.0, -coarser_bits_along_ways(stack, plan)));
    ways_.emplace(stack, plan, incident, seed, batches, points);
    aim_along_ways(plan.isa);
    for (Counts& c : counts_) {
      c.zero_coarse.resize(points.size());
      c.zero_fine.resize(points.size());
    }
    return;
  }
  task_.term_scale = static_cast<float>(std::ldexp(1.0, -coarser_bits_at_points(stack, plan)));
  trace(stack, points);
  for (Counts& c : counts_) c.targets.resize(kOrders * task_.channels * padded(points.size()));
}

void LaneRun::aim_along_ways(Isa isa) {
  task_.weights = true;
  task_.end_weight = nullptr;
  task_.event_weight = nullptr;
  walk_ = aim_bounded_lanes_for(isa);
  task_.same_ways = !ways_->is_random();
  task_.way_targets = static_cast<int>(padded(ways_->targets()));
  task_.way_places = ways_->places();
  inverse_mu_.assign(ways_->targets(), 1);
  if (!ways_->is_random()) common_ways_ = ways_->set(0, 0);
  for (Counts& c : counts_) {
    c.weights.resize(c.ends.size() * task_.channels);
    c.targets.resize(static_cast<std::size_t>(kOrders) * task_.channels * task_.way_targets);
  }
}

LaneRun::Ways LaneRun::ways_of(int batch, std::uint64_t from, std::uint64_t walks) {
  Counts& counts = counts_[batch];
  const auto add_zero = [&](const WayTables::Set& set, std::uint64_t count) {
    for (std::size_t j = 0; j < counts.zero_fine.size(); ++j) {
      const ZeroTerm term(set.zero[j]);
      counts.zero_coarse[j] += static_cast<std::int64_t>(count) * term.coarse;
      counts.zero_fine[j] += static_cast<std::int64_t>(count) * term.fine;
    }
  };
  Ways ways;
  if (common_ways_) {
    add_zero(*common_ways_, walks);
    return ways;
  }
  for (std::uint64_t at = from; at < from + walks;) {
    const std::uint64_t k = at / WayTables::kWalksPerSet;
    const std::uint64_t end = std::min(from + walks, (k + 1) * WayTables::kWalksPerSet);
    ways.sets.push_back(ways_->set(batch, k));
    ways.tables.push_back(ways.sets.back().ways);
    add_zero(ways.sets.back(), end - at);
    at = end;
  }
  return ways;
}

void LaneRun::trace(const Stack& stack, const std::vector<Direction>& points) {
  constexpr std::size_t kPlaces = kMostLaneLayers + 1;
  const std::size_t count = padded(points.size()), layers = setting_.parts.size();
  for (auto* by_layer : {&rate_, &beyond_}) by_layer->resize((layers + 1) * count);
  for (auto* by_point : {&rate_by_point_, &beyond_by_point_}) by_point->resize(kPlaces * count);
  for (std::size_t j = 0; j < count; ++j) {
    const Direction wo = points[std::min(j, points.size() - 1)];
    point_x_.push_back(static_cast<float>(wo.x));
    point_y_.push_back(static_cast<float>(wo.y));
    point_z_.push_back(static_cast<float>(wo.z));
    const bool up = wo.z > 0;
    if (j < points.size()) inverse_mu_.push_back(1 / std::abs(wo.z));
    task_.points.up += j < points.size() && up;
    double tau = 0;
    const auto write = [&](std::size_t k, double rate) {
      rate_[k * count + j] = rate_by_point_[j * kPlaces + k] = static_cast<float>(rate);
      beyond_[k * count + j] = beyond_by_point_[j * kPlaces + k] = static_cast<float>(tau);
    };
    for (std::size_t step = 0; step < layers; ++step) {
      const std::size_t k = up ? step : layers - 1 - step;
      const LanePart& part = setting_.parts[k];
      const double rate = sigma(stack.layers[part.layer].medium, -wo) / std::abs(wo.z);
      write(k, rate);
      if (rate > 0) tau += part.depth * rate;
    }
    // The substrate's light crosses all of them; it does not go down.
    if (!up) tau = 1e30;
    write(layers, 0);
  }
  task_.points.count = static_cast<int>(points.size());
  task_.points.padded = static_cast<int>(count);
  task_.points.x = point_x_.data();
  task_.points.y = point_y_.data();
  task_.points.z = point_z_.data();
  task_.points.rate = rate_.data();
  task_.points.beyond = beyond_.data();
  task_.points.rate_by_point = rate_by_point_.data();
  task_.points.beyond_by_point = beyond_by_point_.data();
}

std::optional<std::uint64_t> LaneRun::first_not_finite(LaneWalkTask task, LaneBatch batch) const {
  const auto is_finite = [&](LaneBatch part) {
    Counts spare = counts_.front();
    LaneSums sums = spare.sums();
    part.sums = &sums;
    task.batches = &part;
    task.batch_count = 1;
    task.cells.scratch = spare.scratch.data();
    walk_(task);
    return sums.finite;
  };
  if (is_finite(batch)) return std::nullopt;
  // Halves the walks until one is left: they are the same in whatever company.
  while (batch.walks > 1) {
    LaneBatch half = batch;
    half.walks = batch.walks / 2;
    if (is_finite(half)) {
      batch.index_low += half.walks * task.index_stride;
      batch.point += half.walks;
      batch.walks_before += half.walks;
      half.walks = batch.walks - half.walks;
    }
    batch.walks = half.walks;
  }
  return (std::uint64_t{task.index_high} << 32) + batch.index_low;
}

std::uint32_t LaneRun::lattice_shift_of(int batch, std::uint64_t walk) const {
  if (sampling_ == Sampling::random) return 0;
  return lattice_shift(setting_.walk.seed, static_cast<std::uint32_t>(batch), walk);
}

void LaneRun::run(int first, std::span<const Part> parts, std::span<BatchTally> tallies) {
  LaneWalkTask task = task_;
  task.cells.scratch = counts_[first].scratch.data();
  LatticeNumbers lattice;
  const std::uint64_t stride = counts_.size();
  std::vector<Part> left(parts.begin(), parts.end());
  std::vector<LaneSums> sums;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    sums.push_back(counts_[first + k].sums());
    tallies[k].walks += parts[k].to - parts[k].from;
  }
  for (;;) {
    // As far as the upper half of the index stays.
    std::vector<LaneBatch> batches;
    batches.reserve(left.size());
    std::vector<Ways> ways(left.size());
    for (std::size_t k = 0; k < left.size(); ++k) {
      const std::uint64_t index = left[k].from * stride + static_cast<std::uint64_t>(first) + k;
      const std::uint64_t low = index & 0xFFFFFFFFu;
      std::uint64_t here = std::min(left[k].to - left[k].from, (0xFFFFFFFFu - low) / stride + 1);
      const std::uint64_t before = left[k].from % WayTables::kWalksPerSet;
      if (ways_) {
        const std::uint64_t most = sets_per_task(ways_->targets(), left.size());
        here = std::min(here, most * WayTables::kWalksPerSet - before);
        ways[k] = ways_of(first + static_cast<int>(k), left[k].from, here);
      }
      if (sampling_ == Sampling::rqmc)
        here = std::min(here, kLatticePoints - lattice_point(left[k].from));
      task.index_high = static_cast<std::uint32_t>(index >> 32);
      batches.push_back({static_cast<std::uint32_t>(low), static_cast<std::uint32_t>(here),
                         &sums[k], lattice_point(left[k].from),
                         lattice_shift_of(first + static_cast<int>(k), left[k].from),
                         common_ways_ ? &common_ways_->ways : ways[k].tables.data(),
                         static_cast<std::uint32_t>(before)});
      left[k].from += here;
    }
    if (std::all_of(batches.begin(), batches.end(),
                    [](const LaneBatch& b) { return b.walks == 0; }))
      break;
    task.batches = batches.data();
    task.batch_count = static_cast<std::uint32_t>(batches.size());
    if (sampling_ == Sampling::rqmc) {
      lattice = batches.size() == 1 ? lattice_of_batch(batches[0].shift) : lattice_of_batches();
      task.walk.lattice = &lattice;
    }
    walk_(task);
    if (!sums.front().finite)
      for (const LaneBatch& batch : batches)
        if (const auto walk = first_not_finite(task, batch))
          throw NonFiniteError(task.walk.seed, *walk, incident_);
  }
  Counts& counts = counts_[first];
  counts.lane_steps += sums.front().lane_steps;
  counts.busy += sums.front().busy_lane_steps;
  counts.events += sums.front().events;
  counts.reflections += sums.front().reflections;
  counts.meetings += sums.front().meetings;
  for (std::size_t k = 0; k < parts.size(); ++k) to_tally(counts_[first + k], tallies[k]);
  // The first one's counts have all events.
  for (std::size_t k = 1; k < parts.size(); ++k) {
    tallies.front().collisions += tallies[k].collisions;
    tallies[k].collisions = 0;
  }
}

std::vector<std::uint64_t> LaneRun::all_ends(const Counts& counts) const {
  std::vector<std::uint64_t> ends = counts.ends;
  if (task_.estimate != LaneEstimate::cells_counted || task_.weighs()) return ends;
  const std::size_t side = cells_.grid.cells();
  const std::int64_t* cells = counts.cells.data();
  for (int slot = 0; slot < slots(); ++slot)
    for (int end = 0; end < (cells_.both_sides ? 2 : 1); ++end, cells += side)
      ends[end * (kOrders + 1) + (slot == kZeroSlot ? 0 : slot + 1)] +=
          static_cast<std::uint64_t>(std::accumulate(cells, cells + side, std::int64_t{0}));
  for (std::size_t at = 0; at < ends.size(); ++at)
    ends[at] += static_cast<std::uint64_t>(cells[at]);
  return ends;
}

void LaneRun::energies_to_tally(const Counts& counts, BatchTally& tally) const {
  const std::vector<std::uint64_t> ends = all_ends(counts);
  const double chance = setting_.chance;
  const auto place = [](auto end, int order) {
    return static_cast<std::size_t>(end) * (kOrders + 1) + static_cast<std::size_t>(order);
  };
  // standing: how many original walks the survivors represent. At a halving event from order 4 on,
  // absorption and thinning end walks together and the count does not tell which; `absorbed` is
  // absorption's expected share of those ends.
  double standing = static_cast<double>(tally.walks);
  if (thinning_.is_on()) {
    const double albedo = *std::max_element(setting_.albedo.begin(), setting_.albedo.end());
    const double absorbed = task_.weights ? 0 : (1 - albedo) / (2 - albedo);
    standing = absorbed * static_cast<double>(ends[place(WalkEnd::thinned, kOrders)]);
    for (int row = 0; row < rows(); ++row)
      for (int k = 0; k <= kOrders && row != static_cast<int>(WalkEnd::thinned); ++k)
        standing += static_cast<double>(ends[place(row, k)]);
  }
  EnergySums energy{};
  const bool from_above = task_.walk.from_above;
  const int straight = bounded_ ? straight_row<true>(from_above) : straight_row<false>(from_above);
  for (int c = 0; c < task_.channels; ++c) {
    // What left on forced flights, up or down, or what roulette took then (kTaken), after events
    // that count as an order.
    constexpr int kTaken = 2, kFlights = static_cast<int>(kForcedFlights) - 1;
    const auto forced = [&](int side, int order) {
      double sum = 0;
      if (counts.forced.empty()) return sum;
      for (int events = 1; events <= kFlights; ++events) {
        if (std::min(events, kOrders) != order) continue;
        const auto row = std::min(static_cast<std::uint32_t>(events), task_.order_cap);
        const double weight =
            task_.weighs()
                ? static_cast<double>(end_weight_[c * (task_.order_cap + 1) + row]) / kPointUnits
                : setting_.weight_after(0, order);
        sum += weight * static_cast<double>(counts.forced[side * kFlights + events - 1]);
      }
      return chance * sum / kPointUnits;
    };
    // What walks of one order weigh together as they end.
    const auto ended = [&](auto end, int order) {
      const std::size_t at = place(end, order);
      const int side = static_cast<int>(end);
      const double on_forced = side < kTaken ? forced(side, order) : 0;
      if (task_.weighs())
        return on_forced +
               chance / kPointUnits * static_cast<double>(counts.weights[c * ends.size() + at]);
      const double walks = counts.shares.empty()
                               ? static_cast<double>(ends[at])
                               : static_cast<double>(counts.shares[at]) / kPointUnits;
      return on_forced + chance * walks * setting_.weight_after(0, order);
    };
    double taken = 0;
    for (int k = 1; k <= kOrders; ++k) taken += forced(kTaken, k);
    energy.uncollided[c] = (1 - chance) * static_cast<double>(tally.walks) + ended(straight, 0);
    energy.unresolved[c] = ended(WalkEnd::unresolved, 0);
    energy.thinned[c] = chance * (static_cast<double>(tally.walks) - standing) + taken;
    // A walk has lost to its events what it lacks at its end, and at a last event everything.
    energy.absorbed[c] =
        chance * standing - taken - ended(straight, 0) - ended(WalkEnd::unresolved, 0);
    for (int k = 1; k <= kOrders; ++k) {
      energy.up[k - 1][c] = ended(WalkEnd::up, k);
      energy.down[k - 1][c] = ended(WalkEnd::down, k);
      energy.unresolved[c] += ended(WalkEnd::unresolved, k);
      energy.absorbed[c] -=
          ended(WalkEnd::up, k) + ended(WalkEnd::down, k) + ended(WalkEnd::unresolved, k);
    }
    if (!counts.forced.empty() && setting_.albedo[c] == 1) {
      // Nothing is; what is there is the rounding of shares.
      energy.thinned[c] += energy.absorbed[c];
      energy.absorbed[c] = 0;
    }
    if (!bounded_) continue;
    for (int k = 0; k <= kOrders; ++k) energy.lost[c] += ended(kLostRow, k);
    (from_above ? energy.specular_up : energy.specular_down)[c] =
        ended(kDeltaRow + (from_above ? 0 : 1), 0);
    energy.zero_up[c] = ended(WalkEnd::up, 0) + energy.specular_up[c];
    energy.zero_down[c] = ended(WalkEnd::down, 0) + energy.specular_down[c];
    energy.absorbed[c] -= energy.lost[c] + energy.zero_up[c] + energy.zero_down[c];
  }
  tally.energy = energy;
  tally.collisions = counts.events - counts.reflections;
  // The event that was one too many.
  const unsigned counted_for = thinning_.spared(task_.walk.max_order);
  for (int k = 0; k <= kOrders; ++k)
    tally.collisions -=
        ends[static_cast<int>(WalkEnd::unresolved) * (kOrders + 1) + k] >> counted_for;
}

void LaneRun::to_tally(const Counts& counts, BatchTally& tally) const {
  energies_to_tally(counts, tally);
  const int channels = task_.channels;
  const double chance = setting_.chance;
  if (task_.estimate == LaneEstimate::cells_counted) {
    const double scale = chance / cells_.grid.projected_solid_angle();
    const std::size_t targets = cells_.count();
    for (int slot = 0; slot < slots(); ++slot) {
      const std::uint32_t order = slot == kZeroSlot ? 0 : static_cast<std::uint32_t>(slot) + 1;
      const double weight = task_.weighs() ? 1 / kPointUnits : setting_.weight_after(0, order);
      for (int c = 0; c < channels; ++c)
        for (std::size_t j = 0; j < targets; ++j) {
          const auto sum = static_cast<double>(counts.cells[(c * slots() + slot) * targets + j]);
          tally.f[(slot * channels + c) * targets + j] = scale * weight * sum;
        }
    }
    return;
  }
  if (task_.estimate == LaneEstimate::energies) return;
  // What an event of an order sends out, where the sums leave that out.
  const auto factor = [&](int slot) {
    return chance / (kPointUnits * static_cast<double>(task_.term_scale)) *
           (task_.weighs() ? 1 : setting_.weight_after(0, slot) * setting_.albedo[0]);
  };
  const bool points = task_.estimate == LaneEstimate::points || ways_;
  const std::size_t columns = ways_    ? task_.way_targets
                              : points ? task_.points.padded
                                       : task_.cells.padded_columns;
  const std::size_t used = points ? inverse_mu_.size() : task_.cells.columns;
  const std::size_t rows = points ? 1 : task_.cells.rows * (task_.cells.both_sides ? 2 : 1);
  for (int slot = 0; slot < kOrders; ++slot) {
    const double scale = factor(slot);
    for (int c = 0; c < channels; ++c)
      for (std::size_t r = 0; r < rows; ++r)
        for (std::size_t j = 0; j < used; ++j) {
          const std::size_t plane = slot * channels + c;
          tally.f[(plane * rows + r) * used + j] =
              scale * (points ? inverse_mu_[j] : 1) *
              static_cast<double>(counts.targets[(plane * rows + r) * columns + j]);
        }
  }
  if (ways_) zero_to_tally(counts, tally);
}

void LaneRun::zero_to_tally(const Counts& counts, BatchTally& tally) const {
  const std::size_t targets = inverse_mu_.size();
  const double scale = setting_.chance / cells_.grid.projected_solid_angle() / kPointUnits;
  for (int c = 0; c < task_.channels; ++c)
    for (std::size_t j = 0; j < targets; ++j)
      tally.f[(static_cast<std::size_t>(kZeroSlot) * task_.channels + c) * targets + j] =
          task_.estimate == LaneEstimate::points
              ? static_cast<double>(counts.zero_coarse[j]) * 0x1p-6 +
                    static_cast<double>(counts.zero_fine[j]) * 0x1p-40
              : scale *
                    static_cast<double>(
                        counts.cells[static_cast<std::size_t>(c * slots() + kZeroSlot) * targets +
                                     j]);
}

std::string LaneRun::save(int batch) const {
  const Counts& c = counts_[batch];
  NumberWriter out;
  for (const std::uint64_t n : {c.lane_steps, c.busy, c.events, c.reflections, c.meetings})
    out.put(n);
  out.put_all(std::span<const std::uint64_t>(c.ends));
  out.put_all(std::span<const std::int64_t>(c.weights));
  out.put_all(std::span<const std::int64_t>(c.cells));
  out.put_all(std::span<const std::int64_t>(c.shares));
  out.put_all(std::span<const std::int64_t>(c.forced));
  out.put_all(std::span<const std::int64_t>(c.targets.data(), c.targets.size()));
  out.put_all(std::span<const std::int64_t>(c.zero_coarse));
  out.put_all(std::span<const std::int64_t>(c.zero_fine));
  return out.take();
}

void LaneRun::restore(int batch, std::string_view bytes) {
  Counts& c = counts_[batch];
  NumberReader in(bytes);
  for (std::uint64_t* n : {&c.lane_steps, &c.busy, &c.events, &c.reflections, &c.meetings})
    *n = in.get<std::uint64_t>();
  in.fill(std::span<std::uint64_t>(c.ends));
  in.fill(std::span<std::int64_t>(c.weights));
  in.fill(std::span<std::int64_t>(c.cells));
  in.fill(std::span<std::int64_t>(c.shares));
  in.fill(std::span<std::int64_t>(c.forced));
  in.fill(std::span<std::int64_t>(c.targets.data(), c.targets.size()));
  in.fill(std::span<std::int64_t>(c.zero_coarse));
  in.fill(std::span<std::int64_t>(c.zero_fine));
  in.end();
}

LaneUse LaneRun::use() const {
  double steps = 0, busy = 0, events = 0;  // meetings with interfaces among them
  for (const Counts& c : counts_) {
    steps += static_cast<double>(c.lane_steps);
    busy += static_cast<double>(c.busy);
    events += static_cast<double>(c.events + c.meetings);
  }
  if (busy <= 0) return {};
  return {busy / steps, 1 - events / busy};
}

}  // namespace lamella
