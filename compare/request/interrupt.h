#pragma once

#include <atomic>

namespace lamella {

/// Set from another thread or a signal handler: long work that was handed the flag ends at its next
/// checkpoint with what it has.
using StopFlag = std::atomic<bool>;

/// Whether there is a flag and it is set.
[[nodiscard]] inline bool is_set(const StopFlag* stop) { return stop && *stop; }

/// The program's own flag: Ctrl-C sets it once catch_interrupts() was called. The commands read it
/// and hand its address down; what they call knows only the flag that it was handed.
extern StopFlag user_interrupt;

/// From here on Ctrl-C sets `user_interrupt`; a second Ctrl-C kills.
void catch_interrupts();

}  // namespace lamella
