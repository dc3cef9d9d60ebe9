#pragma once

#include <fmt/format.h>

#include <cstdlib>
#include <limits>
#include <string>

#include "phase/stack/stack_file.h"

namespace lamella {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline bool is_soak() { return std::getenv("LAMELLA_SOAK") != nullptr; }

inline Stack stack_of(const std::string& toml) { return parse_stack(toml, "test", "test"); }

/// One layer as stack-file text: the medium's keys, then albedo and thickness.
inline std::string layer(const std::string& medium, double albedo, double thickness) {
  return fmt::format("[[layer]]\n{}\nalbedo = {}\nthickness = {}\n", medium, albedo,
                     to_text(thickness));
}
inline std::string lambert_ground(double albedo) {
  return fmt::format("[substrate]\nbsdf = \"lambert\"\nalbedo = {}\n", albedo);
}

inline const std::string kIsotropic = "medium = \"henyey_greenstein\"";
inline const std::string kSphere = "medium = \"lambert_sphere\"";
inline std::string henyey_greenstein(double g) { return fmt::format("{}\ng = {}", kIsotropic, g); }
inline std::string sggx(double roughness, const std::string& flake) {
  return fmt::format("medium = \"sggx\"\nroughness = {}\nflake = \"{}\"", roughness, flake);
}
inline std::string fiber(double roughness, const std::string& flake) {
  return sggx(roughness, flake) + "\nshape = \"fiber\"\naxis = [0, 0, 1]";
}
inline std::string vmf(double roughness, const std::string& flake) {
  return fmt::format("medium = \"vmf_flake\"\nroughness = {}\nflake = \"{}\"", roughness, flake);
}

}  // namespace lamella
