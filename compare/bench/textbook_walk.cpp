#include "compare/bench/textbook_walk.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "compare/bench/textbook_parts.h"
#include "phase/medium/vmf.h"
#include "phase/random/block_random.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

using namespace textbook;

constexpr int kWeightedEvents = TextbookCase{}.weighted_events;
constexpr double kNothing = 1e-9;  // a weight that is not followed any more

// The generator of the engine's lanes: a stream per walk.
struct EngineNumbers {
  std::uint64_t seed;
  WalkNumbers<std::uint32_t> numbers{};

  double uniform() { return (numbers.next() + 0.5) * 0x1p-32; }
  void begin_walk(std::uint64_t walk) {
    RandomStream stream(seed, walk, StreamPurpose::walk);
    WordBlock<std::uint32_t> state;
    for (std::uint32_t& word : state.w) word = stream.bits();
    numbers = WalkNumbers<std::uint32_t>(state);
  }
};

// A medium: sigma of the free flight (a majorant for null collisions), `hit` (whether a collision
// is real; prepares the event), `aim` (what densities need besides), the event's density and its
// sample.
struct LambertSpheres {
  struct Event {};
  static double majorant(Direction) { return 1; }
  static double out_sigma(Direction) { return 1; }
  static bool hit(Direction, Event&, auto&) { return true; }
  static void aim(Direction, Event&) {}
  static double density(Direction wi, const Event&, Direction wo) {
    const double cosine = std::clamp(-dot(wi, wo), -1.0, 1.0);
    const double theta = std::acos(cosine);
    return 2 * (std::sqrt(1 - cosine * cosine) - theta * cosine) / (3 * kPi * kPi);
  }
  static Direction sample(Direction wi, const Event&, auto& rng) {
    return from_lambert_sphere(wi, rng);
  }
};

struct HenyeyGreensteins {
  double g;

  struct Event {};
  static double majorant(Direction) { return 1; }
  static double out_sigma(Direction) { return 1; }
  static bool hit(Direction, Event&, auto&) { return true; }
  static void aim(Direction, Event&) {}
  double density(Direction wi, const Event&, Direction wo) const {
    const double base = 1 + g * g + 2 * g * dot(wi, wo);
    return (1 - g * g) / (4 * kPi * base * std::sqrt(base));
  }
  Direction sample(Direction wi, const Event&, auto& rng) const {
    const double q = (1 - g * g) / (1 - g + 2 * g * rng.uniform());
    return around(-wi, (1 + g * g - q * q) / (2 * g), rng.uniform());
  }
};

// Surface-like S = diag(alpha^2, alpha^2, 1).
struct SggxFlakes {
  double xx, yy, zz;

  double out_sigma(Direction w) const {
    return std::sqrt(xx * w.x * w.x + yy * w.y * w.y + zz * w.z * w.z);
  }
  double majorant(Direction w) const { return out_sigma(w); }
  // Heitz et al. 2015, the listing of its supplement for a general S.
  Direction visible_normal(Direction wi, auto& rng) const {
    const double r = std::sqrt(rng.uniform()), phi = 2 * kPi * rng.uniform();
    const double u = r * std::cos(phi), v = r * std::sin(phi);
    const double w = std::sqrt(std::max(0.0, 1 - u * u - v * v));
    const Direction k = from_frame(wi, 1, 0, 0), j = from_frame(wi, 0, 1, 0);
    const auto product = [this](Direction a, Direction b) {
      return a.x * b.x * xx + a.y * b.y * yy + a.z * b.z * zz;
    };
    const double kk = product(k, k), jj = product(j, j), ii = product(wi, wi);
    const double kj = product(k, j), ki = product(k, wi), ji = product(j, wi);
    const double determinant = std::sqrt(
        std::abs(kk * jj * ii - kj * kj * ii - ki * ki * jj - ji * ji * kk + 2 * kj * ki * ji));
    const double inverse = 1 / std::sqrt(ii), area = std::sqrt(jj * ii - ji * ji);
    const Direction local{
        u * determinant / area - v * inverse * (ki * ji - kj * ii) / area + w * inverse * ki,
        v * inverse * area + w * inverse * ji, w * inverse * ii};
    const Direction n = normalized(local);
    return normalized(n.x * k + n.y * j + n.z * wi);
  }
};

struct SggxMirrors : SggxFlakes {
  struct Event {};
  static bool hit(Direction, Event&, auto&) { return true; }
  static void aim(Direction, Event&) {}
  double density(Direction wi, const Event&, Direction wo) const {
    const Direction m = normalized(wi + wo);
    const double q = m.x * m.x / xx + m.y * m.y / yy + m.z * m.z / zz;
    return 1 / (kPi * std::sqrt(xx * yy * zz) * q * q) / (4 * out_sigma(wi));
  }
  Direction sample(Direction wi, const Event&, auto& rng) const {
    return mirrored_at(visible_normal(wi, rng), wi);
  }
};

struct SggxLambertians : SggxFlakes {
  struct Event {
    Direction normal{};
  };
  bool hit(Direction wi, Event& event, auto& rng) const {
    event.normal = visible_normal(wi, rng);
    return true;
  }
  static void aim(Direction, Event&) {}
  static double density(Direction, const Event& event, Direction wo) {
    return cosine_law_density(event.normal, wo);
  }
  static Direction sample(Direction, const Event& event, auto& rng) {
    return cosine_law(event.normal, rng);
  }
};

struct VmfFlakes {
  double alpha, kappa, tail;

  explicit VmfFlakes(double roughness)
      : alpha(vmf_alpha(roughness)), kappa(vmf_concentration(alpha)), tail(std::exp(-2 * kappa)) {}

  struct Event {
    Direction normal{};
    double sigma = 0;
  };
  static double majorant(Direction) { return 1; }
  double out_sigma(Direction w) const { return vmf_sigma(w.z, alpha); }  // set up once
  bool hit(Direction wi, Event& event, auto& rng) const {
    const double u = rng.uniform();
    const double cosine = 1 + std::log(u + (1 - u) * tail) / kappa;
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const double phi = 2 * kPi * rng.uniform();
    event.normal = {sine * std::cos(phi), sine * std::sin(phi), cosine};
    return rng.uniform() < dot(wi, event.normal);
  }
};

struct VmfLambertians : VmfFlakes {
  using VmfFlakes::VmfFlakes;
  static void aim(Direction, Event&) {}
  static double density(Direction, const Event& event, Direction wo) {
    return cosine_law_density(event.normal, wo);
  }
  static Direction sample(Direction, const Event& event, auto& rng) {
    return cosine_law(event.normal, rng);
  }
};

struct VmfMirrors : VmfFlakes {
  static constexpr int kSteps = 512;
  std::array<double, kSteps + 1> sigmas;  // at equal steps of the cosine

  explicit VmfMirrors(double roughness) : VmfFlakes(roughness) {
    for (int k = 0; k <= kSteps; ++k) sigmas[k] = vmf_sigma(2.0 * k / kSteps - 1, alpha);
  }
  void aim(Direction wi, Event& event) const {
    const double at = (wi.z + 1) / 2 * kSteps;
    const int k = std::clamp(static_cast<int>(at), 0, kSteps - 1);
    event.sigma = sigmas[k] + (at - k) * (sigmas[k + 1] - sigmas[k]);
  }
  double density(Direction wi, const Event& event, Direction wo) const {
    return vmf_density(kappa, normalized(wi + wo).z) / (4 * event.sigma);
  }
  static Direction sample(Direction wi, const Event& event, auto&) {
    return mirrored_at(event.normal, wi);
  }
};

std::atomic<std::uint64_t> media_made{0};

template <class F>
auto with_medium(const TextbookCase& what, const F& f) {
  const double p = what.parameter;
  ++media_made;
  switch (what.medium) {
    case TextbookMedium::sggx_mirror:
      return f(SggxMirrors{{p * p, p * p, 1}});
    case TextbookMedium::sggx_lambert:
      return f(SggxLambertians{{p * p, p * p, 1}});
    case TextbookMedium::vmf_lambert:
      return f(VmfLambertians(p));
    case TextbookMedium::vmf_mirror:
      return f(VmfMirrors(p));
    case TextbookMedium::henyey_greenstein:
      return f(HenyeyGreensteins{p});
    default:
      return f(LambertSpheres{});
  }
}

}  // namespace

std::uint64_t textbook_media_made() { return media_made; }

double TextbookResult::reflected_error() const {
  const double n = static_cast<double>(walks), mean = reflected / n;
  return std::sqrt(std::max(0.0, reflected2 / n - mean * mean) / n);
}

template <bool kUsual, class Medium, class Generator>
void TextbookWalk::loop(const Medium& medium, Generator& rng, std::uint64_t walks) {
  const double depth = case_.depth, albedo = case_.albedo;
  const int weighted = kUsual ? kWeightedEvents : case_.weighted_events;
  const std::size_t points = points_.size();
  std::vector<double> f(points);  // of the walk at hand
  std::uint64_t collisions = 0;
  for (std::uint64_t walk = 0; walk < walks; ++walk) {
    rng.begin_walk(result_.walks + walk);
    Direction wi = wi_;
    double y = 0, weight = 1;  // depth below the top
    std::fill(f.begin(), f.end(), 0.0);
    for (int events = 0;;) {
      y += -std::log(rng.uniform()) * wi.z / medium.majorant(wi);
      if (y < 0 || y > depth) break;
      typename Medium::Event event;
      if (!medium.hit(wi, event, rng)) continue;
      ++collisions;
      ++events;
      if (points > 0) medium.aim(wi, event);
      for (std::size_t j = 0; j < points; ++j)
        f[j] += weight * albedo * medium.density(wi, event, points_[j]) * std::exp(-y * rate_[j]) /
                points_[j].z;
      if (events <= weighted) {
        weight *= albedo;
        if (!kUsual && weight < kNothing) {
          weight = 0;
          break;
        }
      } else if (rng.uniform() >= albedo) {
        weight = 0;
        break;
      }
      wi = -medium.sample(wi, event, rng);
    }
    for (std::size_t j = 0; j < points; ++j) {
      result_.f[j] += f[j];
      result_.f2[j] += f[j] * f[j];
    }
    // What passed without a collision counts as transmitted, too.
    if (y > 0) {
      result_.transmitted += weight;
      continue;
    }
    result_.reflected += weight;
    result_.reflected2 += weight * weight;
    if (tally_ == TextbookTally::cells && weight > 0) {
      const double value = weight * kCellsPerSteradian;
      const int cell = cell_of(wi);
      result_.f[cell] += value;
      result_.f2[cell] += value * value;
    }
  }
  result_.walks += walks;
  result_.collisions += collisions;
}

template <class Medium>
void TextbookWalk::walk_in(Medium medium, std::uint64_t walks) {
  if (generator_ == TextbookGenerator::engine) {
    EngineNumbers rng{seed_};
    return loop<true>(medium, rng, walks);
  }
  Pcg32 rng{state_, increment_};
  if (case_.weighted_events == kWeightedEvents)
    loop<true>(medium, rng, walks);
  else
    loop<false>(medium, rng, walks);
  state_ = rng.state;
}

TextbookWalk::TextbookWalk(const TextbookCase& what, Direction wi, TextbookTally tally,
                           std::vector<Direction> points, std::uint64_t seed,
                           TextbookGenerator generator)
    : case_(what),
      wi_(wi),
      tally_(tally),
      points_(std::move(points)),
      generator_(generator),
      seed_(seed),
      state_(seed * 0x9E3779B97F4A7C15ULL),
      increment_(2 * seed + 1) {
  const std::size_t targets = tally == TextbookTally::cells ? kMuCells * kPhiCells : points_.size();
  result_.f.resize(targets);
  result_.f2.resize(targets);
  advance_ = with_medium(
      case_, [&](const auto& medium) -> std::function<void(TextbookWalk&, std::uint64_t)> {
        for (const Direction wo : points_) rate_.push_back(medium.out_sigma(-wo) / wo.z);
        return [medium](TextbookWalk& self, std::uint64_t more) { self.walk_in(medium, more); };
      });
}

void TextbookWalk::advance(std::uint64_t walks) { advance_(*this, walks); }

const char* describe(TextbookMedium medium) {
  switch (medium) {
    case TextbookMedium::sggx_mirror:
      return "textbook loop: pcg32, visible normals in a frame (Heitz 2015)";
    case TextbookMedium::sggx_lambert:
      return "textbook loop: pcg32, visible normals in a frame (Heitz 2015), cosine law";
    case TextbookMedium::vmf_lambert:
      return "textbook loop: pcg32, null collisions";
    case TextbookMedium::vmf_mirror:
      return "textbook loop: pcg32, null collisions, sigma from a table";
    case TextbookMedium::henyey_greenstein:
      return "textbook loop: pcg32, inverse cosine, frame";
    default:
      return "textbook loop: pcg32, three-uniform cosine, frame";
  }
}

}  // namespace lamella
