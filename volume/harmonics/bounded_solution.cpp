#include "volume/harmonics/bounded_solution.h"

#include <tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "volume/harmonics/gmres.h"
#include "volume/quadrature/direction_sets.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxIterations = 300;
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

void subtract_from(std::vector<FaceLight>& sum, const std::vector<FaceLight>& term) {
  for (std::size_t b = 0; b < sum.size(); ++b) {
    sum[b].down -= term[b].down;
    sum[b].up -= term[b].up;
  }
}

bool is_dark(const ArrivingBeam& beam) {
  const auto is_none = [](double share) { return share == 0; };
  return std::all_of(beam.down.begin(), beam.down.end(), is_none) &&
         std::all_of(beam.up.begin(), beam.up.end(), is_none);
}

bool is_dark(const std::vector<FaceLight>& light) {
  for (const FaceLight& face : light)
    if (!face.down.isZero(0) || !face.up.isZero(0)) return false;
  return true;
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
  for (const int order : {1, 2, 3}) solve_order(i, order);
  solve_rest(i);
  take_energies(i);
  transport.surroundings().add_asked(leaving_, around_, step_between);
}

void BoundedSolution::find_beams() {
  const std::vector<StackElement>& elements = transport_.elements();
  const double from = wi_.z > 0 || elements.empty() ? 1 : elements.back().below;
  const StackBeamOf<OrderShares> beam = beam_by_order(elements, wi_, transport_.ground());
  const bool from_above = wi_.z > 0;
  const std::size_t blocks = transport_.blocks();
  for (int order = 0; order < kOrders; ++order) {
    ArrivingBeam& arriving = arriving_[order];
    arriving.azimuth = azimuth(-wi_);
    for (std::size_t k = 0; k <= blocks; ++k) {
      const OrderShares& down =
          k == 0 ? beam.down.front() : beam.down[transport_.place_below(k - 1)];
      const OrderShares& up = k == blocks ? beam.up.back() : beam.up[transport_.place_above(k)];
      const double outside = order == 0 ? 1 : 0;
      arriving.down.push_back(k > 0 ? down.of[order] : from_above ? outside : 0);
      arriving.up.push_back(k < blocks ? up.of[order] : from_above ? 0 : outside);
    }
  }
  for (std::size_t b = 0; b < blocks; ++b) {
    std::vector<BlockBeams::Beam> beams;
    const double index = transport_.surroundings().blocks()[b].index;
    const std::size_t above = transport_.place_above(b), below = transport_.place_below(b);
    const double mu = beam.mu[above];
    for (const bool down : {true, false}) {
      const OrderShares& power = down ? beam.down[above] : beam.up[below];
      if (mu > 0 && power.sum() > 0 && above < below)
        beams.push_back({refracted_to(wi_, from, index, down ? mu : -mu), power});
    }
    beams_.emplace_back(transport_, b, std::move(beams));
    first_.emplace_back();
    for (std::size_t n = 0; n < beams_.back().beams().size(); ++n)
      first_.back().push_back(beams_.back().first(n));
  }
  energies_.uncollided = (from_above ? beam.down.back() : beam.up.front()).sum();
  const OrderShares& back = from_above ? beam.up.front() : beam.down.back();
  energies_.mirrored = back.of[0];
  energies_.specular = back.sum();
  for (int order = 1; order < kOrders; ++order)
    (from_above ? energies_.up : energies_.down)[order - 1] = back.of[order];
  if (transport_.surroundings().is_closed()) energies_.uncollided = 0;
}

SurroundedLight BoundedSolution::raised(std::size_t i, int order) const {
  const BlockSurroundings& around = transport_.surroundings();
  SurroundedLight light;
  for (int from = 0; from <= order; ++from)
    if (from == 0 || !is_dark(arriving_[from]))
      light += around.from_beam(arriving_[from], i, step_between(from, order));
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

BoundedSolution::OfBeams BoundedSolution::of_beams(int order) const {
  OfBeams light;
  light.emitted = light.mirrored = transport_.no_light();
  const auto power = [order](const BlockBeams::Beam& beam) {
    const double last = beam.power.of[order - 1];
    return order == kOrders - 1 ? last + beam.power.of[order] : last;
  };
  bool is_any = false;
  for (const BlockBeams& block : beams_)
    for (const BlockBeams::Beam& beam : block.beams()) is_any = is_any || power(beam) > 0;
  if (is_any)
    for (std::size_t b = 0; b < beams_.size(); ++b) {
      light.scattered.push_back(
          MatrixXd::Zero(transport_.basis().size(), transport_.block(b).nodes()));
      for (std::size_t n = 0; n < first_[b].size(); ++n) {
        const BlockBeams::First& first = first_[b][n];
        const double share = power(beams_[b].beams()[n]);
        light.scattered[b] += share * first.scattered;
        light.emitted[b].down += share * first.emitted.down;
        light.emitted[b].up += share * first.emitted.up;
        light.absorbed += share * first.absorbed;
      }
      light.mirrored[b] = beams_[b].mirrored(light.emitted[b]);
    }
  light.leaving = light.emitted;
  for (std::size_t b = 0; b < beams_.size(); ++b) {
    const FaceLight crossing = crossed(b, light.mirrored[b]);
    light.leaving[b].down += crossing.down;
    light.leaving[b].up += crossing.up;
  }
  return light;
}

// Light of one event between two of which the boundaries keep the order is followed ray by ray
// (of_beams); all else is at the nodes.
void BoundedSolution::solve_order(std::size_t i, int order) {
  const OfBeams beams = of_beams(order);
  around_[order] = raised(i, order);
  BoundedSource source = no_source();
  source.coefficients = sources_[order];
  std::vector<FaceLight> emitted = transport_.follow(source, false).leaving;
  add_to(emitted, beams.emitted);
  source.entering = transport_.settled(transport_.grid_of(around_[order].entering), emitted);
  subtract_from(source.entering, beams.mirrored);
  BoundedStep step = transport_.follow(source, true);
  for (std::size_t b = 0; b < beams.scattered.size(); ++b) step.scattered[b] += beams.scattered[b];
  add_to(step.leaving, beams.leaving);
  energies_.absorbed += step.absorbed + beams.absorbed;
  sources_[order + 1] = std::move(step.scattered);
  leaving_[order] = transport_.waves_of(step.leaving);
  around_[order] +=
      transport_.surroundings().from_blocks(leaving_[order], step_between(order, order));
}

void BoundedSolution::solve_rest(std::size_t i) {
  const BlockSurroundings& around = transport_.surroundings();
  const OfBeams beams = of_beams(4);
  around_[4] = raised(i, 4);
  BoundedSource begin{sources_[4], transport_.grid_of(around_[4].entering)};
  for (std::size_t b = 0; b < beams.scattered.size(); ++b)
    begin.coefficients[b] += beams.scattered[b];
  if (!beams.scattered.empty()) {
    add_to(
        begin.entering,
        transport_.grid_of(
            around.from_blocks(transport_.waves_of(beams.leaving), step_between(4, 4)).entering));
    subtract_from(begin.entering, beams.mirrored);
  }
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
  BoundedStep step = transport_.follow(all, true);
  add_to(step.leaving, beams.leaving);
  energies_.absorbed += step.absorbed + beams.absorbed;
  sources_[4] = all.coefficients;
  leaving_[4] = transport_.waves_of(step.leaving);
  around_[4] += around.from_blocks(leaving_[4], step_between(4, 4));
}

void BoundedSolution::take_energies(std::size_t i) {
  const BlockSurroundings& around = transport_.surroundings();
  const auto flux = [](const DirectionSets& sets, const MatrixXd& waves) {
    return sets.flux.dot(waves.col(0).head(sets.nodes()));
  };
  for (int order = 0; order < kOrders; ++order) {
    BlockSurroundings::Taken taken = around.taken(arriving_[order], i);
    energies_.absorbed += taken.absorbed;
    energies_.lost += taken.lost;
    const double up = flux(around.top(), around_[order].outside.up);
    const double down = around.is_closed() ? 0 : flux(around.bottom(), around_[order].outside.down);
    (order == 0 ? energies_.zero_up : energies_.up[order - 1]) += up;
    (order == 0 ? energies_.zero_down : energies_.down[order - 1]) += down;
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
  for (std::size_t n = 0; n < beams_[b].beams().size(); ++n) {
    const double light = beams_[b].leaving(n, v, prepared.data());
    const OrderShares& power = beams_[b].beams()[n].power;
    for (int order = 0; order < kOrders; ++order)
      ray.emitted[std::min(order + 1, kOrders - 1)] += power.of[order] * light;
  }
  return ray;
}

// Along each ray what enters a block is what is diffuse there and what the faces mirror and let
// through: two unknowns per block. A conductor at the bottom mirrors light of one order into
// another.
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
    std::vector<std::array<Ray, 2>> rays(blocks);  // down, up
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
    // Rows: down, up of each block.
    MatrixXd entering = MatrixXd::Zero(2 * blocks, kOrders);
    for (int order = 0; order < kOrders; ++order) {
      MatrixXd system = MatrixXd::Identity(2 * blocks, 2 * blocks);
      VectorXd right(2 * blocks);
      const auto add = [&](Index to, double share, Index from_block, int way) {
        if (!(share > 0)) return;
        const Ray& ray = rays[from_block][way];
        system(to, 2 * from_block + way) -= share * ray.crossing;
        right[to] += share * ray.emitted[order];
      };
      const OrderStep same = step_between(order, order);
      for (Index b = 0; b < blocks; ++b) {
        right[2 * b] = diffuse[b][order].down(j, p);
        right[2 * b + 1] = diffuse[b][order].up(j, p);
      }
      for (Index b = 0; b < blocks; ++b) {
        add(2 * b, around.mirror(b, true, row_of(b), same), b, 1);
        add(2 * b + 1, around.mirror(b, false, row_of(b), same), b, 0);
        if (b > 0) add(2 * b, around.through(b - 1, false, row_of(b - 1)), b - 1, 0);
        if (b + 1 < blocks) add(2 * b + 1, around.through(b + 1, true, row_of(b + 1)), b + 1, 1);
      }
      const Index deepest = blocks - 1;
      for (int from = 0; from < order; ++from) {
        const double share =
            around.mirror(deepest, false, row_of(deepest), step_between(from, order));
        const Ray& ray = rays[deepest][0];
        right[2 * deepest + 1] +=
            share * (ray.crossing * entering(2 * deepest, from) + ray.emitted[from]);
      }
      entering.col(order) = system.partialPivLu().solve(right);
    }
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
