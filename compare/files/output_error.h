#pragma once

#include <stdexcept>

namespace lamella {

/// A file or folder that cannot be written, or read back. what() names the path and the system's
/// reason.
struct OutputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace lamella
