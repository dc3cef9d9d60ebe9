#include "volume/solver/second_split.h"

#include <algorithm>

#include "volume/adding/make_stack_solver.h"

namespace lamella {
namespace {

bool is_counted(const Medium& medium) { return traits(medium).shape != PhaseShape::diffuse; }

}  // namespace

Stack counted_by_second_order(const Stack& stack) {
  Stack counted = stack;
  for (Layer& layer : counted.layers)
    if (!layer.interface && !is_counted(layer.medium)) layer.albedo = Rgb(0);
  if (counted.substrate) {
    counted.substrate->albedo = Rgb(0);
    counted.substrate->law.reset();
  }
  return counted;
}

SecondSplit::SecondSplit(const Stack& stack, int channel, int nodes,
                         std::span<const AskedCosine> asked_out,
                         std::span<const AskedCosine> asked_in, Isa isa)
    : stack_(counted_by_second_order(stack)),
      every_mode_((stack.substrate && stack.substrate->law) ||
                  std::any_of(stack.layers.begin(), stack.layers.end(),
                              [&](const Layer& l) {
                                return !l.interface && !is_counted(l.medium) &&
                                       l.albedo[channel] > 0;
                              })),
      // A Lambertian substrate takes part in mode 0 only.
      first_mode_(stack.substrate && stack.substrate->albedo[channel] > 0) {
  if (every_mode_ || first_mode_)
    modes_ = make_stack_solver(stack_, channel, nodes, asked_out, asked_in, 2, isa);
}

std::optional<Parts> SecondSplit::counted(int m) {
  if (!(every_mode_ || (first_mode_ && m == 0))) return std::nullopt;
  modes_->prepare(m + 1);
  return modes_->asked_mode(m).series[2];
}

}  // namespace lamella
