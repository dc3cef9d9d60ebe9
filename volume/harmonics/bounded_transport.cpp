#include "volume/harmonics/bounded_transport.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "volume/harmonics/gmres.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxIterations = 200;

int azimuths_for(int degree) { return 2 * degree + 32; }
// Of the rarest medium; denser ones have more. Lobes of boundaries that are not symmetric want more
// of them, and more from each degree to the next, so that bounds tell what they miss.
int nodes_for(const Stack& stack, int degree) {
  return has_anisotropic_boundaries(stack) ? degree + 16 : std::max(24, (3 * degree) / 4 + 8);
}

std::vector<AskedCosine> cosines_of(const Stack& stack, std::span<const Direction> incident) {
  std::vector<AskedCosine> asked;
  const double bottom = stack.index_of(stack.layers.size());
  for (const Direction w : incident) asked.push_back({std::abs(w.z), w.z > 0 ? 1 : bottom});
  return asked;
}

}  // namespace

BoundedTransport::Block::Block(Stack inner, const DirectionSets& sets, int channel,
                               const LayerKernels& kernels, const HarmonicResolution& resolution,
                               int azimuths)
    : stack(std::move(inner)),
      transport(stack, channel, kernels, resolution),
      grid(SphereGrid::quadrature(kernels.basis(), VectorXd(sets.out.head(sets.nodes())),
                                  sets.weight, azimuths, MatrixProduct(resolution.isa))) {
  const LayeredStreams& streams = transport.streams();
  prepared.resize(streams.block_size() * static_cast<std::size_t>(grid.size()));
  crossing.resize(grid.size());
  tbb::parallel_for(0, grid.size(), [&](int k) {
    const Direction v = grid.direction(k);
    streams.prepare(v, prepared.data() + streams.block_size() * k);
    crossing[k] = streams.crossing(v);
  });
}

MatrixXd BoundedTransport::waves_at(Index waves, std::span<const double> phi) {
  return azimuthal_waves(waves,
                         Eigen::Map<const VectorXd>(phi.data(), static_cast<Index>(phi.size())));
}

BoundedTransport::BoundedTransport(const Stack& stack, int channel,
                                   const HarmonicResolution& resolution,
                                   std::span<const AskedCosine> asked,
                                   std::span<const Direction> incident, const LayerKernels* kernels,
                                   SharedBoundaries* shared)
    : resolution_(resolution),
      basis_(resolution.degree),
      azimuths_(azimuths_for(resolution.degree)),
      surroundings_(stack, channel, layer_blocks(stack), nodes_for(stack, resolution.degree),
                    (azimuths_ - 1) / 2 + 1, resolution.degree, asked, cosines_of(stack, incident),
                    resolution.isa, shared),
      elements_(elements_of(stack)),
      ground_(ground_of(stack, channel)) {
  const LayerKernels own(basis_, MatrixProduct(resolution.isa));
  for (std::size_t b = 0; b < surroundings_.blocks().size(); ++b) {
    const LayerBlock& range = surroundings_.blocks()[b];
    Block& block = blocks_.emplace_back(stack_of(stack, range), surroundings_.sets(b), channel,
                                        kernels ? *kernels : own, resolution, azimuths_);
    block.above = elements_between(stack, 0, range.begin).size();
    block.below = elements_between(stack, 0, range.end).size();
  }
  std::vector<double> phi;
  for (int p = 0; p < azimuths_; ++p) phi.push_back(2 * kPi * (p + 0.5) / azimuths_);
  waves_ = waves_at(surroundings_.waves(), phi);
}

std::vector<FaceLight> BoundedTransport::no_light() const {
  std::vector<FaceLight> light;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const MatrixXd none = MatrixXd::Zero(surroundings_.sets(b).nodes(), azimuths_);
    light.push_back({none, none});
  }
  return light;
}

std::vector<FaceLight> BoundedTransport::waves_of(const std::vector<FaceLight>& grid) const {
  std::vector<FaceLight> waves;
  for (const FaceLight& face : grid)
    waves.push_back(
        {product()(face.down, waves_) / azimuths_, product()(face.up, waves_) / azimuths_});
  return waves;
}

std::vector<FaceLight> BoundedTransport::grid_of(const std::vector<FaceLight>& waves) const {
  std::vector<FaceLight> grid;
  for (std::size_t b = 0; b < waves.size(); ++b) grid.push_back(grid_of(b, waves[b]));
  return grid;
}

FaceLight BoundedTransport::grid_of(std::size_t b, const FaceLight& waves) const {
  const Index nodes = surroundings_.sets(b).nodes();
  const auto at = [&](const MatrixXd& rows) {
    return product()(rows.topRows(nodes), waves_.transpose());
  };
  return {at(waves.down), at(waves.up)};
}

MatrixXd BoundedTransport::values_at(const MatrixXd& waves, std::span<const double> phi) {
  return waves * waves_at(waves.cols(), phi).transpose();
}

BoundedStep BoundedTransport::follow(const BoundedSource& source, bool with_scattered) const {
  resolution_.check_stop();
  BoundedStep step;
  step.leaving = no_light();
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const Block& block = blocks_[b];
    const LayeredStreams& streams = block.transport.streams();
    const bool has_source = source.coefficients[b].size() > 0;
    const MatrixXd values =
        has_source ? block.grid.values(source.coefficients[b]) : MatrixXd::Zero(streams.size(), 1);
    MatrixXd radiance(with_scattered ? streams.size() : 0, with_scattered ? block.grid.size() : 0);
    VectorXd absorbed = VectorXd::Zero(block.grid.size());
    const Index nodes = surroundings_.sets(b).nodes();
    tbb::parallel_for(0, block.grid.size(), [&](int k) {
      const Direction v = block.grid.direction(k);
      const bool up = v.z > 0;
      const Index row = (k / azimuths_) % nodes, column = k % azimuths_;
      const FaceLight& enters = source.entering[b];
      double* ray = with_scattered ? radiance.col(k).data() : nullptr;
      (up ? step.leaving[b].up : step.leaving[b].down)(row, column) = streams.march(
          v, block.prepared.data() + streams.block_size() * k,
          values.col(has_source ? k : 0).data(), (up ? enters.up : enters.down)(row, column), ray);
      if (ray) absorbed[k] = block.transport.collided(v, ray);
    });
    if (!with_scattered) continue;
    if (streams.size() == 0) {
      step.scattered.emplace_back(basis_.size(), 0);
      continue;
    }
    for (int k = 0; k < block.grid.size(); ++k) step.absorbed += block.grid.weight(k) * absorbed[k];
    step.scattered.push_back(block.transport.scattered(block.grid.coefficients(radiance)));
    step.absorbed -= block.transport.sent_by_schlick(step.scattered.back());
  }
  return step;
}

std::vector<FaceLight> BoundedTransport::settled(const std::vector<FaceLight>& first,
                                                 const std::vector<FaceLight>& emitted) const {
  Index size = 0;
  for (const FaceLight& face : first) size += face.down.size() + face.up.size();
  const auto flat = [&](const std::vector<FaceLight>& light) {
    VectorXd x(size);
    Index at = 0;
    for (const FaceLight& face : light)
      for (const MatrixXd* m : {&face.down, &face.up}) {
        x.segment(at, m->size()) = Eigen::Map<const VectorXd>(m->data(), m->size());
        at += m->size();
      }
    return x;
  };
  const auto shaped = [&](const VectorXd& x) {
    std::vector<FaceLight> light = first;
    Index at = 0;
    for (FaceLight& face : light)
      for (MatrixXd* m : {&face.down, &face.up}) {
        *m = Eigen::Map<const MatrixXd>(x.data() + at, m->rows(), m->cols());
        at += m->size();
      }
    return light;
  };
  const auto turned_back = [&](const std::vector<FaceLight>& leaving) {
    return grid_of(surroundings_.from_blocks(waves_of(leaving), {OrderStep::Kind::by, 0}).entering);
  };
  const auto crossed = [&](std::vector<FaceLight> light) {
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      const Index nodes = light[b].up.rows();
      for (Index row = 0; row < nodes; ++row)
        for (Index p = 0; p < azimuths_; ++p) {
          light[b].up(row, p) *= blocks_[b].crossing[row * azimuths_ + p];
          light[b].down(row, p) *= blocks_[b].crossing[(nodes + row) * azimuths_ + p];
        }
    }
    return light;
  };
  const VectorXd begin = flat(first) + flat(turned_back(emitted));
  return shaped(solve_gmres(
                    [&](const VectorXd& x) {
                      resolution_.check_stop();
                      return flat(turned_back(crossed(shaped(x))));
                    },
                    begin, resolution_.residual, kMaxIterations)
                    .solution);
}

}  // namespace lamella
