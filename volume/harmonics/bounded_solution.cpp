#include "volume/harmonics/bounded_solution.h"

#include <tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "volume/harmonics/beam_quadrature.h"
#include "volume/harmonics/gmres.h"
#include "volume/harmonics/harmonic_scope.h"
#include "volume/kernel/forward_projection.h"
#include "volume/quadrature/direction_sets.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxIterations = 300;
// Width of phase functions that the nodes resolve [radians].
constexpr double kSmooth = 0.3;
// Sums over directions are made in this many pieces, whatever the number of threads.
constexpr int kPieces = 32;

int ray_points(int degree) { return std::max(32, degree + 8); }
int rays_for(int degree) { return 2 * degree + 64; }

Direction turned_over(Direction v) { return {v.x, v.y, -v.z}; }

// The step from light of one order to light of another; 4 stands for 4 and more.
OrderStep step_between(int from, int to) {
  if (to < 4) return {OrderStep::Kind::by, to - from};
  if (from == 4) return {OrderStep::Kind::any, 0};
  return {OrderStep::Kind::beyond, 3 - from};
}

void add_to(std::vector<FaceLight>& sum, const std::vector<FaceLight>& term) {
  for (std::size_t b = 0; b < sum.size(); ++b) {
    sum[b].down += term[b].down;
    sum[b].up += term[b].up;
  }
}

bool is_dark(const std::vector<FaceLight>& light) {
  for (const FaceLight& face : light)
    if (!face.down.isZero(0) || !face.up.isZero(0)) return false;
  return true;
}

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

BoundedSolution::BoundedSolution(const BoundedTransport& transport, std::size_t i, Direction wi)
    : transport_(transport),
      wi_(wi),
      has_rough_(std::any_of(transport.elements().begin(), transport.elements().end(),
                             [](const StackElement& e) { return e.is_rough(); })) {
  find_beams();
  for (auto& sources : sources_) sources.resize(transport.blocks());
  // Order 0: what rough boundaries make of beams.
  around_[0] = raised(i, 0);
  std::vector<FaceLight> entering = transport.grid_of(around_[0].entering);
  if (is_dark(entering)) {
    leaving_[0] = transport.waves_of(transport.no_light());
  } else {
    entering = transport.settled(entering, transport.no_light());
    BoundedStep step = transport.follow({no_source().coefficients, entering}, true);
    energies_.absorbed += step.absorbed;
    sources_[1] = std::move(step.scattered);
    leaving_[0] = transport.waves_of(step.leaving);
    around_[0] += transport.surroundings().from_blocks(leaving_[0], step_between(0, 0));
  }
  solve_first(i);
  solve_order(i, 2);
  solve_order(i, 3);
  solve_rest(i);
  take_energies(i);
}

void BoundedSolution::find_beams() {
  const std::vector<StackElement>& elements = transport_.elements();
  const double from = wi_.z > 0 ? 1 : elements.back().below;
  const StackBeam beam = beam_of(elements, wi_, false);
  const bool from_above = wi_.z > 0;
  arriving_.azimuth = azimuth(-wi_);
  const std::size_t blocks = transport_.blocks();
  for (std::size_t k = 0; k <= blocks; ++k) {
    arriving_.down.push_back(k == 0 ? (from_above ? 1 : 0)
                                    : beam.down[transport_.place_below(k - 1)]);
    arriving_.up.push_back(k == blocks ? (from_above ? 0 : 1) : beam.up[transport_.place_above(k)]);
  }
  for (std::size_t b = 0; b < blocks; ++b) {
    beams_.emplace_back();
    const LayeredStreams& streams = transport_.block(b).streams();
    const double index = transport_.surroundings().blocks()[b].index;
    const std::size_t above = transport_.place_above(b);
    const double mu = beam.mu[above];
    if (!(mu > 0)) continue;
    for (const bool down : {true, false}) {
      const double power = down ? beam.down[above] : beam.up[transport_.place_below(b)];
      if (!(power > 0)) continue;
      Beam in{refracted_to(wi_, from, index, down ? mu : -mu), VectorXd(streams.size()), power};
      streams.beam(in.w, in.share.data());
      in.share *= power;
      beams_.back().push_back(std::move(in));
    }
  }
  energies_.uncollided = from_above ? beam.down.back() : beam.up.front();
  energies_.mirrored = from_above ? beam.up.front() : beam.down.back();
  if (transport_.surroundings().is_closed()) energies_.uncollided = 0;
}

SurroundedLight BoundedSolution::raised(std::size_t i, int order) const {
  const BlockSurroundings& around = transport_.surroundings();
  SurroundedLight light = around.from_beam(arriving_, i, step_between(0, order));
  for (int from = 0; from < order; ++from)
    light += around.from_blocks(leaving_[from], step_between(from, order));
  return light;
}

BoundedSource BoundedSolution::no_source() const {
  return {std::vector<MatrixXd>(transport_.blocks()), transport_.no_light()};
}

FaceLight BoundedSolution::crossed(std::size_t b, FaceLight light) const {
  const Index nodes = light.up.rows(), azimuths = light.up.cols();
  for (Index row = 0; row < nodes; ++row)
    for (Index p = 0; p < azimuths; ++p) {
      light.up(row, p) *= transport_.crossing(b, static_cast<int>(row * azimuths + p));
      light.down(row, p) *= transport_.crossing(b, static_cast<int>((nodes + row) * azimuths + p));
    }
  return light;
}

FaceLight BoundedSolution::emitted_at_nodes(std::size_t b) const {
  const SphereGrid& grid = transport_.grid(b);
  const BlockTransport& block = transport_.block(b);
  const LayeredStreams& streams = block.streams();
  FaceLight light = transport_.no_light()[b];
  const Index nodes = light.up.rows();
  tbb::parallel_for(0, grid.size(), [&](int k) {
    const Direction v = grid.direction(k);
    std::vector<double> prepared(streams.block_size()), scattered(streams.parts().size());
    VectorXd source(streams.size());
    streams.prepare(v, prepared.data(), false);
    double& leaves =
        (v.z > 0 ? light.up : light.down)((k / grid.azimuths()) % nodes, k % grid.azimuths());
    for (const Beam& beam : beams_[b]) {
      block.beam_source(beam.w, v, beam.share, source, scattered.data());
      leaves += streams.march(v, prepared.data(), source.data(), 0, nullptr);
    }
  });
  return light;
}

FaceLight BoundedSolution::mirrored_within(std::size_t b, const FaceLight& emitted) const {
  const BlockSurroundings& around = transport_.surroundings();
  FaceLight light{MatrixXd::Zero(emitted.down.rows(), emitted.down.cols()),
                  MatrixXd::Zero(emitted.up.rows(), emitted.up.cols())};
  const Index nodes = light.up.rows(), azimuths = light.up.cols();
  for (Index row = 0; row < nodes; ++row) {
    const double top = around.mirror(b, true, row), bottom = around.mirror(b, false, row);
    if (top == 0 && bottom == 0) continue;
    for (Index p = 0; p < azimuths; ++p) {
      const double up = transport_.crossing(b, static_cast<int>(row * azimuths + p));
      const double down = transport_.crossing(b, static_cast<int>((nodes + row) * azimuths + p));
      light.down(row, p) = top * (emitted.up(row, p) + up * bottom * emitted.down(row, p)) /
                           (1 - top * bottom * up * down);
      light.up(row, p) = bottom * (emitted.down(row, p) + down * light.down(row, p));
    }
  }
  return light;
}

BoundedSolution::FirstOfBeams BoundedSolution::first_of_beams(std::size_t b) {
  const BlockSurroundings& around = transport_.surroundings();
  const BlockTransport& block = transport_.block(b);
  const LayeredStreams& streams = block.streams();
  const HarmonicBasis& basis = transport_.basis();
  const DirectionSets& sets = around.sets(b);
  const Index nodes = sets.nodes(), waves = around.waves();
  MatrixXd coefficients = MatrixXd::Zero(basis.size(), streams.size());
  FaceLight emitted{MatrixXd::Zero(nodes, waves), MatrixXd::Zero(nodes, waves)};
  const std::vector<double> cuts = critical_within(around.blocks()[b].index, transport_.elements());
  for (const Beam& beam : beams_[b]) {
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
      std::vector<double> there(streams.block_size()), back(streams.block_size()),
          scattered(layers), phi;
      VectorXd source(streams.size()), values(basis.size());
      const VectorXd none = VectorXd::Zero(streams.size());
      for (int k = begin; k < end; ++k) {
        const Direction v = rule.directions[k], mirrored = turned_over(v);
        const double weight = rule.weights[k], mu = std::abs(v.z);
        block.beam_source(beam.w, v, beam.share, source, scattered.data());
        for (std::size_t n = 0; n < layers; ++n) piece.scattered[n] += weight * scattered[n];
        const bool up = v.z > 0;
        const double ahead = around.mirror_at(b, up, mu), behind = around.mirror_at(b, !up, mu);
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
      energies_.absorbed += piece.absorbed;
      for (std::size_t n = 0; n < scattered.size(); ++n) scattered[n] += piece.scattered[n];
    }
    energies_.absorbed += beam.power * block.first_absorbed(beam.w, scattered);
  }
  FirstOfBeams first{block.scattered(coefficients), std::move(emitted)};
  energies_.absorbed -= block.sent_by_schlick(first.scattered);
  return first;
}

void BoundedSolution::solve_first(std::size_t i) {
  const std::size_t blocks = transport_.blocks();
  around_[1] = raised(i, 1);
  BoundedSource source = no_source();
  source.coefficients = sources_[1];
  std::vector<FaceLight> emitted = transport_.follow(source, false).leaving, of_beams, mirrored;
  std::vector<MatrixXd> scattered;
  for (std::size_t b = 0; b < blocks; ++b) {
    FirstOfBeams first = first_of_beams(b);
    scattered.push_back(std::move(first.scattered));
    of_beams.push_back(std::move(first.emitted));
  }
  of_beams = transport_.grid_of(of_beams);
  for (std::size_t b = 0; b < blocks; ++b) {
    // What is smooth, nodes resolve better than moments do.
    if (!transport_.block(b).has_mirrors() && narrowest_feature(transport_.layers(b)) > kSmooth)
      of_beams[b] = emitted_at_nodes(b);
    mirrored.push_back(mirrored_within(b, of_beams[b]));
  }
  add_to(emitted, of_beams);
  source.entering = transport_.settled(transport_.grid_of(around_[1].entering), emitted);
  for (std::size_t b = 0; b < blocks; ++b) {
    source.entering[b].down -= mirrored[b].down;
    source.entering[b].up -= mirrored[b].up;
  }
  BoundedStep step = transport_.follow(source, true);
  for (std::size_t b = 0; b < blocks; ++b) {
    step.scattered[b] += scattered[b];
    mirrored[b] = crossed(b, std::move(mirrored[b]));
  }
  add_to(step.leaving, of_beams);
  add_to(step.leaving, mirrored);
  energies_.absorbed += step.absorbed;
  sources_[2] = std::move(step.scattered);
  leaving_[1] = transport_.waves_of(step.leaving);
  around_[1] += transport_.surroundings().from_blocks(leaving_[1], step_between(1, 1));
}

void BoundedSolution::solve_order(std::size_t i, int order) {
  around_[order] = raised(i, order);
  BoundedSource source = no_source();
  source.coefficients = sources_[order];
  source.entering = transport_.settled(transport_.grid_of(around_[order].entering),
                                       transport_.follow(source, false).leaving);
  BoundedStep step = transport_.follow(source, true);
  energies_.absorbed += step.absorbed;
  sources_[order + 1] = std::move(step.scattered);
  leaving_[order] = transport_.waves_of(step.leaving);
  around_[order] +=
      transport_.surroundings().from_blocks(leaving_[order], step_between(order, order));
}

void BoundedSolution::solve_rest(std::size_t i) {
  const BlockSurroundings& around = transport_.surroundings();
  around_[4] = raised(i, 4);
  BoundedSource begin{sources_[4], transport_.grid_of(around_[4].entering)};
  Index size = 0;
  for (std::size_t b = 0; b < transport_.blocks(); ++b)
    size +=
        begin.coefficients[b].size() + begin.entering[b].down.size() + begin.entering[b].up.size();
  const auto matrices = [](auto& source) {
    std::vector<decltype(&source.coefficients[0])> list;
    for (std::size_t b = 0; b < source.coefficients.size(); ++b) {
      list.push_back(&source.coefficients[b]);
      list.push_back(&source.entering[b].down);
      list.push_back(&source.entering[b].up);
    }
    return list;
  };
  const auto flat = [&](const BoundedSource& source) {
    VectorXd x(size);
    Index at = 0;
    for (const MatrixXd* m : matrices(source)) {
      x.segment(at, m->size()) = Eigen::Map<const VectorXd>(m->data(), m->size());
      at += m->size();
    }
    return x;
  };
  const auto shaped = [&](const VectorXd& x) {
    BoundedSource source = begin;
    Index at = 0;
    for (MatrixXd* m : matrices(source)) {
      *m = Eigen::Map<const MatrixXd>(x.data() + at, m->rows(), m->cols());
      at += m->size();
    }
    return source;
  };
  const auto apply = [&](const VectorXd& x) {
    BoundedStep step = transport_.follow(shaped(x), true);
    return flat(
        {std::move(step.scattered),
         transport_.grid_of(
             around.from_blocks(transport_.waves_of(step.leaving), step_between(4, 4)).entering)});
  };
  const BoundedSource all = shaped(
      solve_gmres(apply, flat(begin), transport_.resolution().residual, kMaxIterations).solution);
  const BoundedStep step = transport_.follow(all, true);
  energies_.absorbed += step.absorbed;
  sources_[4] = all.coefficients;
  leaving_[4] = transport_.waves_of(step.leaving);
  around_[4] += around.from_blocks(leaving_[4], step_between(4, 4));
}

void BoundedSolution::take_energies(std::size_t i) {
  const BlockSurroundings& around = transport_.surroundings();
  const auto flux = [](const DirectionSets& sets, const MatrixXd& waves) {
    return sets.flux.dot(waves.col(0).head(sets.nodes()));
  };
  BlockSurroundings::Taken taken = around.taken(arriving_, i);
  energies_.absorbed += taken.absorbed;
  energies_.lost += taken.lost;
  for (int order = 0; order < kOrders; ++order) {
    const double up = flux(around.top(), around_[order].outside.up);
    const double down = around.is_closed() ? 0 : flux(around.bottom(), around_[order].outside.down);
    (order == 0 ? energies_.zero_up : energies_.up[order - 1]) = up;
    (order == 0 ? energies_.zero_down : energies_.down[order - 1]) = down;
    taken = around.taken(leaving_[order]);
    energies_.absorbed += taken.absorbed;
    energies_.lost += taken.lost;
  }
}

BoundedSolution::Ray BoundedSolution::ray_along(
    std::size_t b, Direction v, const std::array<const double*, kOrders>& values) const {
  const BlockTransport& block = transport_.block(b);
  const LayeredStreams& streams = block.streams();
  std::vector<double> prepared(streams.block_size());
  streams.prepare(v, prepared.data(), false);
  Ray ray{streams.crossing(v), {}};
  for (int order = 0; order < kOrders; ++order)
    if (values[order])
      ray.emitted[order] = streams.march(v, prepared.data(), values[order], 0, nullptr);
  if (beams_[b].empty()) return ray;
  VectorXd source(streams.size());
  std::vector<double> scattered(streams.parts().size());
  for (const Beam& beam : beams_[b]) {
    block.beam_source(beam.w, v, beam.share, source, scattered.data());
    ray.emitted[1] += streams.march(v, prepared.data(), source.data(), 0, nullptr);
  }
  return ray;
}

// Along each ray what enters a block is what is diffuse there and what the faces mirror and let
// through: two unknowns per block.
std::array<MatrixXd, kHarmonicParts> BoundedSolution::f(bool up, std::size_t first,
                                                        std::size_t count,
                                                        std::span<const double> phi) const {
  const BlockSurroundings& around = transport_.surroundings();
  const Index blocks = static_cast<Index>(transport_.blocks());
  const Index rows = static_cast<Index>(count), columns = static_cast<Index>(phi.size());
  // Rows of an answer that were asked for.
  const auto asked = [&](const MatrixXd& waves, const DirectionSets& sets) {
    return BoundedTransport::values_at(
        waves.middleRows(sets.nodes() + static_cast<Index>(first), rows), phi);
  };
  std::vector<std::array<MatrixXd, kOrders>> values(blocks);  // nodes x (up, then down)
  std::vector<std::array<FaceLight, kOrders>> diffuse(blocks);
  std::vector<VectorXd> mu(blocks);
  for (Index b = 0; b < blocks; ++b) {
    const DirectionSets& sets = around.sets(b);
    mu[b] = sets.out.segment(sets.nodes() + static_cast<Index>(first), rows);
    std::vector<double> cosines(mu[b].begin(), mu[b].end());
    for (Index j = 0; j < rows; ++j) cosines.push_back(-mu[b][j]);
    const SphereGrid grid(transport_.basis(), cosines, {phi.begin(), phi.end()},
                          transport_.product());
    for (int order = 0; order < kOrders; ++order) {
      if (sources_[order][b].size() > 0) values[b][order] = grid.values(sources_[order][b]);
      diffuse[b][order] = {asked(around_[order].entering[b].down, sets),
                           asked(around_[order].entering[b].up, sets)};
    }
  }
  const DirectionSets& outside = up ? around.top() : around.bottom();
  std::array<MatrixXd, kOrders> radiance;
  for (int order = 0; order < kOrders; ++order)
    radiance[order] = asked(up ? around_[order].outside.up : around_[order].outside.down, outside);
  tbb::parallel_for(Index{0}, rows * columns, [&](Index k) {
    const Index j = k / columns, p = k % columns;
    MatrixXd system = MatrixXd::Identity(2 * blocks, 2 * blocks);
    MatrixXd right = MatrixXd::Zero(2 * blocks, kOrders);  // down, up of each block
    std::vector<std::array<Ray, 2>> rays(blocks);          // down, up
    const auto row_of = [&](Index b) {
      return around.sets(b).nodes() + static_cast<Index>(first) + j;
    };
    for (Index b = 0; b < blocks; ++b)
      for (const int way : {0, 1}) {
        const Index direction = (way == 1 ? j : rows + j) * columns + p;
        std::array<const double*, kOrders> at{};
        for (int order = 0; order < kOrders; ++order)
          if (values[b][order].size() > 0) at[order] = values[b][order].col(direction).data();
        rays[b][way] =
            ray_along(b, direction_from_mu_phi(way == 1 ? mu[b][j] : -mu[b][j], phi[p]), at);
      }
    const auto add = [&](Index to, double share, Index from_block, int way) {
      if (!(share > 0)) return;
      const Ray& ray = rays[from_block][way];
      system(to, 2 * from_block + way) -= share * ray.crossing;
      for (int order = 0; order < kOrders; ++order) right(to, order) += share * ray.emitted[order];
    };
    for (Index b = 0; b < blocks; ++b) {
      for (int order = 0; order < kOrders; ++order) {
        right(2 * b, order) += diffuse[b][order].down(j, p);
        right(2 * b + 1, order) += diffuse[b][order].up(j, p);
      }
      add(2 * b, around.mirror(b, true, row_of(b)), b, 1);
      add(2 * b + 1, around.mirror(b, false, row_of(b)), b, 0);
      if (b > 0) add(2 * b, around.through(b - 1, false, row_of(b - 1)), b - 1, 0);
      if (b + 1 < blocks) add(2 * b + 1, around.through(b + 1, true, row_of(b + 1)), b + 1, 1);
    }
    const MatrixXd entering = system.partialPivLu().solve(right);
    const Index last = up ? 0 : blocks - 1;
    const int way = up ? 1 : 0;
    const double share = around.through(last, up, row_of(last));
    if (share > 0)
      for (int order = 0; order < kOrders; ++order)
        radiance[order](j, p) +=
            share * (rays[last][way].crossing * entering(2 * last + way, order) +
                     rays[last][way].emitted[order]);
  });
  std::array<MatrixXd, kHarmonicParts> parts;
  for (int order = 2; order < kOrders; ++order) parts[order - 2] = std::move(radiance[order]);
  if (has_rough_) {
    parts[kFirstPart] = std::move(radiance[1]);
    parts[kZeroPart] = std::move(radiance[0]);
  }
  return parts;
}

}  // namespace lamella
