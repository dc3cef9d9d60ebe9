#include "volume/interfaces/exit_paths.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

void clear_segments(ExitPaths::Segments& s) {
  for (auto* v : {&s.x, &s.y, &s.z, &s.through, &s.rate}) v->clear();
  s.target.clear();
  s.mirrors.clear();
  s.mirrored.clear();
}

// Ways that have been reflected end by roulette below this share of the light.
constexpr double kFaint = 0.02;

}  // namespace

void ExitPaths::clear() {
  for (Segments& s : layers_) clear_segments(s);
  clear_segments(substrate_);
  random_ = false;
}

void ExitPaths::add(Segments& to, const Way& way, double rate, int target) const {
  to.x.push_back(way.w.x);
  to.y.push_back(way.w.y);
  to.z.push_back(way.w.z);
  to.through.push_back(way.through);
  to.rate.push_back(rate);
  to.target.push_back(target);
  if (!mirrors_) return;
  to.mirrors.push_back(way.mirrors);
  to.mirrored.push_back(way.mirrored);
}

bool ExitPaths::mirror(Way& way, RandomStream& stream) const {
  const auto sample = stack_.law->sample(way.w, stream);
  if (!sample) return false;
  ++way.mirrors;
  for (int c = 0; c < 3; ++c) way.mirrored[c] *= sample->weight[c];
  way.w.z = -way.w.z;
  return *std::max_element(way.mirrored.begin(), way.mirrored.end()) > 0;
}

void ExitPaths::trace(Direction wo, int target, RandomStream& stream) {
  const int n = stack_.count();
  Way way{.w = wo};
  int boundary = wo.z > 0 ? 0 : n;
  bool reflected = false;
  for (bool outside = true;; outside = false) {
    if (boundary == n && stack_.has_substrate && way.w.z > 0) {
      if (!mirrors_) {
        add(substrate_, way, 0, target);
        return;
      }
      if (!mirror(way, stream)) return;
      reflected = true;
    } else if (const auto& interface = stack_.boundaries[boundary]) {
      const bool by_chance = !outside || !interface->is_smooth();
      random_ = random_ || by_chance;
      const Dielectric::Scattered scattered =
          outside ? interface->enter(way.w, stream) : interface->scatter(way.w, stream);
      if (!(scattered.kept > 0)) return;
      const double step = interface->index(way.w) / interface->index(scattered.wo);
      way.through *= scattered.kept * step * step;
      reflected = reflected || scattered.wo.z * way.w.z > 0;
      way.w = -scattered.wo;
    }
    const int layer = way.w.z > 0 ? boundary : boundary - 1;
    if (layer < 0 || layer >= n) return;
    const WalkLayer& l = stack_.layers[layer];
    const double rate = l.depth > 0 ? sigma(*l.medium, -way.w) / std::abs(way.w.z) : 0;
    add(layers_[layer], way, rate, target);
    if (rate > 0) way.through *= std::exp(-rate * l.depth);
    const double left = way.through * *std::max_element(way.mirrored.begin(), way.mirrored.end());
    if (!(left > 0)) return;
    if (reflected && left < kFaint) {
      random_ = true;
      if (stream.uniform() * kFaint >= left) return;
      way.through *= kFaint / left;
    }
    boundary = way.w.z > 0 ? layer + 1 : layer;
  }
}

}  // namespace lamella
