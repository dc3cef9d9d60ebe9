#include "compare/request/interrupt.h"

#include <csignal>

namespace lamella {

StopFlag user_interrupt = false;

void catch_interrupts() {
  std::signal(SIGINT, [](int) {
    user_interrupt = true;
    std::signal(SIGINT, SIG_DFL);
  });
}

}  // namespace lamella
