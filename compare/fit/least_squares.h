#pragma once

#include <stdexcept>

namespace lamella {

/// A fit that this build cannot do. what() is one line for the user.
struct FitError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Whether this build has Ceres, which the fits need; to be asked before a truth is simulated.
[[nodiscard]] bool has_least_squares();
/// Throws FitError unless has_least_squares().
void require_least_squares();

}  // namespace lamella
