#pragma once

#include <array>
#include <string>

namespace lamella {

/// Scattering orders as results tell them apart: 1, 2, 3, 4 and above; their sum with order 0; and,
/// where rough interfaces are, order 0 itself, light that met interfaces alone, and all but that;
/// and multiple scattering, orders 2 and up.
enum class Order { one, two, three, four_plus, all, zero, scattered, multiple };

/// Orders that walks and solvers tell apart: those from `one` to `four_plus`, in places 0 to 3.
inline constexpr int kTallyOrders = 4;
inline constexpr int kLobeOrders = 8;

/// The place of an order among what is kept per order.
[[nodiscard]] constexpr int place(Order order) { return static_cast<int>(order); }

/// "1", "2", "3", "4+", "all", "0", "1+", "2+"
[[nodiscard]] std::string to_text(Order order);
/// The same in names of channels and arrays: "order1", ..., "order4plus", "all", "order0",
/// "order1plus", "order2plus"
[[nodiscard]] std::string lobe_name(Order order);

/// One value per order; places are those of the enumeration.
template <class T>
struct OrderMap : std::array<T, kLobeOrders> {
  using Places = std::array<T, kLobeOrders>;
  using Places::operator[];
  [[nodiscard]] constexpr T& operator[](Order order) { return Places::operator[](place(order)); }
  [[nodiscard]] constexpr const T& operator[](Order order) const {
    return Places::operator[](place(order));
  }
};

}  // namespace lamella
