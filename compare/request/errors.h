#pragma once

#include <stdexcept>

namespace lamella {

/// Wrong usage or bad input: what() is one line for the user.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace lamella
