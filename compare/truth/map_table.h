#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "compare/truth/lobe_table.h"

namespace lamella {

/// A number of a stack that a map moves from one end to the other; of a colour, each channel's.
struct MapAxis {
  std::string path;  ///< "layer.0.albedo"
  double low = 0, high = 0;
};

/// The reflection of a stack with maps, for pictures: a LobeTable for every node of a grid over the
/// numbers that the maps move, kNodesOfOne along one axis or kNodesOfTwo along each of two. What is
/// closed is that of the place's own stack, exactly; the rest is the cubic through the four nearest
/// nodes along each axis, channel by channel, not below 0. No stated error: `lamella preview` tells
/// it beside the noise.
class MapTable {
 public:
  static constexpr std::size_t kMostAxes = 2;
  static constexpr int kNodesOfOne = 7, kNodesOfTwo = 4;

  /// The stack with these numbers, one per axis; a colour has the number in all channels.
  using StackAt = std::function<Stack(std::span<const double>)>;
  /// `request`: of any of the stacks. Called before each table: how many of how many are there.
  using Report = std::function<void(std::size_t done, std::size_t of)>;
  /// Throws UsageError where there are too many axes, where a node's stack has no table, or where
  /// interfaces turn from smooth to rough between nodes.
  [[nodiscard]] static MapTable make(TruthRequest request, std::vector<MapAxis> axes,
                                     const StackAt& stack_at, const StopFlag* stop,
                                     const Report& report = {});

  /// A place of the maps, to be made once.
  struct Place {
    Stack stack;
    /// Of every node: what it counts, per channel.
    std::vector<Rgb> weights;
  };
  /// values: one per axis; a number in all channels.
  [[nodiscard]] Place place(const Stack& stack, std::span<const Rgb> values) const;

  /// f [1/sr] of one w_o as a function of w_i, as LobeTable's. Must outlive neither the place nor
  /// this.
  [[nodiscard]] std::function<Rgb(Direction wi)> towards(const Place& place, Direction wo) const;
  /// The share of light from w_o that leaves along its mirror image as a delta.
  [[nodiscard]] Rgb specular(const Place& place, Direction wo) const;
  [[nodiscard]] bool has_specular() const { return tables_.front().has_specular(); }

  /// How it was made, for people.
  [[nodiscard]] const std::string& source() const { return source_; }

 private:
  std::vector<MapAxis> axes_;
  int nodes_ = kNodesOfOne;
  std::vector<LobeTable> tables_;     // different ones
  std::vector<std::size_t> of_node_;  // the table of each node, the first axis fastest
  std::string source_;
};

}  // namespace lamella
