#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace lamella {

/// Where walks on lanes, through density grids and among grains take the numbers of their first
/// steps from.
enum class Sampling {
  random,  ///< pseudo-random numbers
  rqmc     ///< randomised quasi-Monte Carlo: phase/random/lattice.h
};

[[nodiscard]] inline std::string to_text(Sampling sampling) {
  return sampling == Sampling::rqmc ? "rqmc" : "random";
}
[[nodiscard]] inline std::optional<Sampling> sampling_from(std::string_view name) {
  if (name == "rqmc") return Sampling::rqmc;
  if (name == "random") return Sampling::random;
  return std::nullopt;
}

}  // namespace lamella
