#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace lamella {

/// Where a truth by walks takes order 1 from.
enum class OrderOne {
  walked,  ///< walks, as all other orders
  exact    ///< its closed form; walks of order 1 are a check
};

[[nodiscard]] inline std::string to_text(OrderOne order_one) {
  return order_one == OrderOne::exact ? "exact" : "walked";
}
[[nodiscard]] inline std::optional<OrderOne> order_one_from(std::string_view name) {
  if (name == "exact") return OrderOne::exact;
  if (name == "walked") return OrderOne::walked;
  return std::nullopt;
}

}  // namespace lamella
