#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "phase/math/direction.h"

namespace lamella {

/// Numbers that `resize` leaves as they are: columns are written right after.
template <class T>
struct UnsetAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UnsetAllocator<U>;
  };
  template <class U>
  void construct(U* at) noexcept {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
  }
};
template <class T>
using SampleColumn = std::vector<T, UnsetAllocator<T>>;

/// Light that left the stack, walk by walk, as columns of n rows. The sum of weights over the walks
/// that began is the energy; w_o is density f mu_o w_i's per steradian.
struct WalkSamples {
  int channels = 1;
  std::uint64_t walks = 0;  ///< that began
  /// Unit vectors that point away from the stack, [n][3].
  SampleColumn<float> wi, wo;
  SampleColumn<float> weight;         ///< [n][channels], dimensionless
  SampleColumn<std::uint32_t> order;  ///< events that the light met
  /// 1 reflected, -1 transmitted; 2 and -2 where it met nothing, or deltas alone.
  SampleColumn<std::int8_t> side;

  [[nodiscard]] std::size_t count() const { return side.size(); }

  /// Adds a row. up: it left at the top.
  void add(Direction from, Direction to, const float* weights, std::uint64_t events, bool up,
           bool delta) {
    const auto put = [](SampleColumn<float>& column, Direction w) {
      column.insert(column.end(),
                    {static_cast<float>(w.x), static_cast<float>(w.y), static_cast<float>(w.z)});
    };
    put(wi, from);
    put(wo, to);
    weight.insert(weight.end(), weights, weights + channels);
    order.push_back(static_cast<std::uint32_t>(events < 0xFFFFFFFFu ? events : 0xFFFFFFFFu));
    side.push_back(static_cast<std::int8_t>((up ? 1 : -1) * (delta ? 2 : 1)));
  }
};

}  // namespace lamella
