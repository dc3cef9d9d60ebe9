#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace lamella {

/// Limits of a child process. A limit that is met ends the child, not the program.
struct ChildLimits {
  std::uint64_t memory = 1 << 30;    ///< bytes beyond those of this process, and of the answer
  double processor_seconds = 10;     ///< rounded up to whole seconds
  double seconds = 60;               ///< on the clock
  std::size_t messages = 64 * 1024;  ///< bytes written to stdout and stderr together
};

/// The child did not end well. what(): what happened, one line ("crashed: Segmentation fault").
struct ChildFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The work in the child threw: what() is its text as it is.
struct ChildRefusal : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Where the work writes its answer.
class ChildAnswer {
 public:
  explicit ChildAnswer(int file) : file_(file) {}
  void write(const void* data, std::size_t count);
  void flush();

 private:
  int file_;
  std::vector<char> buffer_;
};

/// Runs `work` in a fork of this process and returns what it wrote: for libraries that a damaged
/// file can make crash, hang or ask for all memory. The child sees the program's memory as it is at
/// the call, has one thread, and ends without destructors. Its stdout and stderr are dropped, but
/// for the first words of a crash. Linux only. Throws ChildRefusal if the work throws a
/// std::exception, else ChildFailure.
[[nodiscard]] std::string run_in_child(const ChildLimits& limits,
                                       const std::function<void(ChildAnswer&)>& work);

}  // namespace lamella
