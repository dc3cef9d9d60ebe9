#pragma once

#include <pybind11/pybind11.h>

#include "compare/options/options.h"

namespace lamella {

/// The keywords of a call as the command line's options, so that both mean the same and refuse the
/// same in the same words: wi (THETA or (THETA, PHI) in degrees each), distribution, walks,
/// target_error, time, max_order, thin_from, sampling, tolerance, grid (MU, PHI), estimator, seed,
/// threads, isa, as_is, quick. Throws UsageError.
[[nodiscard]] Options options_of(const pybind11::dict& keywords);

}  // namespace lamella
