#include <fmt/format.h>

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "compare/command_line/command_line.h"
#include "compare/files/output_folder.h"
#include "compare/ranks/ranks.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "phase/parameters/one_line.h"

namespace {

using lamella::Ranks;

// Ranks that do not write are silent, but for errors of their own: an error that is rank 0's, too,
// ends all of them before they would tell it.
constexpr std::chrono::seconds kRankWaits{3};
// Until all that were interrupted have kept what they have.
constexpr std::chrono::milliseconds kInterruptedWaits{900};

// Solvers take and give back arrays all the time. Freed memory stays with the program, because page
// faults of several threads wait for each other.
void keep_freed_memory() {
#ifdef M_TRIM_THRESHOLD
  constexpr int kMiB = 1 << 20;
  mallopt(M_TRIM_THRESHOLD, 256 * kMiB);
  mallopt(M_MMAP_THRESHOLD, 32 * kMiB);  // setting the one would otherwise freeze the other
#endif
}

int run_program(int argc, char** argv) {
  lamella::CommandLine line;
  const std::optional<int> over = line.parse(argc, argv);
  const int status = over ? *over : line.run();
  if (std::fflush(stdout) != 0)
    throw lamella::OutputError(fmt::format("cannot write stdout: {}", std::strerror(errno)));
  return status;
}

int fail(const std::exception& error, int status) {
  Ranks* const ranks = lamella::started_ranks();
  const bool tells = !ranks || ranks->rank() == 0;
  if (!tells) std::this_thread::sleep_for(kRankWaits);
  // One line, whatever a library or a file's name brought along.
  fmt::print(stderr, "lamella: {}{}\n", tells ? "" : fmt::format("rank {}: ", ranks->rank()),
             lamella::one_line(error.what(), 1 << 14));
  if (ranks) ranks->abort(status);
  return status;
}

// An interrupt ends every rank by itself: the others may be gone.
void leave_if_interrupted(const std::exception* error, int status) {
  Ranks* const ranks = lamella::user_interrupt ? lamella::started_ranks() : nullptr;
  if (!ranks) return;
  if (error && ranks->rank() == 0)
    fmt::print(stderr, "lamella: {}\n", lamella::one_line(error->what(), 1 << 14));
  std::fflush(nullptr);
  std::this_thread::sleep_for(kInterruptedWaits);
  std::_Exit(status);
}

int failed(const std::exception& error, int status) {
  leave_if_interrupted(&error, status);
  return fail(error, status);
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  try {
    try {
      (void)lamella::started_ranks();
    } catch (const lamella::UsageError& error) {
      fmt::print(stderr, "lamella: {}\n", error.what());
      return lamella::kUsage;
    }
    const int status = run_program(argc, argv);
    leave_if_interrupted(nullptr, status);
    lamella::finish_ranks();
    return status;
  } catch (const lamella::NonFiniteError& error) {
    return failed(error, lamella::kInvalidNumbers);
  } catch (const std::domain_error& error) {
    return failed(error, lamella::kInvalidNumbers);
  } catch (const std::exception& error) {
    return failed(error, lamella::kUsage);
  }
}
