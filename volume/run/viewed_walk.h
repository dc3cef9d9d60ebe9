#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "phase/math/color.h"
#include "phase/stack/stack.h"
#include "volume/plan/plan.h"

namespace lamella {

/// What one walk from the viewer's direction w_o knows of a stack's BSDF.
struct ViewedLight {
  /// An unbiased estimate of f(w_i, w_o) [1/sr] at the asked-for w_i, deltas left out.
  Rgb f{};
  /// Where the walk left: w_i with the weight f |mu_i| / density. Nothing: it ended in the stack.
  struct Departure {
    Direction wi;
    Rgb weight;
    /// Light along w_i that no estimate of `f` has: it passed deltas alone, or only those since
    /// anything could be aimed.
    bool unaimed = false;
    /// It passed the stack without an event, w_i = -w_o, where `uncollided` has that light.
    bool straight = false;
  };
  std::optional<Departure> departure{};
};

/// A stack for path tracing: one position-free walk with next-event estimation per sample, from the
/// viewer into the stack. By reciprocity a walk from w_o gives f(w_i, w_o); the transmission of
/// one-sided layers is corrected by Stack::one_sidedness. Immutable; any thread.
class ViewedStack {
 public:
  /// The substrate's closed form, if there is one, must be reciprocal. Throws std::invalid_argument
  /// for explicit geometry, density grids, one-sided flakes with a tilted mean normal, and open
  /// stacks whose lowest medium has another index than 1.
  explicit ViewedStack(const Stack& stack, const WalkLimits& limits = {});
  ~ViewedStack();
  ViewedStack(ViewedStack&&) noexcept;

  [[nodiscard]] bool transmits() const;
  /// The share of light from w that passes without an event: Stack::uncollided, and 0 where the
  /// stack has interfaces or is closed below.
  [[nodiscard]] double uncollided(Direction w) const;

  /// The walk of that number from w_o. `wi`: of f, mu != 0; nullptr: no estimate. Both unit; from
  /// below (mu < 0) only where the stack transmits.
  [[nodiscard]] ViewedLight follow(Direction wo, const Direction* wi, std::uint64_t seed,
                                   std::uint64_t number) const;

 private:
  struct Content;
  std::unique_ptr<const Content> content_;
};

}  // namespace lamella
