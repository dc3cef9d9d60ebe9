#include "volume/interfaces/exit_paths.h"

#include <cmath>

namespace lamella {
namespace {

void clear_segments(ExitPaths::Segments& s) {
  for (auto* v : {&s.x, &s.y, &s.z, &s.through, &s.rate}) v->clear();
  s.target.clear();
}

void add(ExitPaths::Segments& s, Direction w, double through, double rate, int target) {
  s.x.push_back(w.x);
  s.y.push_back(w.y);
  s.z.push_back(w.z);
  s.through.push_back(through);
  s.rate.push_back(rate);
  s.target.push_back(target);
}

// Ways that have been reflected end by roulette below this share of the light.
constexpr double kFaint = 0.02;

}  // namespace

void ExitPaths::clear() {
  for (Segments& s : layers_) clear_segments(s);
  clear_segments(substrate_);
  random_ = false;
}

void ExitPaths::trace(Direction wo, int target, RandomStream& stream) {
  const int n = stack_.count();
  Direction w = wo;  // of the light: the ray from the outside travels along -w
  int boundary = w.z > 0 ? 0 : n;
  double through = 1;
  bool reflected = false;
  for (bool outside = true;; outside = false) {
    if (boundary == n && stack_.has_substrate && w.z > 0) {
      add(substrate_, w, through, 0, target);
      return;
    }
    if (const auto& interface = stack_.boundaries[boundary]) {
      const bool by_chance = !outside || !interface->is_smooth();
      random_ = random_ || by_chance;
      const Dielectric::Scattered scattered =
          outside ? interface->enter(w, stream) : interface->scatter(w, stream);
      if (!(scattered.kept > 0)) return;
      const double step = interface->index(w) / interface->index(scattered.wo);
      through *= scattered.kept * step * step;
      reflected = reflected || scattered.wo.z * w.z > 0;
      w = -scattered.wo;
    }
    const int layer = w.z > 0 ? boundary : boundary - 1;
    if (layer < 0 || layer >= n) return;
    const WalkLayer& l = stack_.layers[layer];
    const double rate = l.depth > 0 ? sigma(*l.medium, -w) / std::abs(w.z) : 0;
    add(layers_[layer], w, through, rate, target);
    if (rate > 0) through *= std::exp(-rate * l.depth);
    if (!(through > 0)) return;
    if (reflected && through < kFaint) {
      if (stream.uniform() * kFaint >= through) return;
      through = kFaint;
    }
    boundary = w.z > 0 ? layer + 1 : layer;
  }
}

}  // namespace lamella
