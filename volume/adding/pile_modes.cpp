#include "volume/adding/pile_modes.h"

#include <algorithm>

#include "volume/adding/doubling.h"
#include "volume/adding/smooth_boundary.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kFirstModes = 8;

}  // namespace

std::vector<double> indices_of(const Stack& stack) {
  std::vector<double> indices;
  for (std::size_t k = 0; k <= stack.layers.size(); ++k) indices.push_back(stack.index_of(k));
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  return indices;
}

PileModes::PileModes(const Stack& stack, int channel, int nodes,
                     std::span<const AskedCosine> asked_out, std::span<const AskedCosine> asked_in,
                     int orders, Isa isa)
    : PileModes(stack, channel, nodes, asked_out, asked_in, orders, isa,
                {0, stack.layers.size(), stack.substrate.has_value()}) {}

PileModes::PileModes(const Stack& stack, int channel, int nodes,
                     std::span<const AskedCosine> asked_out, std::span<const AskedCosine> asked_in,
                     int orders, Isa isa, PileRange range)
    : stack_(stack), channel_(channel), orders_(orders), isa_(isa), range_(range) {
  const RefractiveNodes refractive{indices_of(stack), nodes, grazing_map(stack)};
  for (const double index : refractive.indices)
    sets_.emplace_back(refractive, index, asked_out, asked_in);
  top_ = bottom_ = &sets_of(stack.index_of(range.begin));
  for (std::size_t k = range.begin; k < range.end; ++k) {
    const Layer& layer = stack.layers[k];
    if (layer.interface) {
      const DirectionSets& below = sets_of(layer.interface->ior);
      if (&below != bottom_)
        elements_.push_back({std::nullopt, &*layer.interface, bottom_, &below});
      bottom_ = &below;
      continue;
    }
    if (layer.depth() == 0) continue;
    const auto kind = std::find_if(kinds_.begin(), kinds_.end(), [&](const Kind& other) {
      return other.sets == bottom_ && other.layer->albedo[channel] == layer.albedo[channel] &&
             other.layer->f0[channel] == layer.f0[channel] && other.layer->medium == layer.medium;
    });
    const std::size_t kind_index = kind - kinds_.begin();
    if (kind == kinds_.end()) kinds_.push_back({&layer, bottom_, std::nullopt});
    const auto slab = std::find_if(slabs_.begin(), slabs_.end(), [&](const Slab& s) {
      return s.kind == kind_index && s.depth == layer.depth();
    });
    elements_.push_back({slab - slabs_.begin(), nullptr, bottom_, bottom_, &layer});
    if (slab == slabs_.end()) slabs_.push_back({kind_index, layer.depth()});
  }
}

const DirectionSets& PileModes::sets_of(double index) const {
  return *std::find_if(sets_.begin(), sets_.end(),
                       [&](const DirectionSets& s) { return s.index == index; });
}

void PileModes::prepare(int modes) {
  if (modes > ready_) make_kernels(std::max(modes, std::max(kFirstModes, 2 * ready_)));
}

bool PileModes::prepare_more(std::size_t max_bytes) {
  int modes = std::max(kFirstModes, 2 * ready_);
  if (bytes_of(modes) > max_bytes) modes = static_cast<int>(max_bytes / bytes_of(1));
  if (modes <= ready_) return false;
  make_kernels(modes);
  return true;
}

void PileModes::forget_kernels() {
  ready_ = 0;
  for (Kind& kind : kinds_) kind.scattering.reset();
  for (Element& e : elements_) e.rough.reset();
  ground_.reset();
  crossing_.reset();
}

void PileModes::make_kernels(int modes) {
  ready_ = modes;
  for (Kind& kind : kinds_) {
    kind.scattering.reset();
    kind.scattering.emplace(kind.layer->medium, kind.layer->albedo[channel_],
                            kind.layer->f0[channel_], *kind.sets, ready_);
  }
  for (Element& e : elements_) e.rough.reset();
  for (Element& e : elements_) {
    if (!e.interface || e.interface->facets.shape == FacetShape::smooth) continue;
    // The faces of a plate are often the same.
    const auto turned = std::find_if(elements_.begin(), elements_.end(), [&](const Element& other) {
      return other.rough && other.above == e.below && other.below == e.above &&
             other.interface->facets == e.interface->facets &&
             other.interface->masking == e.interface->masking;
    });
    if (turned != elements_.end())
      e.rough = turned->rough->turned();
    else
      e.rough.emplace(*e.interface, *e.above, *e.below, ready_);
  }
  if (is_rough_plate()) {
    std::vector<const Layer*> layers;
    for (const Element& e : elements_)
      if (e.slab) layers.push_back(e.layer);
    const Element &upper = elements_.front(), &lower = elements_.back();
    crossing_.reset();
    crossing_.emplace(*upper.interface, *lower.interface, *top_, *upper.below, *bottom_,
                      std::move(layers), ready_);
  }
  if (range_.has_ground && stack_.substrate->law) {
    ground_.reset();
    ground_.emplace(stack_.substrate->law, channel_, *bottom_, ready_);
  }
}

std::size_t PileModes::bytes_of(int modes) const {
  std::size_t entries = 1;
  for (const Kind& kind : kinds_)
    entries += 4 * static_cast<std::size_t>(kind.sets->out.size() * kind.sets->in.size());
  const auto pairs = [](const DirectionSets& out, const DirectionSets& in) {
    return static_cast<std::size_t>(out.out.size() * in.in.size());
  };
  for (const Element& e : elements_)
    if (e.interface && e.interface->facets.shape != FacetShape::smooth)
      entries += pairs(*e.above, *e.above) + pairs(*e.above, *e.below) + pairs(*e.below, *e.above) +
                 pairs(*e.below, *e.below);
  if (range_.has_ground && stack_.substrate->law) entries += pairs(*bottom_, *bottom_);
  return entries * static_cast<std::size_t>(modes) * sizeof(double);
}

bool PileModes::is_rough_plate() const {
  if (stack_.substrate || elements_.size() < 2) return false;
  if (range_.begin > 0 || range_.end < stack_.layers.size()) return false;
  const auto is_rough = [](const Element& e) {
    return e.interface && e.interface->facets.shape != FacetShape::smooth;
  };
  return is_rough(elements_.front()) && is_rough(elements_.back()) &&
         std::all_of(elements_.begin() + 1, elements_.end() - 1,
                     [](const Element& e) { return e.slab.has_value(); });
}

void PileModes::correct_crossing(AskedMode& mode, int m) const {
  const DirectionSets& between = *elements_.front().below;
  const PileOperator upper = elements_.front().rough->at(m), lower = elements_.back().rough->at(m);
  const auto correct = [&](bool down) {
    const DirectionSets &from = down ? *top_ : *bottom_, &to = down ? *bottom_ : *top_;
    const MatrixXd& first = down ? upper.above.t[0] : lower.below.t[0];
    const MatrixXd& second = down ? lower.above.t[0] : upper.below.t[0];
    const Index nodes = between.nodes();
    VectorXd share(nodes);
    for (Index j = 0; j < nodes; ++j)
      share[j] = between.flux[j] * crossing_->survives(between.in[j], down);
    MatrixXd change = (down ? crossing_->down : crossing_->up)[m] -
                      second.bottomLeftCorner(second.rows() - to.nodes(), nodes) *
                          share.asDiagonal() *
                          first.topRightCorner(nodes, first.cols() - from.nodes());
    for (std::size_t i = 0; i < to.out_exists.size(); ++i)
      if (!to.out_exists[i]) change.row(static_cast<Index>(i)).setZero();
    for (std::size_t j = 0; j < from.in_exists.size(); ++j)
      if (!from.in_exists[j]) change.col(static_cast<Index>(j)).setZero();
    for (const int series : {0, static_cast<int>(kOrderZero)})
      mode.series[series][down ? kAboveToDown : kBelowToUp] += change;
  };
  correct(true);
  correct(false);
}

PileOperator PileModes::element(const Element& e, int m) const {
  if (e.rough) return e.rough->at(m);
  return smooth_boundary(*e.above, *e.below, m);
}

PileOperator PileModes::ground(int m) const {
  if (ground_) return ground_->at(m);
  return lambert_ground(stack_.substrate->albedo[channel_], *bottom_, m);
}

PileOperator PileModes::pile(int m) const {
  const PileRules rules{m, orders_, MatrixProduct(isa_)};
  std::vector<PileOperator> solved;
  for (const Slab& slab : slabs_) {
    const Kind& kind = kinds_[slab.kind];
    solved.push_back(pile_of(homogeneous_layer(*kind.scattering, slab.depth,
                                               {*kind.sets, m, orders_, MatrixProduct(isa_)}),
                             *kind.scattering, slab.depth, *kind.sets));
    solved.back().is_open = !std::isinf(slab.depth);
  }
  const auto made = [&](const Element& e) { return e.slab ? solved[*e.slab] : element(e, m); };
  if (elements_.empty()) return ground(m);
  std::size_t k = elements_.size();
  PileOperator pile = range_.has_ground ? ground(m) : made(elements_[--k]);
  while (k-- > 0) pile = add_piles(made(elements_[k]), pile, rules);
  return pile;
}

AskedMode PileModes::asked_mode(int m) const {
  const PileOperator op = pile(m);
  const Index top = top_->nodes(), bottom = bottom_->nodes();
  AskedMode result;
  for (int k = 0; k < kPileSeries; ++k) {
    const bool must = k != kOrderZero;  // nothing stands as zeros
    const auto block = [&](const MatrixXd& r, Index row_nodes, Index column_nodes) {
      if (must && r.size() == 0)
        return MatrixXd(MatrixXd::Zero(top_->out.size() - top, top_->in.size() - top));
      return asked_block(r, row_nodes, column_nodes);
    };
    Parts& parts = result.series[k];
    parts[kAboveToUp] = block(op.above.r[k], top, top);
    parts[kAboveToDown] = block(op.above.t[k], bottom, top);
    parts[kBelowToDown] = block(op.below.r[k], bottom, bottom);
    parts[kBelowToUp] = block(op.below.t[k], top, bottom);
    // Directions that only the other side has.
    const auto clear = [&](Part part, const DirectionSets& to, const DirectionSets& from) {
      if (parts[part].size() == 0) return;
      for (std::size_t i = 0; i < to.out_exists.size(); ++i)
        if (!to.out_exists[i]) parts[part].row(static_cast<Index>(i)).setZero();
      for (std::size_t j = 0; j < from.in_exists.size(); ++j)
        if (!from.in_exists[j]) parts[part].col(static_cast<Index>(j)).setZero();
    };
    clear(kAboveToUp, *top_, *top_);
    clear(kAboveToDown, *bottom_, *top_);
    clear(kBelowToDown, *bottom_, *bottom_);
    clear(kBelowToUp, *top_, *bottom_);
  }
  if (crossing_) correct_crossing(result, m);
  if (m > 0) return result;
  const auto energies = [&](const PileSide& side, const DirectionSets& entry,
                            const DirectionSets& exit) {
    AskedEnergies e;
    const Index asked = entry.in.size() - entry.nodes();
    for (int k = 0; k < kPileSeries; ++k) {
      const auto sum = [&](const MatrixXd& f, const DirectionSets& sets) -> VectorXd {
        if (f.size() == 0) return VectorXd::Zero(asked);
        return (sets.flux.transpose() * f.topRightCorner(sets.nodes(), asked)).transpose();
      };
      e.reflected[k] = sum(side.r[k], entry);
      e.transmitted[k] = sum(side.t[k], exit);
      if (side.in.mirror[k].size() > 0) e.mirrored[k] = side.in.mirror[k].tail(asked);
    }
    e.direct = side.in.direct.size() > 0 ? VectorXd(side.in.direct.tail(asked))
                                         : VectorXd(VectorXd::Zero(asked));
    e.absorbed = side.absorbed.tail(asked).transpose();
    e.lost = side.lost.tail(asked).transpose();
    for (Index j = 0; j < asked; ++j) {
      if (entry.in_exists[j]) continue;
      for (int k = 0; k < kPileSeries; ++k) {
        e.reflected[k][j] = e.transmitted[k][j] = 0;
        if (e.mirrored[k].size() > 0) e.mirrored[k][j] = 0;
      }
      e.absorbed[j] = e.lost[j] = 0;
      e.direct[j] = 1;
    }
    return e;
  };
  result.energies[0] = energies(op.above, *top_, *bottom_);
  if (op.is_open) result.energies[1] = energies(op.below, *bottom_, *top_);
  return result;
}

}  // namespace lamella
