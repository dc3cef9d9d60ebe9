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
// Sums over directions are made in this many pieces, whatever the number of threads; as many as
// these are kept at a time.
constexpr int kPieces = 32, kPiecesAtATime = 8;
constexpr int kMaxIterations = 200;

}  // namespace

HarmonicTransport::HarmonicTransport(const Stack& stack, int channel,
                                     const HarmonicResolution& resolution,
                                     const LayerKernels* kernels)
    : stack_(stack),
      resolution_(resolution),
      basis_(basis_of(resolution)),
      block_(stack, channel, kernels ? *kernels : LayerKernels(basis_, product()), resolution),
      grid_(SphereGrid::quadrature(basis_, cosines_for(resolution.degree),
                                   azimuths_for(resolution.degree), product())) {
  if (stack.substrate) ground_albedo_ = stack.substrate->albedo[channel];
  if (streams().is_cut()) ground_albedo_ = 1;
  prepared_.resize(streams().block_size() * static_cast<std::size_t>(grid_.size()));
  tbb::parallel_for(0, grid_.size(), [&](int k) {
    streams().prepare(grid_.direction(k), &prepared_[streams().block_size() * k]);
  });
}

std::size_t HarmonicTransport::bytes(const Stack& stack, int channel,
                                     const HarmonicResolution& resolution) {
  const HarmonicBasis basis = basis_of(resolution);
  const LayeredStreams streams(stack, channel, resolution.finest, resolution.depth_nodes);
  const std::size_t azimuths = azimuths_for(resolution.degree) / (basis.is_even() ? 2 : 1);
  const std::size_t rays = 2 * cosines_for(resolution.degree) * azimuths;
  const std::size_t nodes = streams.size(), harmonics = basis.size();
  // By ray what its integrals take, the source and the radiance; amplitudes between those and
  // coefficients; some sources.
  constexpr std::size_t kSources = 8;
  std::size_t sum =
      sizeof(double) * (rays * (streams.block_size() + 3 * nodes) + kSources * harmonics * nodes);
  std::vector<const Layer*> seen;
  for (const LayeredStreams::Part& part : streams.parts()) {
    const auto is_same = [&](const Layer* other) { return other->medium == part.layer->medium; };
    if (std::any_of(seen.begin(), seen.end(), is_same)) continue;
    seen.push_back(part.layer);
    sum += HarmonicKernel::bytes(part.layer->medium, basis);
  }
  return sum;
}

HarmonicSource HarmonicTransport::scattered(const MatrixXd& radiance, double arriving) const {
  return {block_.scattered(radiance), lambert_radiance(ground_albedo_ * arriving)};
}

HarmonicLight HarmonicTransport::follow(const HarmonicSource& source) const {
  resolution_.check_stop();
  const MatrixXd values = grid_.values(source.coefficients);
  MatrixXd radiance(streams().size(), grid_.size());
  VectorXd leaving(grid_.size()), absorbed = VectorXd::Zero(grid_.size());
  tbb::parallel_for(0, grid_.size(), [&](int k) {
    const Direction v = grid_.direction(k);
    leaving[k] = streams().march(v, &prepared_[streams().block_size() * k], values.col(k).data(),
                                 v.z > 0 ? source.ground : 0, radiance.col(k).data());
    absorbed[k] = block_.collided(v, radiance.col(k).data());
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
  light.absorbed -= block_.sent_by_schlick(light.next.coefficients);
  return light;
}

HarmonicTransport::First HarmonicTransport::first(Direction wi) const {
  First result;
  VectorXd share(streams().size());
  result.uncollided = streams().beam(wi, share.data());
  const BeamQuadrature beam(-wi, ray_points(basis_.degree()), rays_for(basis_.degree()), {},
                            basis_.is_even());
  const int directions = static_cast<int>(beam.directions.size());
  const bool is_mixed = block_.is_mixed();
  struct Piece {
    MatrixXd coefficients, of_mirrors;
    double up = 0, down = 0, absorbed = 0;
    std::vector<double> leaving;  // by part: share of what collides
  };
  const auto sum_up = [&](int p, Piece& piece) {
    const int begin = directions * p / kPieces, end = directions * (p + 1) / kPieces;
    MatrixXd harmonics(basis_.size(), end - begin), radiance(streams().size(), end - begin);
    MatrixXd of_mirrors(streams().size(), is_mixed ? end - begin : 0);
    std::vector<double> block(streams().block_size());
    std::vector<double> scattered(streams().parts().size());
    piece.leaving.assign(scattered.size(), 0);
    VectorXd source(streams().size()), values(basis_.size());
    for (int k = begin; k < end; ++k) {
      const Direction v = beam.directions[k];
      const double weight = beam.weights[k];
      block_.beam_source(wi, v, share, source, scattered.data());
      for (std::size_t n = 0; n < scattered.size(); ++n) piece.leaving[n] += weight * scattered[n];
      streams().prepare(v, block.data());
      const double leaving =
          streams().march(v, block.data(), source.data(), 0, radiance.col(k - begin).data());
      (v.z > 0 ? piece.up : piece.down) += weight * std::abs(v.z) * leaving;
      piece.absorbed += weight * block_.collided(v, radiance.col(k - begin).data());
      basis_.values(v, values);
      harmonics.col(k - begin) = weight * values;
      if (!is_mixed) continue;
      for (std::size_t n = 0; n < streams().parts().size(); ++n) {
        const LayeredStreams::Part& part = streams().parts()[n];
        if (!block_.is_mirror(n)) source.segment(part.first, part.panels.size()).setZero();
      }
      streams().march(v, block.data(), source.data(), 0, of_mirrors.col(k - begin).data());
    }
    piece.coefficients = product()(harmonics, radiance.transpose());
    if (is_mixed) piece.of_mirrors = product()(harmonics, of_mirrors.transpose());
  };
  MatrixXd coefficients = MatrixXd::Zero(basis_.size(), streams().size());
  MatrixXd of_mirrors = MatrixXd::Zero(basis_.size(), is_mixed ? streams().size() : 0);
  double arriving = 0;
  std::vector<double> leaving(streams().parts().size(), 0);
  for (int p = 0; p < kPieces; p += kPiecesAtATime) {
    resolution_.check_stop();
    std::vector<Piece> pieces(kPiecesAtATime);
    tbb::parallel_for(0, kPiecesAtATime, [&](int k) { sum_up(p + k, pieces[k]); });
    for (const Piece& piece : pieces) {
      for (std::size_t n = 0; n < leaving.size(); ++n) leaving[n] += piece.leaving[n];
      coefficients += piece.coefficients;
      if (is_mixed) of_mirrors += piece.of_mirrors;
      result.light.reflected += piece.up;
      arriving += piece.down;
      result.light.absorbed += piece.absorbed;
    }
  }
  result.absorbed = block_.first_absorbed(wi, leaving);
  const auto meet = [&](double arriving_at_ground) {
    result.light.next = scattered(coefficients, arriving_at_ground);
    result.light.absorbed -= block_.sent_by_schlick(result.light.next.coefficients);
    result.without_pairs = result.light.next;
    if (is_mixed)
      result.without_pairs.coefficients -= block_.scattered_by_mirrors(of_mirrors);
    else if (block_.has_mirrors())
      result.without_pairs.coefficients.setZero();
  };
  if (is_closed()) {
    // The ground's own order 1 is smooth: on the grid.
    const double met = result.uncollided;
    result.uncollided = 0;
    result.absorbed += (1 - ground_albedo_) * met;
    result.light.absorbed += (1 - ground_albedo_) * arriving;
    const HarmonicLight ground = follow(
        {MatrixXd::Zero(basis_.size(), streams().size()), lambert_radiance(ground_albedo_ * met)});
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
  const Index rows = basis_.size(), columns = streams().size(), size = rows * columns;
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
  std::vector<double> block(streams().block_size());
  streams().prepare(wo, block.data(), false);
  for (std::size_t s = 0; s < values.size(); ++s)
    radiance[s] = streams().march(wo, block.data(), values[s], wo.z > 0 ? ground[s] : 0, nullptr);
}

}  // namespace lamella
