#include "volume/harmonics/block_transport.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

bool has_mirror_flakes(const Medium& medium) {
  return std::holds_alternative<MirrorFlakes<Sggx>>(medium) ||
         std::holds_alternative<MirrorFlakes<Vmf>>(medium);
}

}  // namespace

BlockTransport::BlockTransport(const Stack& stack, int channel, const LayerKernels& kernels,
                               const HarmonicResolution& resolution)
    : channel_(channel), streams_(stack, channel, resolution.finest, resolution.depth_nodes) {
  for (const LayeredStreams::Part& part : streams_.parts()) {
    resolution.check_stop();
    kernels_.push_back(kernels.of(part.layer->medium, part.layer->f0[channel]));
    mirrors_.push_back(has_mirror_flakes(part.layer->medium));
  }
}

MatrixXd BlockTransport::scattered(const MatrixXd& radiance) const {
  MatrixXd source(radiance.rows(), nodes());
  for (std::size_t p = 0; p < kernels_.size(); ++p) {
    const LayeredStreams::Part& part = streams_.parts()[p];
    source.middleCols(part.first, part.panels.size()) =
        part.layer->albedo[channel_] *
        kernels_[p]->apply(radiance.middleCols(part.first, part.panels.size()));
  }
  return source;
}

MatrixXd BlockTransport::scattered_by_mirrors(const MatrixXd& radiance) const {
  MatrixXd source = MatrixXd::Zero(radiance.rows(), nodes());
  for (std::size_t p = 0; p < kernels_.size(); ++p) {
    if (!mirrors_[p]) continue;
    const LayeredStreams::Part& part = streams_.parts()[p];
    source.middleCols(part.first, part.panels.size()) =
        part.layer->albedo[channel_] *
        kernels_[p]->apply(radiance.middleCols(part.first, part.panels.size()));
  }
  return source;
}

bool BlockTransport::has_mirrors() const {
  return std::find(mirrors_.begin(), mirrors_.end(), true) != mirrors_.end();
}

bool BlockTransport::is_mixed() const {
  return has_mirrors() && std::find(mirrors_.begin(), mirrors_.end(), false) != mirrors_.end();
}

double BlockTransport::collided(Direction v, const double* radiance) const {
  double sum = 0;
  for (const LayeredStreams::Part& part : streams_.parts()) {
    const double share = has_schlick(*part.layer) ? 1 : 1 - part.layer->albedo[channel_];
    const double rate = share * sigma(part.layer->medium, -v);
    if (rate > 0)
      for (int node = 0; node < part.panels.size(); ++node)
        sum += rate * part.panels.weight(node) * radiance[part.first + node];
  }
  return sum;
}

double BlockTransport::sent_by_schlick(const MatrixXd& source) const {
  double sum = 0;
  for (const LayeredStreams::Part& part : streams_.parts())
    if (has_schlick(*part.layer))
      for (int node = 0; node < part.panels.size(); ++node)
        sum += std::sqrt(4 * kPi) * part.panels.weight(node) * source(0, part.first + node);
  return sum;
}

void BlockTransport::beam_source(Direction w, Direction v, const VectorXd& share, VectorXd& source,
                                 double* scattered) const {
  for (std::size_t n = 0; n < streams_.parts().size(); ++n) {
    const LayeredStreams::Part& part = streams_.parts()[n];
    const Layer& layer = *part.layer;
    const PhaseValue f = phase(layer.medium, w, v);
    const double reflected = layer.albedo[channel_] * f.density *
                             (layer.f0[channel_] + (1 - layer.f0[channel_]) * f.schlick);
    scattered[n] = reflected;
    const double per = reflected * sigma(layer.medium, w) / std::abs(w.z);
    source.segment(part.first, part.panels.size()) =
        per * share.segment(part.first, part.panels.size());
  }
}

double BlockTransport::first_absorbed(Direction w, const std::vector<double>& scattered) const {
  const std::vector<LayeredStreams::Part>& parts = streams_.parts();
  const bool down = w.z > 0;
  double before = 1, absorbed = 0;
  for (std::size_t step = 0; step < parts.size(); ++step) {
    const std::size_t n = down ? step : parts.size() - 1 - step;
    const Layer& layer = *parts[n].layer;
    const double x = sigma(layer.medium, w) / std::abs(w.z) * parts[n].panels.depth();
    const double share = has_schlick(layer) ? scattered[n] : layer.albedo[channel_];
    absorbed += (1 - share) * before * -std::expm1(-x);
    before *= std::exp(-x);
  }
  return absorbed;
}

}  // namespace lamella
