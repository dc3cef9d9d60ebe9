#pragma once

#include <stdexcept>

namespace lamella {

/// A stack file that is refused. what() names file, line, key, the value found and the values
/// allowed.
struct StackFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace lamella
