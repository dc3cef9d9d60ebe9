#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "analytic/model/model.h"
#include "phase/stack/stack.h"
#include "volume/plan/plan.h"
#include "volume/run/viewed_walk.h"

namespace lamella {

/// What a surface does with light, seen from w_o.
struct Scattered {
  /// The aimed share of f(w_i, w_o), or an unbiased estimate of it: q / (q + d) of the light, q the
  /// density with which w_i was drawn, d that of `next` along the same path.
  Rgb f{};
  /// The path's next direction.
  struct Next {
    Direction wi;
    Rgb weight;  ///< f |mu_i| / density
    /// [1/sr] of this direction, or what stands for it; nothing: no estimate of f has this light.
    std::optional<double> density;
    /// It goes on along -w_o, as the light that `uncollided` has.
    bool straight = false;
  };
  std::optional<Next> next{};
};

/// A surface for path tracing; any thread. Both strategies, aiming at w_i and following `next`,
/// are combined by weights that depend on the path alone, so the densities need not be true ones:
/// each is that of `next` where it is known, else a number that both share.
class SurfaceScatter {
 public:
  virtual ~SurfaceScatter() = default;
  /// Light from both sides matters; else the surface is the same seen from either.
  [[nodiscard]] virtual bool transmits() const = 0;
  /// The share of light from w that passes without an event, whose directions `scatter` marks as
  /// straight; 0 where it marks none.
  [[nodiscard]] virtual double uncollided(double u, double v, Direction w) const = 0;
  /// u, v: the place on the maps. aim: nullptr where nothing is aimed at. Directions are unit, in
  /// the frame of the surface. number: of the walk, different for every call.
  [[nodiscard]] virtual Scattered scatter(double u, double v, Direction wo, const LightAim* aim,
                                          std::uint64_t seed, std::uint64_t number) const = 0;
};

/// The truth, by one walk per call from the viewer, or where the stack is not reciprocal by two
/// from the light (volume/run/viewed_walk.h). A stack with maps has the stack of the nearest of the
/// places of a PlaceGrid, and is taken as reciprocal where 16 x 16 places are. Throws UsageError
/// for stacks that cannot be walked so.
struct StackOfPlaces {
  int columns = 1, rows = 1;                      ///< texels of the finest map along u and v
  std::function<Stack(double u, double v)> at{};  ///< in [0, 1]
};
[[nodiscard]] std::unique_ptr<SurfaceScatter> walked_surface(StackOfPlaces stack,
                                                             const WalkLimits& limits);

/// A closed form. `model` must outlive the surface.
[[nodiscard]] std::unique_ptr<SurfaceScatter> closed_surface(const Model& model, bool transmits);

/// A closed form whose parameters vary over the surface: that of the nearest place, as above.
struct ModelOfPlaces {
  int columns = 1, rows = 1;
  std::function<std::unique_ptr<Model>(double u, double v)> at{};  ///< in [0, 1]; any thread
};
[[nodiscard]] std::unique_ptr<SurfaceScatter> closed_surface(ModelOfPlaces model, bool transmits);

/// f by any function of w_o and then w_i, in reflection, with a mirrored share or none. Samples by
/// the cosine.
[[nodiscard]] std::unique_ptr<SurfaceScatter> tabulated_surface(
    std::function<std::function<Rgb(Direction)>(Direction wo)> towards,
    std::function<Rgb(Direction wo)> specular);

/// The same where f varies over the surface.
struct TableOfPlaces {
  std::function<std::function<Rgb(Direction wi)>(double u, double v, Direction wo)> towards{};
  std::function<Rgb(double u, double v, Direction wo)> specular{};  ///< absent: none
};
[[nodiscard]] std::unique_ptr<SurfaceScatter> tabulated_surface(TableOfPlaces table);

}  // namespace lamella
