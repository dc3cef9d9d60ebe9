#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

namespace lamella {

/// Things of the places of a map, each made when it is asked for first: at most kMostPlaces along u
/// and v, the nearest place to any (u, v), which repeat beyond [0, 1]. Any thread; where two make
/// the same thing at once, one of both is kept.
inline constexpr int kMostPlaces = 256;

template <class T>
class PlaceGrid {
 public:
  using Make = std::function<std::unique_ptr<T>(double u, double v)>;

  PlaceGrid(int columns, int rows, Make make)
      : make_(std::move(make)),
        columns_(std::clamp(columns, 1, kMostPlaces)),
        rows_(std::clamp(rows, 1, kMostPlaces)),
        made_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}
  ~PlaceGrid() {
    for (std::atomic<T*>& thing : made_) delete thing.load();
  }
  PlaceGrid(const PlaceGrid&) = delete;
  PlaceGrid& operator=(const PlaceGrid&) = delete;

  [[nodiscard]] const T& at(double u, double v) const {
    const std::size_t column = index(u, columns_), row = index(v, rows_);
    std::atomic<T*>& place = made_[row * static_cast<std::size_t>(columns_) + column];
    if (const T* there = place.load(std::memory_order_acquire)) return *there;
    std::unique_ptr<T> fresh = make_((static_cast<double>(column) + 0.5) / columns_,
                                     (static_cast<double>(row) + 0.5) / rows_);
    T* other = nullptr;
    if (place.compare_exchange_strong(other, fresh.get(), std::memory_order_acq_rel))
      return *fresh.release();
    return *other;
  }

 private:
  static std::size_t index(double x, int count) {
    return static_cast<std::size_t>(
        std::min(static_cast<int>((x - std::floor(x)) * count), count - 1));
  }

  Make make_;
  int columns_, rows_;
  mutable std::vector<std::atomic<T*>> made_;
};

}  // namespace lamella
