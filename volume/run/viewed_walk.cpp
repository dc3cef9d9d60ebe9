#include "volume/run/viewed_walk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "volume/interfaces/boundary_scorers.h"
#include "volume/interfaces/boundary_walk.h"

namespace lamella {
namespace {

// Walks whose ways out share no random numbers.
constexpr std::uint64_t kWalkStride = kBatches * kWalksPerWay;

// Keeps what leaves, beside what Base aims.
template <class Base>
class Departing : public Base {
 public:
  using Base::Base;

  void leave(Direction, const std::array<double, 3>&, std::uint64_t, bool open) { aimed_ = !open; }
  void goes_on(double density) { density_ = density; }
  void departs(Direction wo, const std::array<double, 3>& weight, std::uint64_t order, bool) {
    departure_ = {wo, {weight[0], weight[1], weight[2]}, {}, order == 0};
  }
  [[nodiscard]] std::optional<ViewedLight::Departure> departure() const {
    if (!departure_) return std::nullopt;
    ViewedLight::Departure found = *departure_;
    if (aimed_) found.density = AimedShare::walked(density_);
    return found;
  }

 private:
  std::optional<ViewedLight::Departure> departure_;
  bool aimed_ = false;
  double density_ = 0;  // of the direction taken at the last event that was scored
};

// Aims nothing, but knows what could have been aimed.
struct Unaimed : UnaimedAtBoundaries<NullScorer> {
  template <std::size_t C>
  [[nodiscard]] bool interface(int, const Dielectric&, Direction, const std::array<double, C>&,
                               std::uint64_t, RandomStream&) {
    return true;
  }
};

// Refuses what neither class walks through.
Plan walked_plan(const Stack& stack, const WalkLimits& limits, const char* found,
                 const char* kind) {
  if (stack.grains())
    found = "explicit geometry";
  else if (stack.has_grid())
    found = "a density grid";
  else if (stack.is_open_below() && stack.index_of(stack.layers.size()) != 1)
    found = "an open side in a medium of another index";
  if (found)
    throw std::invalid_argument(fmt::format(
        "{}: found {}; allowed: {} of homogeneous layers and interfaces, with air on every open "
        "side",
        stack.name, found, kind));
  Plan plan = make_plan(stack, limits);
  plan.channels = 3;
  plan.boundaries = true;
  return plan;
}

Plan viewed_plan(const Stack& stack, const WalkLimits& limits) {
  return walked_plan(
      stack, limits,
      has_leaning_flakes(stack) ? "one-sided flakes with a tilted mean normal" : nullptr,
      "reciprocal stacks");
}

// A part of the stack that sends light on along one direction alone.
const char* delta_of(const Stack& stack) {
  for (const Layer& layer : stack.layers)
    if (layer.interface ? layer.interface->facets.shape == FacetShape::smooth
                        : is_delta(layer.medium))
      return layer.interface ? "a smooth interface beside what is not reciprocal"
                             : "delta flakes beside what is not reciprocal";
  if (stack.substrate && stack.substrate->law && stack.substrate->law->is_delta())
    return "a substrate that mirrors below what is not reciprocal";
  return nullptr;
}

double uncollided_of(const Stack& stack, bool passes, Direction w) {
  return passes ? stack.uncollided(w) : 0;
}

// Orders and channels of f at the one point that a walk scored.
Rgb sum_of(const BatchTally& tally, std::size_t slots) {
  Rgb f;
  for (std::size_t slot = 0; slot < slots; ++slot)
    f += Rgb(tally.f[3 * slot], tally.f[3 * slot + 1], tally.f[3 * slot + 2]);
  return f;
}

}  // namespace

bool has_leaning_flakes(const Stack& stack) {
  return std::any_of(stack.layers.begin(), stack.layers.end(), [](const Layer& layer) {
    const Direction n = traits(layer.medium).mean_normal.value;
    return !layer.interface && (n.x != 0 || n.y != 0);
  });
}

struct ViewedStack::Content {
  Content(const Stack& of, const WalkLimits& limits)
      : stack(of),
        plan(viewed_plan(stack, limits)),
        walk(stack, plan),
        gain(std::exp(stack.one_sidedness())),
        passes(plan.transmits && !stack.has_boundaries()) {}

  Stack stack;  // holds the media
  Plan plan;
  BoundaryStack walk;
  double gain;  // transmission from below over that from above
  bool passes;  // whether light passes without an event
};

ViewedStack::ViewedStack(const Stack& stack, const WalkLimits& limits)
    : content_(std::make_unique<Content>(stack, limits)) {}
ViewedStack::~ViewedStack() = default;
ViewedStack::ViewedStack(ViewedStack&&) noexcept = default;

bool ViewedStack::transmits() const { return content_->plan.transmits; }

double ViewedStack::uncollided(Direction w) const {
  return uncollided_of(content_->stack, content_->passes, w);
}

ViewedLight ViewedStack::follow(Direction wo, const LightAim* aim, std::uint64_t seed,
                                std::uint64_t number) const {
  BatchTally tally;
  ViewedLight light;
  const std::uint64_t index = number * kWalkStride;
  const double through = wo.z > 0 ? content_->gain : 1 / content_->gain;
  if (aim) {
    const auto slots = static_cast<std::size_t>(content_->plan.order_slots());
    tally.f.resize(3 * slots);
    Departing<BoundaryNextEvent<3>> scorer(content_->walk, std::vector<Direction>{aim->wi}, tally,
                                           AimedShare{aim->density});
    scorer.begin_walk(seed, index);
    walk_through_boundaries<3>(content_->walk, wo, seed, index, scorer, tally);
    light.departure = scorer.departure();
    light.f = sum_of(tally, slots);
    if (aim->wi.z * wo.z < 0) light.f = through * light.f;
  } else {
    Departing<Unaimed> scorer;
    walk_through_boundaries<3>(content_->walk, wo, seed, index, scorer, tally);
    light.departure = scorer.departure();
  }
  if (light.departure) {
    const bool passed = light.departure->wi.z * wo.z < 0;
    if (passed) light.departure->weight = through * light.departure->weight;
    light.departure->straight = light.departure->straight && passed && content_->passes;
  }
  return light;
}

struct LitStack::Content {
  Content(const Stack& of, const WalkLimits& limits)
      : stack(of),
        plan(walked_plan(stack, limits, delta_of(stack), "stacks without deltas")),
        walk(stack, plan),
        passes(plan.transmits && !stack.has_boundaries()) {}

  Stack stack;  // holds the media
  Plan plan;
  BoundaryStack walk;
  bool passes;  // whether light passes without an event
};

LitStack::LitStack(const Stack& stack, const WalkLimits& limits)
    : content_(std::make_unique<Content>(stack, limits)) {}
LitStack::~LitStack() = default;
LitStack::LitStack(LitStack&&) noexcept = default;

bool LitStack::transmits() const { return content_->plan.transmits; }

double LitStack::uncollided(Direction w) const {
  return uncollided_of(content_->stack, content_->passes, w);
}

Rgb LitStack::f(Direction wi, Direction wo, std::uint64_t seed, std::uint64_t number) const {
  BatchTally tally;
  const std::uint64_t index = number * kWalkStride;
  const auto slots = static_cast<std::size_t>(content_->plan.order_slots());
  tally.f.resize(3 * slots);
  BoundaryNextEvent<3> scorer(content_->walk, std::vector<Direction>{wo}, tally);
  scorer.begin_walk(seed, index);
  walk_through_boundaries<3>(content_->walk, wi, seed, index, scorer, tally);
  return sum_of(tally, slots);
}

}  // namespace lamella
