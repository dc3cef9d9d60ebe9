#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

#include "phase/math/color.h"
#include "phase/stack/stack.h"
#include "volume/plan/plan.h"

namespace lamella {

/// A direction of light that was drawn to be aimed at, mu != 0.
struct LightAim {
  Direction wi;
  double density = std::numeric_limits<double>::infinity();  ///< [1/sr] with which it was drawn
};

/// What one walk from the viewer's direction w_o knows of a stack's BSDF.
struct ViewedLight {
  /// An unbiased estimate of the aimed share of f(w_i, w_o) [1/sr], deltas left out: all of f where
  /// the light's density is infinite.
  Rgb f{};
  /// Where the walk left: w_i with the weight f |mu_i| / density. Nothing: it ended in the stack.
  struct Departure {
    Direction wi;
    Rgb weight;
    /// What stands for the density d of w_i [1/sr]: where light is aimed with the density q, the
    /// share q / (q + d) of it is in `f`, and d / (q + d) counts here. It is a function of the
    /// path, the same in both, and large where the path has a narrow peak. Nothing: no `f` has this
    /// light, which passed deltas alone, or only those since anything could be aimed.
    std::optional<double> density{};
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

  /// The walk of that number from w_o. `aim`: the light that f is of; nullptr: no estimate.
  /// Directions are unit; from below (mu < 0) only where the stack transmits.
  [[nodiscard]] ViewedLight follow(Direction wo, const LightAim* aim, std::uint64_t seed,
                                   std::uint64_t number) const;

 private:
  struct Content;
  std::unique_ptr<const Content> content_;
};

/// A stack that need not be reciprocal, for path tracing: f(w_i, w_o) by one walk from the light
/// with next-event estimation towards the viewer. Where a path goes on, the caller chooses.
/// One-sided flakes may lean, and any closed form may be the substrate. Immutable; any thread.
class LitStack {
 public:
  /// Throws std::invalid_argument for what ViewedStack refuses but flakes that lean, and for smooth
  /// interfaces, delta flakes and substrates that mirror: no walk towards w_o finds a delta.
  explicit LitStack(const Stack& stack, const WalkLimits& limits = {});
  ~LitStack();
  LitStack(LitStack&&) noexcept;

  [[nodiscard]] bool transmits() const;
  /// As that of ViewedStack.
  [[nodiscard]] double uncollided(Direction w) const;
  /// An unbiased estimate of f(w_i, w_o) [1/sr], by the walk of that number. Directions are unit,
  /// mu != 0; from below only where the stack transmits.
  [[nodiscard]] Rgb f(Direction wi, Direction wo, std::uint64_t seed, std::uint64_t number) const;

 private:
  struct Content;
  std::unique_ptr<const Content> content_;
};

/// Whether flakes of the stack are one-sided and lean: light and viewer cannot be exchanged.
[[nodiscard]] bool has_leaning_flakes(const Stack& stack);

}  // namespace lamella
