#include "compare/ranks/ranks.h"

#include <algorithm>
#include <chrono>
#include <thread>

namespace lamella {

void RankPause::wait() {
  std::this_thread::sleep_for(std::chrono::microseconds(microseconds_));
  microseconds_ = std::min(2 * microseconds_, 2000);
}

RankMessage Ranks::receive() {
  RankPause pause;
  for (;;) {
    if (auto message = poll()) return std::move(*message);
    pause.wait();
  }
}

}  // namespace lamella
