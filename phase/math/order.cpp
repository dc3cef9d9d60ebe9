#include "phase/math/order.h"

namespace lamella {

std::string to_text(Order order) {
  static const OrderMap<std::string> names{{"1", "2", "3", "4+", "all", "0", "1+", "2+"}};
  return names[order];
}

std::string lobe_name(Order order) {
  static const OrderMap<std::string> names{
      {"order1", "order2", "order3", "order4plus", "all", "order0", "order1plus", "order2plus"}};
  return names[order];
}

}  // namespace lamella
