#include "volume/lanes/lane_samples.h"

#include <cmath>
#include <memory>
#include <optional>

#include "volume/walk/walk.h"

namespace lamella {
namespace {

constexpr std::uint32_t kTabulatedOrders = 1024;

}  // namespace

// What the loop writes, for walks of one call.
struct LaneSamples::Rows {
  explicit Rows(std::size_t walks)
      : room(walks + 64),
        floats(std::make_unique_for_overwrite<float[]>(9 * room)),
        words(std::make_unique_for_overwrite<std::uint32_t[]>(2 * room)) {}

  [[nodiscard]] LaneRecords records() const {
    float* at = floats.get();
    LaneRecords rows;
    for (float** row : {&rows.wi_x, &rows.wi_y, &rows.wi_z, &rows.x, &rows.y, &rows.z,
                        &rows.weight[0], &rows.weight[1], &rows.weight[2]}) {
      *row = at;
      at += room;
    }
    rows.events = words.get();
    rows.end = words.get() + room;
    return rows;
  }

  std::size_t room;
  std::unique_ptr<float[]> floats;
  std::unique_ptr<std::uint32_t[]> words;
};

LaneSamples::LaneSamples(const Stack& stack, const Plan& plan, Direction incident, IncidentLaw law,
                         std::uint64_t seed)
    : setting_(stack, plan, incident, seed, law == IncidentLaw::fixed),
      thinning_(plan.thinning),
      incident_(incident) {
  if (law != IncidentLaw::fixed) {
    // Both are of one w_i.
    setting_.walk.forced_chance = 0;
    setting_.walk.collides_at_once = plan.boundaries && setting_.walk.collides_at_once;
    setting_.chance = 1;
  }
  task_.walk = setting_.walk;
  task_.weights = !setting_.common_albedo;
  task_.one_medium = setting_.parts.size() == 1 && !task_.weights && !plan.boundaries;
  task_.channels = plan.channels;
  task_.index_stride = 1;
  task_.estimate = LaneEstimate::walk_by_walk;
  task_.incident_law = law;
  loop_ = lane_loop_of(task_, plan.isa);
  for (std::uint32_t k = 0; k < kTabulatedOrders; ++k) weights_.push_back(weights_after(k));
}

std::array<float, 3> LaneSamples::weights_after(std::uint32_t order) const {
  std::array<float, 3> weights{};
  for (int c = 0; c < task_.channels; ++c)
    weights[c] = static_cast<float>(setting_.chance * thinning_.weight(order) *
                                    (task_.weights ? 1 : setting_.weight_after(c, order)));
  return weights;
}

void LaneSamples::walk(std::uint64_t from, std::uint64_t to, const Rows& rows, bool& finite) const {
  constexpr std::size_t kPlaces = kEndRows<true> * (kRouletteOrder + 1);
  std::vector<std::uint64_t> ends(kPlaces);
  std::vector<std::int64_t> weights(3 * kPlaces);
  LaneSums sums{.ends = ends.data(), .weights = weights.data()};
  const LaneBatch batch{static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(to - from),
                        &sums};
  LaneWalkTask task = task_;
  task.index_high = static_cast<std::uint32_t>(from >> 32);
  task.batches = &batch;
  task.batch_count = 1;
  task.records = rows.records();
  loop_(task);
  finite = sums.finite;
}

WalkSamples LaneSamples::take(std::uint64_t from, std::uint64_t to) const {
  const std::size_t walks = to - from;
  // Kept from call to call: fresh pages would take as long as the walks.
  thread_local std::optional<Rows> kept;
  if (!kept || kept->room < walks + 64) kept.emplace(walks);
  const Rows& rows = *kept;
  bool finite = true;
  walk(from, to, rows, finite);
  if (!finite) {
    // Halves the walks until one is left: they are the same in whatever company.
    while (to - from > 1) {
      const std::uint64_t half = from + (to - from) / 2;
      walk(from, half, rows, finite);
      (finite ? from : to) = half;
    }
    throw NonFiniteError(task_.walk.seed, from, incident_);
  }
  WalkSamples samples;
  samples.channels = task_.channels;
  samples.walks = walks;
  const std::size_t most = walks * (task_.walk.forced_chance > 0 ? 2 : 1) + 1;
  samples.wi.resize(3 * most);
  samples.wo.resize(3 * most);
  samples.weight.resize(task_.channels * most);
  samples.order.resize(most);
  samples.side.resize(most);
  const std::size_t n =
      task_.channels == 1 ? gather<1>(rows, walks, samples) : gather<3>(rows, walks, samples);
  samples.wi.resize(3 * n);
  samples.wo.resize(3 * n);
  samples.weight.resize(task_.channels * n);
  samples.order.resize(n);
  samples.side.resize(n);
  return samples;
}

template <int kChannels>
std::size_t LaneSamples::gather(const Rows& rows, std::size_t walks, WalkSamples& samples) const {
  const LaneRecords r = rows.records();
  const bool bounded = task_.walk.boundaries != nullptr, weights = task_.weights;
  const bool drawn = task_.incident_law != IncidentLaw::fixed;
  const bool forced = task_.walk.forced_chance > 0;
  const float light[3] = {static_cast<float>(incident_.x), static_cast<float>(incident_.y),
                          static_cast<float>(incident_.z)};
  const float passed = static_cast<float>(1 - setting_.chance);
  // Sides are characters, which the compiler takes for anything: nothing is read through the
  // vectors.
  float* wi = samples.wi.data();
  float* wo = samples.wo.data();
  float* weight = samples.weight.data();
  std::uint32_t* orders = samples.order.data();
  std::int8_t* side = samples.side.data();
  const std::array<float, 3>* const table = weights_.data();
  for (std::size_t j = 0; j < walks; ++j) {
    const float from[3] = {drawn ? r.wi_x[j] : light[0], drawn ? r.wi_y[j] : light[1],
                           drawn ? r.wi_z[j] : light[2]};
    if (forced) {  // the part that goes straight through, of every walk
      for (int k = 0; k < 3; ++k) {
        *wi++ = from[k];
        *wo++ = -from[k];
      }
      for (int c = 0; c < kChannels; ++c) *weight++ = passed;
      *orders++ = 0;
      *side++ = static_cast<std::int8_t>(from[2] > 0 ? -2 : 2);
    }
    // Written in any case, and kept where light left: no branch on chance.
    const std::uint32_t end = r.end[j], order = r.events[j], row = end - 1;
    for (int k = 0; k < 3; ++k) wi[k] = from[k];
    wo[0] = -r.x[j];
    wo[1] = -r.y[j];
    wo[2] = -r.z[j];
    if (order < kTabulatedOrders) {
      for (int c = 0; c < kChannels; ++c) weight[c] = table[order][c];
    } else {
      const std::array<float, 3> after = weights_after(order);
      for (int c = 0; c < kChannels; ++c) weight[c] = after[c];
    }
    if (weights && order > 0)
      for (int c = 0; c < kChannels; ++c) weight[c] *= r.weight[c][j];
    const bool delta = bounded ? row >= kDeltaRow : order == 0;
    *orders = order;
    *side = static_cast<std::int8_t>((row & 1 ? -1 : 1) << (delta ? 1 : 0));
    const std::size_t left = end != 0;
    wi += 3 * left;
    wo += 3 * left;
    weight += kChannels * left;
    orders += left;
    side += left;
  }
  return static_cast<std::size_t>(side - samples.side.data());
}

}  // namespace lamella
