#include "volume/harmonics/harmonic_transport.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "phase/medium/lambert_event.h"
#include "volume/harmonics/beam_quadrature.h"
#include "volume/harmonics/gmres.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Fewer cosines lose digits at grazing.
int cosines_for(int degree) { return std::max(32, degree + 8); }
int azimuths_for(int degree) { return 2 * degree + 32; }
// The beam's quadrature, of which every part of a ray is about a right angle long.
int ray_points(int degree) { return std::max(32, degree + 8); }
int rays_for(int degree) { return 2 * degree + 64; }
// Sums over directions are made in this many pieces, whatever the number of threads.
constexpr int kPieces = 32;
constexpr int kMaxIterations = 200;

bool is_mirror(const Medium& medium) {
  return std::holds_alternative<MirrorFlakes<Sggx>>(medium) ||
         std::holds_alternative<MirrorFlakes<Vmf>>(medium);
}

}  // namespace

HarmonicTransport::HarmonicTransport(const Stack& stack, int channel,
                                     const HarmonicResolution& resolution)
    : stack_(stack),
      channel_(channel),
      resolution_(resolution),
      basis_(resolution.degree),
      streams_(stack, channel, resolution.finest, resolution.depth_nodes),
      grid_(SphereGrid::quadrature(basis_, cosines_for(resolution.degree),
                                   azimuths_for(resolution.degree), product())) {
  for (const LayeredStreams::Part& part : streams_.parts()) {
    check_stop();
    kernels_.emplace_back(part.layer->medium, part.layer->f0[channel], basis_, product());
    mirrors_.push_back(is_mirror(part.layer->medium));
  }
  if (stack.substrate) ground_albedo_ = stack.substrate->albedo[channel];
  if (streams_.is_cut()) ground_albedo_ = 1;
  blocks_.resize(streams_.block_size() * static_cast<std::size_t>(grid_.size()));
  tbb::parallel_for(0, grid_.size(), [&](int k) {
    streams_.prepare(grid_.direction(k), &blocks_[streams_.block_size() * k]);
  });
}

HarmonicSource HarmonicTransport::scattered(const MatrixXd& radiance, double arriving) const {
  HarmonicSource next{MatrixXd(basis_.size(), streams_.size()),
                      lambert_radiance(ground_albedo_ * arriving)};
  for (std::size_t p = 0; p < kernels_.size(); ++p) {
    const LayeredStreams::Part& part = streams_.parts()[p];
    next.coefficients.middleCols(part.first, part.panels.size()) =
        part.layer->albedo[channel_] *
        kernels_[p].apply(radiance.middleCols(part.first, part.panels.size()));
  }
  return next;
}

void HarmonicTransport::take_mirrors(const MatrixXd& radiance, HarmonicSource& source) const {
  for (std::size_t p = 0; p < kernels_.size(); ++p) {
    const LayeredStreams::Part& part = streams_.parts()[p];
    if (mirrors_[p])
      source.coefficients.middleCols(part.first, part.panels.size()) -=
          part.layer->albedo[channel_] *
          kernels_[p].apply(radiance.middleCols(part.first, part.panels.size()));
  }
}

// What radiance along v meets in the layers and does not scatter: all of what their albedo tells,
// and, where Schlick's factor takes a share by the angle, all that it meets (see
// scattered_by_mirrors).
double HarmonicTransport::collided(Direction v, const double* radiance) const {
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

// The flux that sources in layers with Schlick's factor send out.
double HarmonicTransport::scattered_by_mirrors(const HarmonicSource& source) const {
  double sum = 0;
  for (const LayeredStreams::Part& part : streams_.parts())
    if (has_schlick(*part.layer))
      for (int node = 0; node < part.panels.size(); ++node)
        sum += std::sqrt(4 * kPi) * part.panels.weight(node) *
               source.coefficients(0, part.first + node);
  return sum;
}

bool HarmonicTransport::has_schlick(const Layer& layer) const { return layer.f0[channel_] != 1; }

HarmonicLight HarmonicTransport::follow(const HarmonicSource& source) const {
  check_stop();
  const MatrixXd values = grid_.values(source.coefficients);
  MatrixXd radiance(streams_.size(), grid_.size());
  VectorXd leaving(grid_.size()), absorbed = VectorXd::Zero(grid_.size());
  tbb::parallel_for(0, grid_.size(), [&](int k) {
    const Direction v = grid_.direction(k);
    leaving[k] = streams_.march(v, &blocks_[streams_.block_size() * k], values.col(k).data(),
                                v.z > 0 ? source.ground : 0, radiance.col(k).data());
    absorbed[k] = collided(v, radiance.col(k).data());
  });
  HarmonicLight light;
  double arriving = 0;
  for (int k = 0; k < grid_.size(); ++k) {
    const double flux = grid_.weight(k) * std::abs(grid_.mu(k)) * leaving[k];
    (grid_.mu(k) > 0 ? light.reflected : arriving) += flux;
    light.absorbed += grid_.weight(k) * absorbed[k];
  }
  if (is_closed())
    light.absorbed += (1 - ground_albedo_) * arriving;
  else
    light.transmitted = arriving;
  light.next = scattered(grid_.coefficients(radiance), arriving);
  light.absorbed -= scattered_by_mirrors(light.next);
  return light;
}

HarmonicTransport::First HarmonicTransport::first(Direction wi) const {
  First result;
  VectorXd share(streams_.size());
  result.uncollided = streams_.beam(wi, share.data());
  const BeamQuadrature beam(-wi, ray_points(basis_.degree()), rays_for(basis_.degree()));
  const int directions = static_cast<int>(beam.directions.size());
  const auto count = std::count(mirrors_.begin(), mirrors_.end(), true);
  const bool is_mixed = count > 0 && count < static_cast<std::ptrdiff_t>(mirrors_.size());
  struct Piece {
    MatrixXd coefficients, of_mirrors;
    double up = 0, down = 0, absorbed = 0;
    std::vector<double> leaving;  // by part: share of what collides
  };
  std::vector<Piece> pieces(kPieces);
  tbb::parallel_for(0, kPieces, [&](int p) {
    const int begin = directions * p / kPieces, end = directions * (p + 1) / kPieces;
    Piece& piece = pieces[p];
    MatrixXd harmonics(basis_.size(), end - begin), radiance(streams_.size(), end - begin);
    MatrixXd of_mirrors(streams_.size(), is_mixed ? end - begin : 0);
    std::vector<double> block(streams_.block_size());
    piece.leaving.assign(streams_.parts().size(), 0);
    VectorXd source(streams_.size()), values(basis_.size());
    for (int k = begin; k < end; ++k) {
      const Direction v = beam.directions[k];
      const double weight = beam.weights[k];
      for (std::size_t n = 0; n < streams_.parts().size(); ++n) {
        const LayeredStreams::Part& part = streams_.parts()[n];
        const Layer& layer = *part.layer;
        const PhaseValue f = phase(layer.medium, wi, v);
        const double reflected = layer.albedo[channel_] * f.density *
                                 (layer.f0[channel_] + (1 - layer.f0[channel_]) * f.schlick);
        piece.leaving[n] += weight * reflected;
        const double per = reflected * sigma(layer.medium, wi) / std::abs(wi.z);
        source.segment(part.first, part.panels.size()) =
            per * share.segment(part.first, part.panels.size());
      }
      streams_.prepare(v, block.data());
      const double leaving =
          streams_.march(v, block.data(), source.data(), 0, radiance.col(k - begin).data());
      (v.z > 0 ? piece.up : piece.down) += weight * std::abs(v.z) * leaving;
      piece.absorbed += weight * collided(v, radiance.col(k - begin).data());
      basis_.values(v, values);
      harmonics.col(k - begin) = weight * values;
      if (!is_mixed) continue;
      for (std::size_t n = 0; n < streams_.parts().size(); ++n) {
        const LayeredStreams::Part& part = streams_.parts()[n];
        if (!mirrors_[n]) source.segment(part.first, part.panels.size()).setZero();
      }
      streams_.march(v, block.data(), source.data(), 0, of_mirrors.col(k - begin).data());
    }
    piece.coefficients = product()(harmonics, radiance.transpose());
    if (is_mixed) piece.of_mirrors = product()(harmonics, of_mirrors.transpose());
  });
  MatrixXd coefficients = MatrixXd::Zero(basis_.size(), streams_.size());
  MatrixXd of_mirrors = MatrixXd::Zero(basis_.size(), is_mixed ? streams_.size() : 0);
  double arriving = 0;
  std::vector<double> leaving(streams_.parts().size(), 0);
  for (const Piece& piece : pieces) {
    for (std::size_t n = 0; n < leaving.size(); ++n) leaving[n] += piece.leaving[n];
    coefficients += piece.coefficients;
    if (is_mixed) of_mirrors += piece.of_mirrors;
    result.light.reflected += piece.up;
    arriving += piece.down;
    result.light.absorbed += piece.absorbed;
  }
  // The first event takes its share of what the beam brings to each layer.
  double before = 1;
  const bool down = wi.z > 0;
  const std::vector<LayeredStreams::Part>& parts = streams_.parts();
  for (std::size_t step = 0; step < parts.size(); ++step) {
    const std::size_t n = down ? step : parts.size() - 1 - step;
    const LayeredStreams::Part& part = parts[n];
    const double x = sigma(part.layer->medium, wi) / std::abs(wi.z) * part.panels.depth();
    const double scattered = has_schlick(*part.layer) ? leaving[n] : part.layer->albedo[channel_];
    result.absorbed += (1 - scattered) * before * -std::expm1(-x);
    before *= std::exp(-x);
  }
  const auto meet = [&](double arriving_at_ground) {
    result.light.next = scattered(coefficients, arriving_at_ground);
    result.light.absorbed -= scattered_by_mirrors(result.light.next);
    result.without_pairs = result.light.next;
    if (is_mixed)
      take_mirrors(of_mirrors, result.without_pairs);
    else if (count > 0)
      result.without_pairs.coefficients.setZero();
  };
  if (is_closed()) {
    // The ground's own order 1 is smooth: on the grid.
    const double met = result.uncollided;
    result.uncollided = 0;
    result.absorbed += (1 - ground_albedo_) * met;
    result.light.absorbed += (1 - ground_albedo_) * arriving;
    const HarmonicLight ground = follow(
        {MatrixXd::Zero(basis_.size(), streams_.size()), lambert_radiance(ground_albedo_ * met)});
    result.light.reflected += ground.reflected;
    result.light.absorbed += ground.absorbed;
    meet(arriving);
    for (HarmonicSource* source : {&result.light.next, &result.without_pairs}) {
      source->coefficients += ground.next.coefficients;
      source->ground += ground.next.ground;
    }
  } else {
    result.light.transmitted = arriving;
    meet(0);
  }
  return result;
}

HarmonicSource HarmonicTransport::sum(const HarmonicSource& source) const {
  const Index rows = basis_.size(), columns = streams_.size(), size = rows * columns;
  const auto flat = [&](const HarmonicSource& s) {
    VectorXd x(size + 1);
    x.head(size) = Eigen::Map<const VectorXd>(s.coefficients.data(), size);
    x[size] = s.ground;
    return x;
  };
  const auto shaped = [&](const VectorXd& x) {
    return HarmonicSource{Eigen::Map<const MatrixXd>(x.data(), rows, columns), x[size]};
  };
  const GmresResult result =
      solve_gmres([&](const VectorXd& x) { return flat(follow(shaped(x)).next); }, flat(source),
                  resolution_.residual, kMaxIterations);
  return shaped(result.solution);
}

void HarmonicTransport::leaving(Direction wo, std::span<const double* const> values,
                                std::span<const double> ground, double* radiance) const {
  std::vector<double> block(streams_.block_size());
  streams_.prepare(wo, block.data(), false);
  for (std::size_t s = 0; s < values.size(); ++s)
    radiance[s] = streams_.march(wo, block.data(), values[s], wo.z > 0 ? ground[s] : 0, nullptr);
}

}  // namespace lamella
