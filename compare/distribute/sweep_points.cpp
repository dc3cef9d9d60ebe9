#include "compare/distribute/sweep_points.h"

#include <fmt/format.h>

#include <utility>

#include "compare/request/errors.h"
#include "compare/request/substrate_model.h"
#include "phase/stack/stack_file.h"

namespace lamella {

constexpr std::size_t kMostPoints = 10000;

SweepPoints::SweepPoints(Stack stack, std::vector<SweepAxis> axes)
    : stack_(std::move(stack)), axes_(std::move(axes)) {
  for (const SweepAxis& axis : axes_) count_ *= axis.values.size();
  if (count_ > kMostPoints)
    throw UsageError(
        fmt::format("--set: found {} points; allowed: at most {}", count_, kMostPoints));
}

std::vector<std::size_t> SweepPoints::at(std::size_t point) const {
  std::vector<std::size_t> at(axes_.size());
  for (std::size_t a = axes_.size(); a-- > 0; point /= axes_[a].values.size())
    at[a] = point % axes_[a].values.size();
  return at;
}

std::string SweepPoints::name(std::size_t point) { return fmt::format("{:04}", point); }

std::string SweepPoints::values(std::size_t point) const {
  std::string text;
  const std::vector<std::size_t> places = at(point);
  for (std::size_t a = 0; a < axes_.size(); ++a)
    text += fmt::format("{}{} = {:g}", a ? " " : "", axes_[a].path, axes_[a].values[places[a]]);
  return text;
}

std::string SweepPoints::toml(std::size_t point) const {
  return with_values(stack_, axes_, at(point));
}

void SweepPoints::check() const {
  for (std::size_t k = 0; k < count_; ++k)
    (void)with_surface_model(parse_stack(toml(k), fmt::format("--set, point {}", k), stack_.name));
}

}  // namespace lamella
