#include "compare/render/surface_scatter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/render/place_grid.h"
#include "compare/request/errors.h"
#include "phase/math/sampling.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

// What of light that was drawn with one density is aimed, where paths find it with the other.
double aimed_share(double aimed, double path) { return aimed / (aimed + path); }

bool is_reciprocal(const Stack& stack) {
  if (has_leaning_flakes(stack)) return false;
  if (!stack.substrate || stack.substrate->model.empty()) return true;
  const ModelInfo* form = find_model(stack.substrate->model);
  return !form || form->reciprocal;
}

// Places along each side of a map that are asked whether the stack is reciprocal there.
constexpr int kAskedPlaces = 16;

bool is_reciprocal(const StackOfPlaces& stack) {
  const int columns = std::min(stack.columns, kAskedPlaces),
            rows = std::min(stack.rows, kAskedPlaces);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      if (!is_reciprocal(stack.at((column + 0.5) / columns, (row + 0.5) / rows))) return false;
  return true;
}

class WalkedSurface final : public SurfaceScatter {
 public:
  WalkedSurface(StackOfPlaces stack, const WalkLimits& limits)
      : stack_(std::move(stack)),
        places_(stack_.columns, stack_.rows, [this, limits](double u, double v) {
          return std::make_unique<ViewedStack>(stack_.at(u, v), limits);
        }) {
    // Refuses early, and knows the sides: those of a map's stacks are the same everywhere.
    transmits_ = places_.at(0.5, 0.5).transmits();
  }

  [[nodiscard]] bool transmits() const override { return transmits_; }

  [[nodiscard]] Scattered scatter(double u, double v, Direction wo, const LightAim* aim,
                                  std::uint64_t seed, std::uint64_t number) const override {
    const ViewedLight light = places_.at(u, v).follow(wo, aim, seed, number);
    Scattered out{light.f, {}};
    if (const auto& left = light.departure)
      out.next = Scattered::Next{left->wi, left->weight, left->density, left->straight};
    return out;
  }

  [[nodiscard]] double uncollided(double u, double v, Direction w) const override {
    return places_.at(u, v).uncollided(w);
  }

 private:
  StackOfPlaces stack_;
  PlaceGrid<ViewedStack> places_;
  bool transmits_ = false;
};

// Uniforms of a closed form's sample.
RandomStream sample_stream(std::uint64_t seed, std::uint64_t number) {
  return {seed, number, StreamPurpose::model};
}

Direction cosine_direction(RandomStream& stream, bool up) {
  Direction w = cosine_hemisphere(Direction{0, 0, 1}, stream.uniform(), stream.uniform());
  w.z = std::max(w.z, 1e-9);
  if (!up) w.z = -w.z;
  return w;
}

// Shares of a closed form's samples that are drawn by the cosine, on w_o's side and beyond.
constexpr double kCosineShare = 0.2, kBeyondShare = 0.3;

// One sample of a closed form on a surface that lets light pass or not.
Scattered scatter_by(const Model& model, bool transmits, Direction wo, const LightAim* aim,
                     std::uint64_t seed, std::uint64_t number) {
  RandomStream stream = sample_stream(seed, number);
  // Deltas, then the closed form's own sampler, or a cosine on either side: samplers leave out
  // lobes (SpongeCake's multiple scattering) and know one side (facets).
  const Rgb mirror = model.specular(wo);
  const double passes = transmits ? model.uncollided(-wo) : 0;
  const double p_mirror = std::min(0.4, mirror.max()), p_pass = std::min(0.4, passes);
  const double rest = 1 - p_mirror - p_pass;
  const double p_near = kCosineShare * rest, p_far = transmits ? kBeyondShare * rest : 0;
  const double p_model = rest - p_near - p_far;
  const auto density_of = [&](Direction w) {
    const bool beyond = (w.z > 0) != (wo.z > 0);
    return p_model * model.pdf(w, wo) + (beyond ? p_far : p_near) * std::abs(w.z) / kPi;
  };
  Scattered out;
  if (aim) out.f = aimed_share(aim->density, density_of(aim->wi)) * model.eval(aim->wi, wo);
  const double u = stream.uniform();
  if (u < p_mirror) {
    out.next = Scattered::Next{{-wo.x, -wo.y, wo.z}, (1 / p_mirror) * mirror, {}};
  } else if (u < p_mirror + p_pass) {
    // By reciprocity: light from -wo.
    out.next = Scattered::Next{-wo, Rgb(passes / p_pass), {}, true};
  } else {
    std::optional<Direction> w;
    if (u < p_mirror + p_pass + p_model) {
      const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
      w = model.sample(wo, u1, u2, u3);
    } else {
      const bool beyond = u >= p_mirror + p_pass + p_model + p_near;
      w = cosine_direction(stream, (wo.z > 0) != beyond);
    }
    if (!w || w->z == 0) return out;
    const double density = density_of(*w);
    if (density > 0)
      out.next = Scattered::Next{*w, (std::abs(w->z) / density) * model.eval(*w, wo), density};
  }
  return out;
}

// What is not reciprocal, by walks from the light: one for the light that is aimed at, one for the
// direction in which the path goes on, which is drawn by the cosine.
class LitSurface final : public SurfaceScatter {
 public:
  LitSurface(StackOfPlaces stack, const WalkLimits& limits)
      : stack_(std::move(stack)),
        places_(stack_.columns, stack_.rows, [this, limits](double u, double v) {
          return std::make_unique<LitStack>(stack_.at(u, v), limits);
        }) {
    transmits_ = places_.at(0.5, 0.5).transmits();
  }

  [[nodiscard]] bool transmits() const override { return transmits_; }
  [[nodiscard]] double uncollided(double u, double v, Direction w) const override {
    return places_.at(u, v).uncollided(w);
  }

  [[nodiscard]] Scattered scatter(double u, double v, Direction wo, const LightAim* aim,
                                  std::uint64_t seed, std::uint64_t number) const override {
    const LitStack& stack = places_.at(u, v);
    RandomStream stream = sample_stream(seed, number);
    const double passes = stack.uncollided(-wo), p_pass = std::min(0.4, passes);
    const double p_side = (1 - p_pass) * (transmits_ ? 0.5 : 1);
    const auto density_of = [&](Direction w) { return p_side * std::abs(w.z) / kPi; };
    Scattered out;
    if (aim && (transmits_ || aim->wi.z > 0))
      out.f =
          aimed_share(aim->density, density_of(aim->wi)) * stack.f(aim->wi, wo, seed, 2 * number);
    if (stream.uniform() < p_pass) {
      out.next = Scattered::Next{-wo, Rgb(passes / p_pass), {}, true};
    } else {
      const bool beyond = transmits_ && stream.uniform() < 0.5;
      const Direction w = cosine_direction(stream, (wo.z > 0) != beyond);
      const double density = density_of(w);
      out.next = Scattered::Next{
          w, (std::abs(w.z) / density) * stack.f(w, wo, seed, 2 * number + 1), density};
    }
    return out;
  }

 private:
  StackOfPlaces stack_;
  PlaceGrid<LitStack> places_;
  bool transmits_ = false;
};

class ClosedSurface final : public SurfaceScatter {
 public:
  ClosedSurface(const Model& model, bool transmits) : model_(model), transmits_(transmits) {}

  [[nodiscard]] bool transmits() const override { return transmits_; }
  [[nodiscard]] double uncollided(double, double, Direction w) const override {
    return transmits_ ? model_.uncollided(w) : 0;
  }
  [[nodiscard]] Scattered scatter(double, double, Direction wo, const LightAim* aim,
                                  std::uint64_t seed, std::uint64_t number) const override {
    return scatter_by(model_, transmits_, wo, aim, seed, number);
  }

 private:
  const Model& model_;
  bool transmits_;
};

class MappedClosedSurface final : public SurfaceScatter {
 public:
  MappedClosedSurface(ModelOfPlaces model, bool transmits)
      : places_(model.columns, model.rows, std::move(model.at)), transmits_(transmits) {}

  [[nodiscard]] bool transmits() const override { return transmits_; }
  [[nodiscard]] double uncollided(double u, double v, Direction w) const override {
    return transmits_ ? places_.at(u, v).uncollided(w) : 0;
  }
  [[nodiscard]] Scattered scatter(double u, double v, Direction wo, const LightAim* aim,
                                  std::uint64_t seed, std::uint64_t number) const override {
    return scatter_by(places_.at(u, v), transmits_, wo, aim, seed, number);
  }

 private:
  PlaceGrid<Model> places_;
  bool transmits_;
};

class TabulatedSurface final : public SurfaceScatter {
 public:
  explicit TabulatedSurface(TableOfPlaces table) : table_(std::move(table)) {}

  [[nodiscard]] bool transmits() const override { return false; }
  [[nodiscard]] double uncollided(double, double, Direction) const override { return 0; }

  [[nodiscard]] Scattered scatter(double u, double v, Direction wo, const LightAim* aim,
                                  std::uint64_t seed, std::uint64_t number) const override {
    RandomStream stream = sample_stream(seed, number);
    const auto f = table_.towards(u, v, wo);
    const Rgb mirror = table_.specular ? table_.specular(u, v, wo) : Rgb();
    const double p_mirror = std::min(0.5, mirror.max());
    Scattered out;
    if (aim && aim->wi.z > 0)
      out.f = aimed_share(aim->density, (1 - p_mirror) * aim->wi.z / kPi) * f(aim->wi);
    if (stream.uniform() < p_mirror) {
      out.next = Scattered::Next{{-wo.x, -wo.y, wo.z}, (1 / p_mirror) * mirror, {}};
    } else {
      const Direction w = cosine_direction(stream, true);
      out.next = Scattered::Next{w, (kPi / (1 - p_mirror)) * f(w), (1 - p_mirror) * w.z / kPi};
    }
    return out;
  }

 private:
  TableOfPlaces table_;
};

}  // namespace

std::unique_ptr<SurfaceScatter> walked_surface(StackOfPlaces stack, const WalkLimits& limits) {
  try {
    if (!is_reciprocal(stack)) return std::make_unique<LitSurface>(std::move(stack), limits);
    return std::make_unique<WalkedSurface>(std::move(stack), limits);
  } catch (const std::invalid_argument& error) {
    throw UsageError(fmt::format("preview --shape: {}", error.what()));
  }
}

std::unique_ptr<SurfaceScatter> closed_surface(const Model& model, bool transmits) {
  return std::make_unique<ClosedSurface>(model, transmits);
}

std::unique_ptr<SurfaceScatter> closed_surface(ModelOfPlaces model, bool transmits) {
  return std::make_unique<MappedClosedSurface>(std::move(model), transmits);
}

std::unique_ptr<SurfaceScatter> tabulated_surface(
    std::function<std::function<Rgb(Direction)>(Direction)> towards,
    std::function<Rgb(Direction)> specular) {
  TableOfPlaces table;
  table.towards = [f = std::move(towards)](double, double, Direction wo) { return f(wo); };
  if (specular)
    table.specular = [f = std::move(specular)](double, double, Direction wo) { return f(wo); };
  return tabulated_surface(std::move(table));
}

std::unique_ptr<SurfaceScatter> tabulated_surface(TableOfPlaces table) {
  return std::make_unique<TabulatedSurface>(std::move(table));
}

}  // namespace lamella
