#include "phase/math/order.h"

namespace lamella {

std::string to_text(Order order) {
  static const OrderMap<std::string> names{{"1", "2", "3", "4+", "all", "0", "1+"}};
  return names[order];
}

}  // namespace lamella
