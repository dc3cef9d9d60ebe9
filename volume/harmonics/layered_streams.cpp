#include "volume/harmonics/layered_streams.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lamella {
namespace {

// The least and the largest projected area, near enough to tell scales.
std::pair<double, double> sigma_range(const Medium& medium) {
  double least = std::numeric_limits<double>::infinity(), largest = 0;
  for (int k = 0; k < 16; ++k)
    for (int p = 0; p < 16; ++p) {
      const double s = sigma(medium, direction_from_mu_phi(-1 + 2 * (k + 0.5) / 16, kPi * p / 8));
      least = std::min(least, s);
      largest = std::max(largest, s);
    }
  return {least, largest};
}

// By how much, per depth, one-sided flakes meet more light from above than from below.
double drift_of(const Layer& layer) { return traits(layer.medium).mean_normal.value.z; }

// Depth of a half space below which nothing is seen any more: what diffusion leaves of light that
// goes down and comes back, where some is absorbed on the way; else what leaves the field even.
// One-sided flakes let light through one way only: by exp(-drift depth) less the other way.
double cut_depth(const Layer& layer, int channel, double least) {
  constexpr double kLengths = 14, kEven = 40, kLongest = 1e4;
  const double absorbed = 1 - layer.albedo[channel];
  const double length = absorbed > 0 ? std::min(1 / std::sqrt(3 * absorbed), kLongest) : 0;
  double depth = std::max(kEven, kLengths * length) / std::max(least, 0.02);
  if (const double drift = std::abs(drift_of(layer)); drift > 0) {
    const double far = kEven / std::max(drift, 1 / kLongest);
    depth = absorbed > 0 ? std::max(kEven / std::max(least, 0.02), std::min(depth, far))
                         : std::max(depth, far);
  }
  return depth;
}

}  // namespace

LayeredStreams::LayeredStreams(const Stack& stack, int channel, double finest, int nodes_per_panel)
    : integrals_(nodes_per_panel), nodes_(nodes_per_panel) {
  for (const Layer& layer : stack.layers) {
    if (layer.interface || layer.depth() == 0) continue;
    const auto [least, largest] = sigma_range(layer.medium);
    const double scale = std::max(largest, 1e-12);
    const bool is_half_space = std::isinf(layer.depth());
    is_cut_ = is_half_space && drift_of(layer) >= 0;
    const double depth = is_half_space ? cut_depth(layer, channel, least) : layer.depth();
    parts_.push_back({&layer, DepthPanels(depth, scale, finest / scale, nodes_per_panel), size_});
    size_ += parts_.back().panels.size();
    block_size_ += parts_.back().panels.kinds().size() *
                   static_cast<std::size_t>(nodes_ * nodes_ + 2 * nodes_ + 1);
  }
}

// Per part and kind of panel: gather, leave, pass, and the share that passes all of it.
void LayeredStreams::prepare(Direction v, double* block, bool within) const {
  for (const Part& part : parts_) {
    const double rate = sigma(part.layer->medium, -v) / std::abs(v.z);
    for (const double length : part.panels.kinds()) {
      double* leave = block + nodes_ * nodes_;
      double* pass = leave + nodes_;
      integrals_.at(rate * length, within ? block : nullptr, leave, within ? pass : nullptr);
      pass[nodes_] = std::exp(-rate * length);
      // In units of depth over the cosine, which the source is given per.
      for (int k = within ? 0 : nodes_ * nodes_; k < nodes_ * nodes_ + nodes_; ++k)
        block[k] *= length / std::abs(v.z);
      block += nodes_ * nodes_ + 2 * nodes_ + 1;
    }
  }
}

double LayeredStreams::march(Direction v, const double* block, const double* source, double begin,
                             double* radiance) const {
  const bool up = v.z > 0;
  const std::ptrdiff_t stride = nodes_ * nodes_ + 2 * nodes_ + 1;
  double light = begin;
  std::ptrdiff_t before = up ? static_cast<std::ptrdiff_t>(block_size_) : 0;
  for (std::size_t step = 0; step < parts_.size(); ++step) {
    const Part& part = parts_[up ? parts_.size() - 1 - step : step];
    const std::ptrdiff_t of_part = stride * static_cast<std::ptrdiff_t>(part.panels.kinds().size());
    if (up) before -= of_part;
    const int panels = part.panels.panels();
    for (int s = 0; s < panels; ++s) {
      const int panel = up ? panels - 1 - s : s;
      const double* gather = block + before + stride * part.panels.kind(panel);
      const double* leave = gather + nodes_ * nodes_;
      const double* pass = leave + nodes_;
      const int first = part.first + panel * nodes_;
      // Along the way of the light the nodes come in this order or in the other.
      const auto node = [&](int i) { return up ? first + nodes_ - 1 - i : first + i; };
      if (radiance)
        for (int i = 0; i < nodes_; ++i) {
          double sum = pass[i] * light;
          for (int j = 0; j < nodes_; ++j) sum += gather[j * nodes_ + i] * source[node(j)];
          radiance[node(i)] = sum;
        }
      light *= pass[nodes_];
      for (int j = 0; j < nodes_; ++j) light += leave[j] * source[node(j)];
    }
    if (!up) before += of_part;
  }
  return light;
}

double LayeredStreams::crossing(Direction v) const {
  double tau = 0;
  for (const Part& part : parts_)
    tau += sigma(part.layer->medium, -v) / std::abs(v.z) * part.panels.depth();
  return std::exp(-tau);
}

double LayeredStreams::beam(Direction w, double* share) const {
  const bool down = w.z > 0;
  double tau = 0;
  for (std::size_t step = 0; step < parts_.size(); ++step) {
    const Part& part = parts_[down ? step : parts_.size() - 1 - step];
    const double rate = sigma(part.layer->medium, w) / std::abs(w.z);
    const double depth = part.panels.depth();
    for (int k = 0; k < part.panels.size(); ++k) {
      const double place = part.panels.place(k);
      share[part.first + k] = std::exp(-tau - rate * (down ? place : depth - place));
    }
    tau += rate * depth;
  }
  return std::exp(-tau);
}

}  // namespace lamella
