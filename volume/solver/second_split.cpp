#include "volume/solver/second_split.h"

#include <algorithm>

#include "volume/solver/deterministic_channel.h"

namespace lamella {
namespace {

bool is_counted(const Medium& medium) { return traits(medium).shape != PhaseShape::diffuse; }

}  // namespace

Stack counted_by_second_order(const Stack& stack) {
  Stack counted = stack;
  for (Layer& layer : counted.layers)
    if (!is_counted(layer.medium)) layer.albedo = Rgb(0);
  if (counted.substrate) counted.substrate->albedo = Rgb(0);
  return counted;
}

SecondSplit::SecondSplit(const Stack& stack, int channel, const DirectionSets& sets, Isa isa)
    : stack_(counted_by_second_order(stack)),
      every_mode_(std::any_of(
          stack.layers.begin(), stack.layers.end(),
          [&](const Layer& l) { return !is_counted(l.medium) && l.albedo[channel] > 0; })),
      // A Lambertian substrate takes part in mode 0 only.
      first_mode_(stack.substrate && stack.substrate->albedo[channel] > 0) {
  if (every_mode_ || first_mode_) modes_.emplace(stack_, channel, sets, 2, isa);
}

std::optional<Parts> SecondSplit::counted(int m) {
  if (!(every_mode_ || (first_mode_ && m == 0))) return std::nullopt;
  modes_->prepare(m + 1);
  const LayerOperator op = modes_->mode(m);
  const Eigen::Index nodes = modes_->sets().nodes();
  Parts result;
  for (int part = 0; part < 4; ++part)
    result[part] = asked_block(part_of(op, part)[2], nodes, nodes);
  return result;
}

}  // namespace lamella
