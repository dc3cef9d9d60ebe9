#include "volume/result/accuracy.h"

namespace lamella {

std::string to_text(DeterministicLimit limit) {
  switch (limit) {
    case DeterministicLimit::nodes:
      return "nodes";
    case DeterministicLimit::modes:
      return "modes";
    case DeterministicLimit::time:
      return "time";
    case DeterministicLimit::memory:
      return "memory";
    case DeterministicLimit::interrupted:
      return "interrupted";
    case DeterministicLimit::numbers:
      return "numbers";
    default:
      return "";
  }
}

}  // namespace lamella
