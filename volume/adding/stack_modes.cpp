#include "volume/adding/stack_modes.h"

#include <algorithm>

#include "volume/adding/doubling.h"

namespace lamella {

GrazingMap grazing_map(const Stack& stack) {
  constexpr double kPeaked = 0.6, kKnee = 0.15;
  for (const Layer& layer : stack.layers)
    if (!layer.interface && std::abs(traits(layer.medium).mean_cosine) > kPeaked)
      return GrazingMap(kKnee);
  return {};
}

StackModes::StackModes(const Stack& stack, int channel, DirectionSets sets, int orders, Isa isa)
    : stack_(stack), channel_(channel), sets_(std::move(sets)), orders_(orders), isa_(isa) {
  for (const Layer& layer : stack.layers) {
    const auto kind = std::find_if(kinds_.begin(), kinds_.end(), [&](const Kind& k) {
      return k.layer->albedo[channel] == layer.albedo[channel] &&
             k.layer->f0[channel] == layer.f0[channel] && k.layer->medium == layer.medium;
    });
    const std::size_t kind_index = kind - kinds_.begin();
    if (kind == kinds_.end()) kinds_.push_back({&layer, {}});
    const auto slab = std::find_if(slabs_.begin(), slabs_.end(), [&](const Slab& s) {
      return s.kind == kind_index && s.depth == layer.depth();
    });
    layers_.push_back(slab - slabs_.begin());
    if (slab == slabs_.end()) slabs_.push_back({kind_index, layer.depth()});
  }
}

namespace {

constexpr int kFirstModes = 8;

// What a mode's operator does between directions that were asked for.
AskedMode asked_of(const LayerOperator& op, const DirectionSets& sets, int m) {
  using Eigen::Index;
  using Eigen::VectorXd;
  const Index nodes = sets.nodes(), asked = sets.in.size() - nodes;
  AskedMode result;
  for (int k = 0; k < kSeries; ++k) {
    result.series[k][kAboveToUp] = asked_block(op.above.r[k], nodes, nodes);
    result.series[k][kAboveToDown] = asked_block(op.above.t[k], nodes, nodes);
    result.series[k][kBelowToDown] = asked_block(op.below.r[k], nodes, nodes);
    result.series[k][kBelowToUp] = asked_block(op.below.t[k], nodes, nodes);
  }
  if (m > 0) return result;
  for (const bool below : {false, true}) {
    const OperatorSide& side = below ? op.below : op.above;
    AskedEnergies& e = result.energies[below];
    const auto sum = [&](const Eigen::MatrixXd& f) {
      VectorXd energies = VectorXd::Zero(asked);
      if (f.size() == 0) return energies;
      for (Index j = 0; j < asked; ++j) energies[j] = sets.flux.dot(f.col(nodes + j).head(nodes));
      return energies;
    };
    for (int k = 0; k < kSeries; ++k) {
      e.reflected[k] = sum(side.r[k]);
      e.transmitted[k] = sum(side.t[k]);
    }
    e.reflected[kOrderZero] = e.transmitted[kOrderZero] = VectorXd::Zero(asked);
    e.direct = side.direct_in.tail(asked);
    e.absorbed = side.absorbed.tail(asked).transpose();
    e.lost = VectorXd::Zero(asked);
  }
  return result;
}

}  // namespace

void StackModes::prepare(int modes) {
  if (modes > ready_) make_kernels(std::max(modes, std::max(kFirstModes, 2 * ready_)));
}

bool StackModes::prepare_more(std::size_t max_bytes) {
  int modes = std::max(kFirstModes, 2 * ready_);
  if (bytes_of(modes) > max_bytes) modes = static_cast<int>(max_bytes / bytes_of(1));
  if (modes <= ready_) return false;
  make_kernels(modes);
  return true;
}

void StackModes::make_kernels(int modes) {
  ready_ = modes;
  for (Kind& kind : kinds_) {
    kind.scattering.clear();
    kind.scattering.emplace_back(kind.layer->medium, kind.layer->albedo[channel_],
                                 kind.layer->f0[channel_], sets_, ready_, MatrixProduct(isa_));
  }
  if (!modal_.empty() || modes < 2) return;
  const auto scope = layers_.size() == 1 ? ModalLayer::Scope::asked : ModalLayer::Scope::layers;
  for (const Slab& slab : slabs_) {
    const LayerScattering& scattering = kinds_[slab.kind].scattering[0];
    if (!scattering.two_sided) {
      modal_.clear();
      break;
    }
    modal_.emplace_back(scattering, sets_, slab.depth, scope, orders_);
  }
}

LayerOperator StackModes::mode(int m) const {
  const OperatorRules rules{sets_, m, orders_, MatrixProduct(isa_)};
  std::vector<LayerOperator> solved;
  for (const Slab& slab : slabs_)
    solved.push_back(doubled_layer(kinds_[slab.kind].scattering[0], slab.depth, rules));
  return pile(solved, rules);
}

LayerOperator StackModes::pile(std::span<const LayerOperator> solved,
                               const OperatorRules& rules) const {
  if (layers_.empty() && stack_.substrate)
    return lambert_substrate(stack_.substrate->albedo[channel_], rules);
  LayerOperator pile;
  if (layers_.empty()) return empty_layer(rules);
  pile = stack_.substrate
             ? add_layers(solved[layers_.back()],
                          lambert_substrate(stack_.substrate->albedo[channel_], rules), rules)
             : solved[layers_.back()];
  for (std::size_t k = layers_.size() - 1; k-- > 0;)
    pile = add_layers(solved[layers_[k]], pile, rules);
  return pile;
}

std::optional<AskedMode> StackModes::asked_by_eigenmodes(int m) const {
  // In mode 0 substrates answer, and sums of layers need to know what is absorbed.
  if (modal_.empty() || (m == 0 && (layers_.size() > 1 || stack_.substrate))) return std::nullopt;
  const OperatorRules rules{sets_, m, orders_, MatrixProduct(isa_)};
  const auto scattering = [&](std::size_t slab) -> const LayerScattering& {
    return kinds_[slabs_[slab].kind].scattering[0];
  };
  const bool is_open = !stack_.substrate;
  if (layers_.size() == 1) {
    auto series = modal_[0].series(scattering(0), m, rules.product);
    if (!series) return std::nullopt;
    AskedMode result;
    for (int k = 0; k < kSeries; ++k) {
      auto &r = (*series)[0][k], &t = (*series)[1][k];
      // A Lambertian substrate takes what arrives and answers in mode 0 alone.
      if (!is_open) t.setZero();
      result.series[k][kBelowToDown] = is_open ? r : t;
      result.series[k][kBelowToUp] = t;
      result.series[k][kAboveToUp] = std::move(r);
      result.series[k][kAboveToDown] = std::move(t);
    }
    return result;
  }
  std::vector<LayerOperator> solved;
  for (std::size_t k = 0; k < slabs_.size(); ++k) {
    std::optional<LayerOperator> layer = modal_[k].layer(scattering(k), m, rules.product);
    if (!layer) return std::nullopt;
    solved.push_back(std::move(*layer));
  }
  return asked_of(pile(solved, rules), sets_, m);
}

AskedMode StackModes::asked_mode(int m) const {
  return m > 0 ? asked_series(m) : asked_of(mode(m), sets_, m);
}

AskedMode StackModes::asked_series(int m) const {
  std::optional<AskedMode> modal = asked_by_eigenmodes(m);
  return modal ? std::move(*modal) : asked_of(mode(m), sets_, m);
}

double StackModes::correction() const {
  double largest = 0;
  for (const Kind& kind : kinds_)
    for (const LayerScattering& s : kind.scattering) largest = std::max(largest, s.correction);
  return largest;
}

std::size_t StackModes::bytes_of(int modes) const {
  return kinds_.size() * static_cast<std::size_t>(modes) * 4 *
         static_cast<std::size_t>(sets_.out.size() * sets_.in.size()) * sizeof(double);
}

}  // namespace lamella
