#include "volume/harmonics/block_surroundings.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "volume/adding/smooth_boundary.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

void add_to(MatrixXd& sum, const MatrixXd& term) {
  if (term.size() == 0) return;
  if (sum.size() == 0)
    sum = term;
  else
    sum += term;
}

// The part of a series that an order's step takes; empty: nothing.
template <class T, std::size_t kSize>
T taken_by(const std::array<T, kSize>& series, OrderStep step) {
  // Light that meets boundaries alone is kept once.
  if (step.kind == OrderStep::Kind::any) return series[series[0].size() > 0 ? 0 : kOrderZero];
  if (step.kind == OrderStep::Kind::by) return series[step.raise == 0 ? kOrderZero : step.raise];
  T rest = series[0];
  if (rest.size() == 0) return rest;
  for (int raise = 0; raise <= step.raise; ++raise) {
    const T& low = series[raise == 0 ? kOrderZero : raise];
    if (low.size() > 0) rest -= low;
  }
  return rest;
}

// The same of beams.
VectorXd mirrored_by(const BeamSeries& series, OrderStep step) {
  if (step.kind == OrderStep::Kind::any) return series[0];
  if (step.kind == OrderStep::Kind::by) return series[step.raise == 0 ? kOrderZero : step.raise];
  return taken_by(series, step);
}

bool keeps_order(OrderStep step) {
  return step.kind == OrderStep::Kind::any || (step.kind == OrderStep::Kind::by && step.raise == 0);
}

// All light goes through, and stays what it is.
PileOperator nothing(const DirectionSets& sets, int mode) {
  PileOperator pile{&sets, &sets, {}, {}, true};
  for (PileSide* side : {&pile.above, &pile.below}) {
    for (const auto& [beams, size] :
         {std::pair{&side->in, sets.in.size()}, std::pair{&side->out, sets.out.size()}}) {
      beams->direct = VectorXd::Ones(size);
      beams->met = beams->gone = VectorXd::Zero(size);
    }
    if (mode == 0) side->absorbed = side->lost = RowVectorXd::Zero(sets.in.size());
  }
  return pile;
}

// Of a boundary that is kept apart: beams end there.
PileOperator apart(const DirectionSets& above, const DirectionSets& below, bool is_open, int mode) {
  PileOperator pile{&above, &below, {}, {}, is_open};
  for (const auto& [side, sets] :
       {std::pair{&pile.above, &above}, std::pair{&pile.below, &below}}) {
    side->in.met = side->in.gone = VectorXd::Ones(sets->in.size());
    side->out.met = side->out.gone = VectorXd::Ones(sets->out.size());
    if (mode == 0) side->absorbed = side->lost = RowVectorXd::Zero(sets->in.size());
  }
  return pile;
}

// Whether what raises an order by that takes part in a step.
bool takes(OrderStep step, int raise) {
  if (step.kind == OrderStep::Kind::any) return true;
  return step.kind == OrderStep::Kind::by ? raise == step.raise : raise > step.raise;
}

// Matrices that hold nothing, and the sum over all orders where it is order 0.
void drop_what_is_known(PileOperator& pile) {
  for (PileSide* side : {&pile.above, &pile.below})
    for (PileSeries* series : {&side->r, &side->t}) {
      for (MatrixXd& m : *series)
        if (m.size() > 0 && m.isZero(0)) m.resize(0, 0);
      MatrixXd& all = (*series)[0];
      const MatrixXd& zero = (*series)[kOrderZero];
      if (all.size() > 0 && all.size() == zero.size() && all == zero) all.resize(0, 0);
    }
}

VectorXd rows_of(const DirectionSets& from, const DirectionSets& to, const VectorXd& share) {
  const Index common = std::min(from.nodes(), to.nodes());
  VectorXd result = VectorXd::Zero(to.out.size());
  const double step = to.index / from.index;
  result.head(common) = step * step * share.head(common);
  const Index asked = to.out.size() - to.nodes();
  result.tail(asked) = step * step * share.tail(asked);
  return result;
}

}  // namespace

SurroundedLight& SurroundedLight::operator+=(const SurroundedLight& other) {
  if (entering.empty()) entering.resize(other.entering.size());
  for (std::size_t b = 0; b < other.entering.size(); ++b) {
    add_to(entering[b].down, other.entering[b].down);
    add_to(entering[b].up, other.entering[b].up);
  }
  add_to(outside.down, other.outside.down);
  add_to(outside.up, other.outside.up);
  return *this;
}

BlockSurroundings::BlockSurroundings(const Stack& stack, int channel,
                                     std::vector<LayerBlock> blocks, int nodes, int modes,
                                     int degree, std::span<const AskedCosine> asked_out,
                                     std::span<const AskedCosine> asked_in, Isa isa,
                                     SharedBoundaries* shared)
    : blocks_(std::move(blocks)) {
  const RefractiveNodes refractive{indices_of(stack), nodes, grazing_map(stack)};
  for (std::size_t k = 0; k <= blocks_.size(); ++k) {
    const std::size_t begin = k == 0 ? 0 : blocks_[k - 1].end;
    const bool is_last = k == blocks_.size();
    const std::size_t end = is_last ? stack.layers.size() : blocks_[k].begin;
    elements_.push_back(elements_between(stack, begin, end));
    const bool is_ground = is_last && stack.substrate;
    std::vector<PileOperator>& pile = piles_.emplace_back(modes);
    anisotropic_.emplace_back();
    const Interface* face = elements_.back().empty() ? nullptr : elements_.back().front().interface;
    if (is_ground && elements_.back().empty() && stack.substrate->law &&
        !stack.substrate->law->is_symmetric_about_z()) {
      const DirectionSets& sets =
          plain_.emplace_back(refractive, stack.index_of(begin), asked_out, asked_in);
      for (int m = 0; m < modes; ++m) pile[m] = apart(sets, sets, false, m);
      anisotropic_.back() = std::make_unique<AnisotropicBoundary>(stack.substrate->law, channel,
                                                                  sets, degree, MatrixProduct(isa));
    } else if (face && face->facets.alpha_x != face->facets.alpha_y) {
      const DirectionSets& above =
          plain_.emplace_back(refractive, elements_.back().front().above, asked_out, asked_in);
      const DirectionSets& below =
          plain_.emplace_back(refractive, elements_.back().front().below, asked_out, asked_in);
      for (int m = 0; m < modes; ++m) pile[m] = apart(above, below, true, m);
      const auto made = shared ? (*shared)[k] : nullptr;
      anisotropic_.back() = std::make_unique<AnisotropicBoundary>(*face, above, below, degree,
                                                                  MatrixProduct(isa), made);
      if (shared) (*shared)[k] = anisotropic_.back()->operators();
    } else if (elements_.back().empty() && !is_ground) {
      const DirectionSets& sets =
          plain_.emplace_back(refractive, stack.index_of(begin), asked_out, asked_in);
      // Below a half space's nodes lies what sends back all that arrives (LayeredStreams::is_cut).
      const bool sends_back = is_last && stack.is_half_space() && !(stack.one_sidedness() < 0);
      for (int m = 0; m < modes; ++m)
        pile[m] = sends_back ? lambert_ground(1, sets, m) : nothing(sets, m);
    } else {
      PileModes& solver = modes_.emplace_back(stack, channel, nodes, asked_out, asked_in, 3, isa,
                                              PileRange{begin, end, is_ground});
      solver.prepare(modes);
      tbb::parallel_for(0, modes, [&](int m) {
        pile[m] = solver.operator_at(m);
        drop_what_is_known(pile[m]);
      });
      solver.forget_kernels();
    }
  }
}

std::size_t BlockSurroundings::bytes() const {
  Index entries = 0;
  for (const Pile& pile : piles_)
    for (const PileOperator& mode : pile)
      for (const PileSide* side : {&mode.above, &mode.below})
        for (const PileSeries* series : {&side->r, &side->t})
          for (const MatrixXd& m : *series) entries += m.size();
  std::size_t sum = static_cast<std::size_t>(entries) * sizeof(double);
  for (const auto& boundary : anisotropic_)
    if (boundary) sum += boundary->bytes();
  return sum;
}

const DirectionSets& BlockSurroundings::sets(std::size_t block) const {
  return *piles_[block].front().bottom;
}

SurroundedLight BlockSurroundings::from_blocks(const std::vector<FaceLight>& leaving,
                                               OrderStep step) const {
  SurroundedLight light;
  light.entering.resize(blocks_.size());
  const auto pass = [&](const Pile& pile, PileSide PileOperator::*which, const MatrixXd& waves,
                        MatrixXd& reflected, MatrixXd& transmitted) {
    const PileOperator& first = pile.front();
    const bool from_above = which == &PileOperator::above;
    const DirectionSets& here = from_above ? *first.top : *first.bottom;
    const DirectionSets& there = from_above ? *first.bottom : *first.top;
    const Index nodes = here.nodes();
    const MatrixXd arriving = here.flux.asDiagonal() * waves;
    MatrixXd back = MatrixXd::Zero(here.out.size(), waves.cols());
    MatrixXd on = MatrixXd::Zero(there.out.size(), waves.cols());
    tbb::parallel_for(0, static_cast<int>(pile.size()), [&](int m) {
      const PileSide& side = pile[m].*which;
      const Index wave = m == 0 ? 0 : 2 * m - 1, count = m == 0 ? 1 : 2;
      const auto apply = [&](const PileSeries& series, MatrixXd& result) {
        const MatrixXd f = taken_by(series, step);
        if (f.size() > 0)
          result.middleCols(wave, count) += f.leftCols(nodes) * arriving.middleCols(wave, count);
      };
      apply(side.r, back);
      apply(side.t, on);
    });
    // Beams, at the nodes; those along asked cosines are followed ray by ray.
    const BeamShares& beams = (first.*which).out;
    const VectorXd mirror = mirrored_by(beams.mirror, step);
    if (mirror.size() > 0) back.topRows(nodes) += mirror.head(nodes).asDiagonal() * waves;
    if (keeps_order(step)) {
      if (beams.direct.size() > 0) {
        const VectorXd share = rows_of(here, there, beams.direct);
        const Index common = std::min(nodes, there.nodes());
        on.topRows(common) += share.head(common).asDiagonal() * waves.topRows(common);
      }
    }
    add_to(reflected, back);
    add_to(transmitted, on);
  };
  for (std::size_t k = 0; k < piles_.size(); ++k) {
    MatrixXd& up = k == 0 ? light.outside.up : light.entering[k - 1].up;
    MatrixXd& down = k == blocks_.size() ? light.outside.down : light.entering[k].down;
    if (const auto& boundary = anisotropic_[k]) {
      FaceLight there = boundary->from(arriving_at(k, leaving));
      if (!takes(step, boundary->raise())) {
        there.down.setZero();
        there.up.setZero();
      }
      add_to(up, there.up);
      add_to(down, there.down);
      continue;
    }
    if (k > 0) pass(piles_[k], &PileOperator::above, leaving[k - 1].down, up, down);
    if (k < blocks_.size()) pass(piles_[k], &PileOperator::below, leaving[k].up, down, up);
  }
  return light;
}

SurroundedLight BlockSurroundings::from_beam(const ArrivingBeam& beam, std::size_t in,
                                             OrderStep step) const {
  SurroundedLight light;
  light.entering.resize(blocks_.size());
  const auto column = [&](const Pile& pile, PileSide PileOperator::*which,
                          PileSeries PileSide::*way, double power, MatrixXd& result) {
    const bool from_above = which == &PileOperator::above;
    const PileOperator& first = pile.front();
    const DirectionSets& here = from_above ? *first.top : *first.bottom;
    const DirectionSets& there = (way == &PileSide::r) == from_above ? *first.top : *first.bottom;
    MatrixXd sum = MatrixXd::Zero(there.out.size(), waves());
    if (power > 0)
      for (std::size_t m = 0; m < pile.size(); ++m) {
        const MatrixXd f = taken_by(pile[m].*which.*way, step);
        if (f.size() == 0) continue;
        const VectorXd mode = power * f.col(here.nodes() + static_cast<Index>(in));
        if (m == 0) {
          sum.col(0) += mode;
          continue;
        }
        const double wave = static_cast<double>(m) * beam.azimuth;
        sum.col(2 * static_cast<Index>(m) - 1) += std::sqrt(2.0) * std::cos(wave) * mode;
        sum.col(2 * static_cast<Index>(m)) += std::sqrt(2.0) * std::sin(wave) * mode;
      }
    add_to(result, sum);
  };
  for (std::size_t k = 0; k < piles_.size(); ++k) {
    MatrixXd& up = k == 0 ? light.outside.up : light.entering[k - 1].up;
    MatrixXd& down = k == blocks_.size() ? light.outside.down : light.entering[k].down;
    if (const auto& boundary = anisotropic_[k]) {
      const double share = takes(step, boundary->raise()) ? 1 : 0;
      const FaceLight there = boundary->from_beam(
          beam.azimuth, static_cast<Index>(in), share * beam.down[k], share * beam.up[k], waves());
      add_to(up, there.up);
      add_to(down, there.down);
      continue;
    }
    column(piles_[k], &PileOperator::above, &PileSide::r, beam.down[k], up);
    column(piles_[k], &PileOperator::above, &PileSide::t, beam.down[k], down);
    if (!piles_[k].front().is_open) continue;
    column(piles_[k], &PileOperator::below, &PileSide::r, beam.up[k], down);
    column(piles_[k], &PileOperator::below, &PileSide::t, beam.up[k], up);
  }
  return light;
}

FaceLight BlockSurroundings::arriving_at(std::size_t pile,
                                         const std::vector<FaceLight>& leaving) const {
  const auto none = [&](const DirectionSets& sets) {
    return MatrixXd(MatrixXd::Zero(sets.nodes(), waves()));
  };
  return {pile > 0 ? leaving[pile - 1].down : none(*piles_[pile].front().top),
          pile < blocks_.size() ? leaving[pile].up : none(*piles_[pile].front().bottom)};
}

void BlockSurroundings::add_asked(std::span<const std::vector<FaceLight>> leaving,
                                  std::span<SurroundedLight> around,
                                  const std::function<OrderStep(int, int)>& step) const {
  for (std::size_t k = 0; k < piles_.size(); ++k) {
    if (!anisotropic_[k]) continue;
    std::vector<FaceLight> arriving, there(around.size());
    for (std::size_t to = 0; to < around.size(); ++to) {
      FaceLight& light = arriving.emplace_back();
      for (std::size_t from = 0; from <= to; ++from) {
        if (!takes(step(static_cast<int>(from), static_cast<int>(to)), anisotropic_[k]->raise()))
          continue;
        const FaceLight term = arriving_at(k, leaving[from]);
        add_to(light.down, term.down);
        add_to(light.up, term.up);
      }
      const PileOperator& pile = piles_[k].front();
      there[to].up = MatrixXd::Zero(pile.top->out.size(), waves());
      if (pile.is_open) there[to].down = MatrixXd::Zero(pile.bottom->out.size(), waves());
    }
    anisotropic_[k]->add_asked(arriving, there);
    for (std::size_t to = 0; to < around.size(); ++to) {
      add_to(k == 0 ? around[to].outside.up : around[to].entering[k - 1].up, there[to].up);
      add_to(k == blocks_.size() ? around[to].outside.down : around[to].entering[k].down,
             there[to].down);
    }
  }
}

BlockSurroundings::Taken BlockSurroundings::taken(const std::vector<FaceLight>& leaving) const {
  Taken taken;
  const auto add = [&](const PileSide& side, const DirectionSets& sets, const MatrixXd& waves) {
    const VectorXd irradiance = sets.flux.cwiseProduct(waves.col(0));
    taken.absorbed += side.absorbed.head(sets.nodes()).dot(irradiance);
    taken.lost += side.lost.head(sets.nodes()).dot(irradiance);
  };
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    add(piles_[b].front().below, *piles_[b].front().bottom, leaving[b].up);
    add(piles_[b + 1].front().above, *piles_[b + 1].front().top, leaving[b].down);
  }
  for (std::size_t k = 0; k < piles_.size(); ++k)
    if (anisotropic_[k]) {
      const AnisotropicBoundary::Taken there = anisotropic_[k]->taken(arriving_at(k, leaving));
      taken.absorbed += there.absorbed;
      taken.lost += there.lost;
    }
  return taken;
}

BlockSurroundings::Taken BlockSurroundings::taken(const ArrivingBeam& beam, std::size_t in) const {
  Taken taken;
  const auto add = [&](const PileSide& side, const DirectionSets& sets, double power) {
    if (!(power > 0)) return;
    const Index place = sets.nodes() + static_cast<Index>(in);
    taken.absorbed += power * side.absorbed[place];
    taken.lost += power * side.lost[place];
  };
  for (std::size_t k = 0; k < piles_.size(); ++k) {
    const PileOperator& pile = piles_[k].front();
    add(pile.above, *pile.top, beam.down[k]);
    if (pile.is_open) add(pile.below, *pile.bottom, beam.up[k]);
    if (anisotropic_[k]) {
      const AnisotropicBoundary::Taken there = anisotropic_[k]->taken_of_beam(
          beam.azimuth, static_cast<Index>(in), beam.down[k], pile.is_open ? beam.up[k] : 0);
      taken.absorbed += there.absorbed;
      taken.lost += there.lost;
    }
  }
  return taken;
}

double BlockSurroundings::mirror(std::size_t block, bool at_top, Index row, OrderStep step) const {
  const PileOperator& pile = piles_[at_top ? block : block + 1].front();
  const BeamSeries& series = (at_top ? pile.below : pile.above).out.mirror;
  const auto at = [&](int k) { return series[k].size() > 0 ? series[k][row] : 0; };
  if (step.kind == OrderStep::Kind::any) return at(0);
  if (step.kind == OrderStep::Kind::by) return at(step.raise == 0 ? kOrderZero : step.raise);
  double rest = at(0);
  for (int raise = 0; raise <= step.raise; ++raise) rest -= at(raise == 0 ? kOrderZero : raise);
  return rest;
}

double BlockSurroundings::through(std::size_t block, bool up, Index row) const {
  const PileOperator& pile = piles_[up ? block : block + 1].front();
  const VectorXd& direct = (up ? pile.below : pile.above).out.direct;
  if (direct.size() == 0) return 0;
  const DirectionSets& there = up ? *pile.top : *pile.bottom;
  const double step = there.index / sets(block).index;
  return step * step * direct[row];
}

double BlockSurroundings::mirror_at(std::size_t block, bool at_top, double mu) const {
  const std::vector<StackElement>& elements = elements_[at_top ? block : block + 1];
  if (elements.empty()) return 0;
  const double sine = std::sqrt((1 - mu) * (1 + mu));
  const StackBeam beam = beam_of(elements, {sine, 0, at_top ? -mu : mu}, false);
  return at_top ? beam.down.back() : beam.up.front();
}

}  // namespace lamella
