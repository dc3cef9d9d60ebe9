#include "analytic/rough_surface/beckmann_diffuse.h"

#include <array>
#include <atomic>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>

#include "analytic/model/one_half_space.h"
#include "analytic/model/parameter_infos.h"
#include "analytic/model/stochastic_model.h"
#include "phase/math/sampling.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

// Light that climbs so steeply meets a share of facets below 1e-15: it leaves.
constexpr double kSteepest = -5.8;
constexpr int kMostEvents = 100000;
const double kRootPi = std::sqrt(kPi);

double sine_of(Direction w) { return std::min(1.0, std::sqrt(w.x * w.x + w.y * w.y)); }

/// mu / (alpha s): the steepest slope that faces w, in units of alpha.
double slope_limit(Direction w, double alpha) {
  const double width = alpha * sine_of(w);
  return width > 0 ? w.z / width : std::copysign(std::numeric_limits<double>::infinity(), w.z);
}

/// One event: `order` counted along its walk. It lies at a depth t that is distributed by
/// rate exp(-rate (t - from)), t > from (down), or rate exp(-rate (from - t)), 0 < t < from (up);
/// depth in units of minus the log of the share of heights below.
struct Event {
  Direction normal;
  double rate, from;
  bool up, first;
  bool met = true;  ///< false: the walk left before it; its chance counts all the same
};

/// Mean of exp(-b t) / mu over the event's depth, where light along w, of cosine mu, loses
/// b = area / mu per depth on its way out. Finite for mu -> 0.
double escape(const Event& e, double area, double mu) {
  const double b = area / mu;
  if (!e.up) return e.rate / (e.rate * mu + area) * std::exp(-b * e.from);
  const double x = std::abs(b - e.rate) * e.from;
  const double low = std::exp(-std::min(b, e.rate) * e.from);
  if (x < 1e-9) return e.rate * e.from / mu * low;
  return e.rate * low * -std::expm1(-x) / std::abs(area - e.rate * mu);
}

/// All events of the walks from one direction; `first`: the number of the first of them.
std::vector<Event> walk(Direction wi, double alpha, int first, int walks, std::uint64_t seed) {
  std::vector<Event> events;
  for (int k = first; k < first + walks; ++k) {
    RandomStream stream(seed, static_cast<std::uint64_t>(k), StreamPurpose::model);
    Direction d = -wi;
    double depth = 0;
    for (int order = 1;; ++order) {
      if (order > kMostEvents)
        throw std::domain_error(
            "beckmann_diffuse: a walk of more than 100000 events; allowed: alpha up to 10");
      const bool up = d.z > 0;
      if (up && slope_limit(-d, alpha) < kSteepest) break;
      const double rate = beckmann_projected_area(-d, alpha) / std::abs(d.z);
      if (!(rate > 0)) break;
      const double u1 = stream.uniform(), u2 = stream.uniform();
      const Direction m = beckmann_visible_normal(-d, alpha, u1, u2);
      events.push_back({m, rate, depth, up, order == 1});
      const double step = stream.exponential() / rate;
      if (up && step >= depth) {
        events.back().met = false;
        break;
      }
      depth += up ? -step : step;
      const double v1 = stream.uniform(), v2 = stream.uniform();
      d = with_grazing_limit(cosine_hemisphere(m, v1, v2));
    }
  }
  return events;
}

class BeckmannDiffuse final : public StochasticModel {
 public:
  BeckmannDiffuse(Rgb albedo, double alpha, int walks, std::uint64_t seed, int first = 0)
      : StochasticModel(4),
        albedo_(albedo),
        alpha_(alpha),
        first_(first),
        walks_(walks),
        seed_(seed),
        id_(next_id()) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    std::array<Rgb, 4> lobes;
    eval_lobes(wi, wo, lobes);
    return lobes[static_cast<std::size_t>(lobe)];
  }

  void eval_lobes(Direction wi, Direction wo, std::span<Rgb> values) const override {
    std::fill(values.begin(), values.end(), Rgb());
    gather(wi, wo, [&](int order, Rgb f, bool) { values[std::min(order, 4) - 1] += f; });
  }

  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override {
    Rgb sum;
    gather(wi, wo, [&](int, Rgb f, bool) { sum += f; });
    return sum;
  }

  [[nodiscard]] ValueWithError eval_with_error(Direction wi, Direction wo) const override {
    return of_orders(wi, wo, 1, kMostEvents);
  }
  [[nodiscard]] ValueWithError eval_lobe_with_error(int lobe, Direction wi,
                                                    Direction wo) const override {
    return of_orders(wi, wo, lobe + 1, lobe == 3 ? kMostEvents : lobe + 1);
  }

  /// By the same walks: albedo to the power of the events.
  [[nodiscard]] std::vector<std::unique_ptr<Model>> split(int parts) const override {
    std::vector<std::unique_ptr<Model>> list;
    parts = std::min(parts, walks_);
    for (int k = 0; k < parts; ++k) {
      const auto before = [&](int part) {
        return static_cast<int>(static_cast<std::int64_t>(walks_) * part / parts);
      };
      list.push_back(std::make_unique<BeckmannDiffuse>(albedo_, alpha_, before(k + 1) - before(k),
                                                       seed_, first_ + before(k)));
    }
    return list;
  }

  [[nodiscard]] AlbedoEstimate albedo_with_error(Direction wi) const override {
    if (wi.z < 0) return {};
    if (alpha_ == 0) return exact_albedo(albedo_);
    Rgb sum, squares;
    const std::vector<Event>& events = events_from(with_grazing_limit(wi));
    Rgb weight;
    for (std::size_t k = 0; k < events.size(); ++k) {
      if (events[k].first) weight = Rgb(1);
      if (events[k].met) weight = weight * albedo_;
      if (k + 1 < events.size() && !events[k + 1].first) continue;
      sum += weight;
      squares += weight * weight;
    }
    const double n = walks_;
    AlbedoEstimate albedo{1 / n * sum, {}, {}};
    for (int c = 0; c < 3; ++c)
      albedo.error[c] =
          walks_ > 1 ? std::sqrt(std::max(0.0, squares[c] / n - albedo.value[c] * albedo.value[c]) /
                                 (n - 1))
                     : std::numeric_limits<double>::infinity();
    return albedo;
  }

 private:
  /// What the orders from `least` to `most` add up to.
  [[nodiscard]] ValueWithError of_orders(Direction wi, Direction wo, int least, int most) const {
    // Per walk; gather gives shares of the mean.
    Rgb sum, squares, one;
    gather(wi, wo, [&](int order, Rgb f, bool first) {
      if (first) {
        squares += one * one;
        one = Rgb();
      }
      if (order < least || order > most) return;
      sum += f;
      one += f;
    });
    squares += one * one;
    ValueWithError value{sum, Rgb()};
    const double n = walks_;
    for (int c = 0; c < 3; ++c)
      value.standard_error[c] =
          walks_ > 1 ? std::sqrt(std::max(0.0, squares[c] - sum[c] * sum[c] / n) * n / (n - 1))
                     : std::numeric_limits<double>::infinity();
    return value;
  }

  static std::uint64_t next_id() {
    static std::atomic<std::uint64_t> id = 0;
    return ++id;
  }

  /// The events of the walks from a direction; each thread keeps those of the last one it asked
  /// for.
  [[nodiscard]] const std::vector<Event>& events_from(Direction wi) const {
    struct Cache {
      std::uint64_t id = 0;
      Direction wi{};
      std::vector<Event> events;
    };
    thread_local Cache cache;
    if (cache.id != id_ || !(cache.wi == wi)) {
      cache.id = 0;
      cache.events = walk(wi, alpha_, first_, walks_, seed_);
      cache.wi = wi;
      cache.id = id_;
    }
    return cache.events;
  }

  /// Calls add(order, f, first) with every event's share of f; first: of its walk.
  template <class Add>
  void gather(Direction wi, Direction wo, const Add& add) const {
    if (wi.z < 0 || wo.z < 0) return;
    if (alpha_ == 0) return add(1, 1 / kPi * albedo_, true);
    wo = with_grazing_limit(wo);
    const double area = beckmann_projected_area(-wo, alpha_);
    int order = 0;
    Rgb weight;
    for (const Event& e : events_from(with_grazing_limit(wi))) {
      order = e.first ? 1 : order + 1;
      weight = e.first ? 1 / (kPi * walks_) * albedo_ : weight * albedo_;
      const double facing = dot(e.normal, wo);
      add(order, facing > 0 ? facing * escape(e, area, wo.z) * weight : Rgb(), e.first);
    }
  }

  Rgb albedo_;
  double alpha_;
  int first_, walks_;
  std::uint64_t seed_;
  std::uint64_t id_;  // of the cache
};

}  // namespace

double beckmann_projected_area(Direction w, double alpha) {
  const double x = slope_limit(w, alpha);
  if (std::isinf(x)) return std::max(0.0, w.z);
  const double area = 0.5 * (w.z * std::erfc(-x) + alpha * sine_of(w) * std::exp(-x * x) / kRootPi);
  return std::max(0.0, area);
}

Direction beckmann_visible_normal(Direction w, double alpha, double u1, double u2) {
  // Slopes p along w and q across, in units of alpha: density of p proportional to
  // (mu - alpha s p) exp(-p^2), p below the limit; q normal.
  const double s = sine_of(w), width = alpha * s, limit = slope_limit(w, alpha);
  const double total = beckmann_projected_area(w, alpha);
  const auto cdf = [&](double p) {
    return 0.5 * (w.z * std::erfc(-p) + width * std::exp(-p * p) / kRootPi) / total;
  };
  double low = -7, high = std::min(limit, 7.0);
  double p = std::min(0.0, (low + high) / 2);
  for (int k = 0; k < 100 && high - low > 1e-12; ++k) {
    const double error = cdf(p) - u1;
    (error > 0 ? high : low) = p;
    const double slope = (w.z - width * p) * std::exp(-p * p) / (kRootPi * total);
    const double next = p - error / slope;
    const bool inside = next > low && next < high;
    if (inside && std::abs(next - p) < 1e-13) break;
    p = inside ? next : (low + high) / 2;
  }
  const double q = boost::math::erf_inv(2 * u2 - 1);
  const Direction along = s > 0 ? Direction{w.x / s, w.y / s, 0} : Direction{1, 0, 0};
  const Direction across{-along.y, along.x, 0};
  return normalized(-alpha * p * along + -alpha * q * across + Direction{0, 0, 1});
}

ModelInfo beckmann_diffuse_model() {
  return {.name = "beckmann_diffuse",
          .doc = "height field of Lambertian facets with Beckmann's slopes, by random walks",
          .source =
              "Heitz and Dupuy 2015, Implementing a simple anisotropic rough diffuse material with "
              "stochastic evaluation; Heitz, Hanika, d'Eon and Dachsbacher 2016",
          .parameters = {albedo_parameter("albedo of the facets"),
                         {.name = "alpha",
                          .unit = "1",
                          .doc = "roughness: root of twice the variance of a slope; 0: Lambert",
                          .default_value = "0.5",
                          .min = 0,
                          .max = 10},
                         number_parameter("walks", "random walks per w_i", "4096", 2, 1e6),
                         number_parameter("seed", "of the random numbers", "1", 0, 0x1p53)},
          .lobes = {{"f1", "one event", Order::one},
                    {"f2", "two events", Order::two},
                    {"f3", "three events", Order::three},
                    {"fm", "four events and more", Order::four_plus}},
          .make =
              [](const Parameters& p, const Stack*) {
                return std::make_unique<BeckmannDiffuse>(
                    p.color("albedo"), p.number("alpha"), static_cast<int>(p.number("walks")),
                    static_cast<std::uint64_t>(p.number("seed")));
              },
          .applies_to = [](const Stack& stack) -> std::optional<Parameters> {
            const GrainGeometry* field = stack.grains();
            if (!field || !field->is_height_field() || field->surface != GrainSurface::lambert)
              return std::nullopt;
            Parameters p;
            p.set("albedo", stack.layers[0].albedo);
            p.set("alpha", field->alpha);
            return p;
          }};
}

}  // namespace lamella
