#include "volume/harmonics/block_beams.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "volume/harmonics/beam_quadrature.h"
#include "volume/harmonics/harmonic_scope.h"
#include "volume/kernel/forward_projection.h"
#include "volume/quadrature/direction_sets.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Width of phase functions that the nodes resolve [radians].
constexpr double kSmooth = 0.3;
// Sums over directions are made in this many pieces, whatever the number of threads.
constexpr int kPieces = 32;

int ray_points(int degree) { return std::max(32, degree + 8); }
int rays_for(int degree) { return 2 * degree + 64; }

Direction turned_over(Direction v) { return {v.x, v.y, -v.z}; }

// Cosines within a block beyond which light is totally reflected somewhere.
std::vector<double> critical_within(double index, const std::vector<StackElement>& elements) {
  std::vector<double> cosines;
  for (const StackElement& e : elements)
    for (const double other : {e.above, e.below})
      if (other < index) cosines.push_back(std::sqrt((1 - other / index) * (1 + other / index)));
  std::sort(cosines.begin(), cosines.end());
  cosines.erase(std::unique(cosines.begin(), cosines.end()), cosines.end());
  return cosines;
}

// What light along directions that are no nodes is at the nodes of a hemisphere: values whose sums
// with functions that are polynomials over u^3 on each panel are the integrals, as those of facets
// are (volume/DETERMINISTIC.md). Rows: nodes.
VectorXd at_nodes(const DirectionSets& sets, double mu) {
  VectorXd values = VectorXd::Zero(sets.nodes());
  const auto panel = std::find_if(sets.panels.begin(), sets.panels.end() - 1,
                                  [&](const NodePanel& p) { return mu >= p.low(); });
  const Quadrature& rule = cached_gauss_legendre(static_cast<int>(panel->count));
  const double u = std::max(panel->parameter(mu), 1e-12);
  VectorXd place(1);
  place[0] = u;
  const MatrixXd lagrange = lagrange_values(rule, place);
  for (Index j = 0; j < panel->count; ++j) {
    const double ratio = rule.points[j] / u;
    values[panel->first + j] = lagrange(0, j) * ratio * ratio * ratio / sets.flux[panel->first + j];
  }
  return values;
}

}  // namespace

BlockBeams::BlockBeams(const BoundedTransport& transport, std::size_t block,
                       std::vector<Beam> beams)
    : transport_(transport), block_(block), beams_(std::move(beams)) {
  const LayeredStreams& streams = transport.block(block).streams();
  for (const Beam& beam : beams_) {
    VectorXd& share = shares_.emplace_back(streams.size());
    streams.beam(beam.w, share.data());
  }
}

double BlockBeams::leaving(std::size_t n, Direction v, const double* prepared) const {
  const BlockTransport& block = transport_.block(block_);
  const LayeredStreams& streams = block.streams();
  VectorXd source(streams.size());
  std::vector<double> scattered(streams.parts().size());
  block.beam_source(beams_[n].w, v, shares_[n], source, scattered.data());
  return streams.march(v, prepared, source.data(), 0, nullptr);
}

FaceLight BlockBeams::emitted_at_nodes(std::size_t n) const {
  const SphereGrid& grid = transport_.grid(block_);
  const LayeredStreams& streams = transport_.block(block_).streams();
  FaceLight light = transport_.no_light()[block_];
  const Index nodes = light.up.rows();
  tbb::parallel_for(0, grid.size(), [&](int k) {
    const Direction v = grid.direction(k);
    std::vector<double> prepared(streams.block_size());
    streams.prepare(v, prepared.data(), false);
    (v.z > 0 ? light.up : light.down)((k / grid.azimuths()) % nodes, k % grid.azimuths()) =
        leaving(n, v, prepared.data());
  });
  return light;
}

FaceLight BlockBeams::mirrored(const FaceLight& emitted) const {
  const BlockSurroundings& around = transport_.surroundings();
  FaceLight light{MatrixXd::Zero(emitted.down.rows(), emitted.down.cols()),
                  MatrixXd::Zero(emitted.up.rows(), emitted.up.cols())};
  const Index nodes = light.up.rows(), azimuths = light.up.cols();
  for (Index row = 0; row < nodes; ++row) {
    const double top = around.mirror(block_, true, row), bottom = around.mirror(block_, false, row);
    if (top == 0 && bottom == 0) continue;
    for (Index p = 0; p < azimuths; ++p) {
      const double up = transport_.crossing(block_, static_cast<int>(row * azimuths + p));
      const double down =
          transport_.crossing(block_, static_cast<int>((nodes + row) * azimuths + p));
      light.down(row, p) = top * (emitted.up(row, p) + up * bottom * emitted.down(row, p)) /
                           (1 - top * bottom * up * down);
      light.up(row, p) = bottom * (emitted.down(row, p) + down * light.down(row, p));
    }
  }
  return light;
}

BlockBeams::First BlockBeams::first(std::size_t n) const {
  const BlockSurroundings& around = transport_.surroundings();
  const BlockTransport& block = transport_.block(block_);
  const LayeredStreams& streams = block.streams();
  const HarmonicBasis& basis = transport_.basis();
  const DirectionSets& sets = around.sets(block_);
  const Index nodes = sets.nodes(), waves = around.waves();
  MatrixXd coefficients = MatrixXd::Zero(basis.size(), streams.size());
  FaceLight emitted{MatrixXd::Zero(nodes, waves), MatrixXd::Zero(nodes, waves)};
  const std::vector<double> cuts =
      critical_within(around.blocks()[block_].index, transport_.elements());
  First result;
  const Beam& beam = beams_[n];
  transport_.resolution().check_stop();
  const BeamQuadrature rule(-beam.w, ray_points(basis.degree()), rays_for(basis.degree()), cuts);
  const int directions = static_cast<int>(rule.directions.size());
  struct Piece {
    MatrixXd coefficients;
    FaceLight emitted;
    double absorbed = 0;
    std::vector<double> scattered;
  };
  std::vector<Piece> pieces(kPieces);
  tbb::parallel_for(0, kPieces, [&](int p) {
    const int begin = directions * p / kPieces, end = directions * (p + 1) / kPieces;
    Piece& piece = pieces[p];
    const std::size_t layers = streams.parts().size();
    piece.scattered.assign(layers, 0);
    MatrixXd harmonics(basis.size(), 2 * (end - begin)),
        radiance = MatrixXd::Zero(streams.size(), 2 * (end - begin));
    MatrixXd up_nodes = MatrixXd::Zero(nodes, end - begin), down_nodes = up_nodes;
    std::vector<double> there(streams.block_size()), back(streams.block_size()), scattered(layers),
        phi;
    VectorXd source(streams.size()), values(basis.size());
    const VectorXd none = VectorXd::Zero(streams.size());
    for (int k = begin; k < end; ++k) {
      const Direction v = rule.directions[k], mirrored = turned_over(v);
      const double weight = rule.weights[k], mu = std::abs(v.z);
      block.beam_source(beam.w, v, shares_[n], source, scattered.data());
      for (std::size_t layer = 0; layer < layers; ++layer)
        piece.scattered[layer] += weight * scattered[layer];
      const bool up = v.z > 0;
      const double ahead = around.mirror_at(block_, up, mu),
                   behind = around.mirror_at(block_, !up, mu);
      streams.prepare(v, there.data());
      const Index column = k - begin;
      const double leaves = streams.march(v, there.data(), source.data(), 0, nullptr);
      (up ? up_nodes : down_nodes).col(column) = weight * mu * leaves * at_nodes(sets, mu);
      phi.push_back(azimuth(v));
      double entering = 0;
      if (ahead > 0) {
        streams.prepare(mirrored, back.data());
        const double on = streams.crossing(v), off = streams.crossing(mirrored);
        const double returns = ahead * leaves / (1 - ahead * behind * on * off);
        entering = behind * off * returns;
        streams.march(mirrored, back.data(), none.data(), returns,
                      radiance.col(2 * column + 1).data());
        piece.absorbed += weight * block.collided(mirrored, radiance.col(2 * column + 1).data());
      }
      streams.march(v, there.data(), source.data(), entering, radiance.col(2 * column).data());
      piece.absorbed += weight * block.collided(v, radiance.col(2 * column).data());
      basis.values(v, values);
      harmonics.col(2 * column) = weight * values;
      basis.values(mirrored, values);
      harmonics.col(2 * column + 1) = weight * values;
    }
    const MatrixXd around_z = BoundedTransport::waves_at(waves, phi);
    piece.coefficients = transport_.product()(harmonics, radiance.transpose());
    piece.emitted = {transport_.product()(down_nodes, around_z),
                     transport_.product()(up_nodes, around_z)};
  });
  std::vector<double> scattered(streams.parts().size(), 0);
  for (const Piece& piece : pieces) {
    coefficients += piece.coefficients;
    emitted.down += piece.emitted.down;
    emitted.up += piece.emitted.up;
    result.absorbed += piece.absorbed;
    for (std::size_t layer = 0; layer < scattered.size(); ++layer)
      scattered[layer] += piece.scattered[layer];
  }
  result.absorbed += block.first_absorbed(beam.w, scattered);
  result.scattered = block.scattered(coefficients);
  result.absorbed -= block.sent_by_schlick(result.scattered);
  // What is smooth, nodes resolve better than moments do.
  const bool is_smooth =
      !block.has_mirrors() && narrowest_feature(transport_.layers(block_)) > kSmooth;
  result.emitted = is_smooth ? emitted_at_nodes(n) : transport_.grid_of(block_, emitted);
  return result;
}

}  // namespace lamella
