#pragma once

#include <string>
#include <vector>

#include "compare/request/sweep_axis.h"
#include "phase/stack/stack.h"

namespace lamella {

/// The points of a sweep: a stack with every combination of its axes' values, numbered with the
/// last axis running fastest. Each stands for itself: they may run in any order and any place.
class SweepPoints {
 public:
  /// Throws UsageError for more than 10000 points.
  SweepPoints(Stack stack, std::vector<SweepAxis> axes);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const std::vector<SweepAxis>& axes() const { return axes_; }

  /// Which value of each axis a point has.
  [[nodiscard]] std::vector<std::size_t> at(std::size_t point) const;
  /// Of its files: four digits or more.
  [[nodiscard]] static std::string name(std::size_t point);
  /// "layer.0.roughness = 0.2 layer.0.thickness = 1".
  [[nodiscard]] std::string values(std::size_t point) const;
  /// Its stack file. Throws UsageError where an axis leads nowhere.
  [[nodiscard]] std::string toml(std::size_t point) const;

  /// Reads every point's stack, so that none fails after others have run. Throws UsageError or
  /// StackFileError.
  void check() const;

 private:
  Stack stack_;
  std::vector<SweepAxis> axes_;
  std::size_t count_ = 1;
};

}  // namespace lamella
