#include "volume/result/estimator.h"

namespace lamella {

std::string to_text(Estimator estimator) {
  switch (estimator) {
    case Estimator::analog:
      return "analog";
    case Estimator::next_event:
      return "next-event";
    case Estimator::deterministic:
      break;
  }
  return "deterministic";
}

}  // namespace lamella
