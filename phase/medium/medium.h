#pragma once

#include <functional>
#include <variant>

#include "phase/medium/flake.h"
#include "phase/medium/henyey_greenstein.h"
#include "phase/medium/lambert_sphere.h"
#include "phase/medium/sggx.h"
#include "phase/medium/vmf.h"
#include "phase/parameters/parameters.h"

namespace lamella {

/// The closed set of media. A new one is a file pair that meets ScatteringMedium, a name here and
/// an entry in media().
using Medium = std::variant<MirrorFlakes<Sggx>, LambertFlakes<Sggx>, MirrorFlakes<Vmf>,
                            LambertFlakes<Vmf>, LambertSphere, HenyeyGreenstein>;

static_assert(NormalDistribution<Sggx> && NormalDistribution<Vmf>);
static_assert(ScatteringMedium<MirrorFlakes<Sggx>> && ScatteringMedium<LambertFlakes<Sggx>>);
static_assert(ScatteringMedium<MirrorFlakes<Vmf>> && ScatteringMedium<LambertFlakes<Vmf>>);
static_assert(ScatteringMedium<LambertSphere> && ScatteringMedium<HenyeyGreenstein>);

/// A medium as stack files and `lamella media` know it.
struct MediumInfo {
  std::string name;
  std::string doc;
  std::string source;
  std::vector<ParameterInfo> parameters;  ///< its own keys, beside albedo, thickness and density
  /// Builds the medium from checked parameters and completes them (defaults that depend on others,
  /// so that an echo shows what was used). Throws ParameterError.
  std::function<Medium(Parameters&)> make;
};

[[nodiscard]] const std::vector<MediumInfo>& media();

/// The entry with that name, or nullptr.
[[nodiscard]] const MediumInfo* find_medium(std::string_view name);

/// Projected area per unit of density that faces w.
[[nodiscard]] double sigma(const Medium& medium, Direction w);
/// p(w_i -> w_o) and the Schlick weight.
[[nodiscard]] PhaseValue phase(const Medium& medium, Direction wi, Direction wo);
[[nodiscard]] bool is_delta(const Medium& medium);
/// Whether every rotation about z leaves the medium as it is.
[[nodiscard]] bool is_symmetric_about_z(const Medium& medium);
/// The integral of m D(m) dm: zero for two-sided media and particles.
[[nodiscard]] Direction mean_normal(const Medium& medium);
/// The direction a delta medium sends light to that arrived from w_i.
[[nodiscard]] Direction delta_direction(const Medium& medium, Direction wi);

}  // namespace lamella
