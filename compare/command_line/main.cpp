#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "compare/command_line/command_line.h"
#include "compare/files/output_folder.h"
#include "phase/parameters/one_line.h"

namespace {

int run_program(int argc, char** argv) {
  lamella::CommandLine line;
  const std::optional<int> over = line.parse(argc, argv);
  const int status = over ? *over : line.run();
  if (std::fflush(stdout) != 0)
    throw lamella::OutputError(fmt::format("cannot write stdout: {}", std::strerror(errno)));
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  const auto fail = [](const std::exception& error, int status) {
    // One line, whatever a library or a file's name brought along.
    fmt::print(stderr, "lamella: {}\n", lamella::one_line(error.what(), 1 << 14));
    return status;
  };
  try {
    return run_program(argc, argv);
  } catch (const lamella::NonFiniteError& error) {
    return fail(error, lamella::kInvalidNumbers);
  } catch (const std::domain_error& error) {
    return fail(error, lamella::kInvalidNumbers);
  } catch (const std::exception& error) {
    return fail(error, lamella::kUsage);
  }
}
