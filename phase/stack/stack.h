#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "phase/grains/grain_geometry.h"
#include "phase/interface/interfaces.h"
#include "phase/medium/medium.h"
#include "phase/surface/surface_law.h"

namespace lamella {

/// Keys that name the grids of a .vdb file.
inline constexpr std::array<const char*, 4> kGridNameKeys{"density_grid", "orientation_grid",
                                                          "roughness_grid", "albedo_grid"};

/// The grid that varies a layer's density, as a stack file names it. Its voxels belong to volume
/// (density_grid.h); here the grid is a name and a size.
struct GridReference {
  std::string file;    ///< .vdb file as the stack file has it, or "builtin:" and a name
  std::string folder;  ///< what a relative file name starts from; empty: working directory
  double size_x = 1, size_y = 1;  ///< [mm], in (0, infinity): the lateral period
  bool white = false;             ///< leave the file's albedo grid out
  /// Names of the file's grids where they are not "density", "orientation", "roughness", "albedo":
  /// of the keys kGridNameKeys, in that order. Empty: that name, and only density must be there.
  std::array<std::string, 4> names{};
  /// The tile in voxels of the file, from first_voxel on. Without it the tile is as
  /// volume/README.md, "The tile", says.
  std::optional<std::array<int, 3>> voxels{};
  std::array<int, 3> first_voxel{};
  std::string where;  ///< "cloth.toml:5: layer 0", for errors
};

/// An entry of the list of layers: a plane-parallel layer of a medium, of which only depth() counts
/// for the light unless a grid varies it; or an interface, of zero thickness; or explicit geometry.
struct Layer {
  std::string medium_name;
  Parameters parameters;  ///< the medium's own, complete: for echo
  Medium medium;          ///< built from them
  Rgb albedo{1};          ///< of a flake or particle, in [0, 1]
  Rgb f0{1};              ///< Schlick's f0 of mirror flakes; 1: no Fresnel factor
  double thickness = 1;   ///< [mm], in [0, infinity]
  double density = 1;     ///< [1/mm], in [0, infinity)
  /// Multiplies the density from voxel to voxel; the grid's height is the thickness, then finite.
  std::optional<GridReference> grid = {};
  /// Explicit geometry in the place of the medium, which then has no meaning.
  std::optional<GrainGeometry> grains = {};
  /// An interface in the place of the medium, which then has no meaning: thickness and density 0.
  std::optional<Interface> interface = {};

  /// thickness times density, dimensionless; infinity for a half space.
  [[nodiscard]] double depth() const { return thickness * density; }
};

/// Substrate::model of a conductor.
inline constexpr char kConductor[] = "conductor";

/// An opaque surface below the last layer: Lambertian, or black at albedo 0. Below micrograins it
/// may reflect by a closed form instead.
struct Substrate {
  Rgb albedo{0};            ///< of Lambert's law, in [0, 1]; without meaning where there is a model
  std::string model{};      ///< "conductor", name of a closed form, or empty
  Parameters parameters{};  ///< its own, for echo
  std::map<std::string, std::string, std::less<>> where{};  ///< of each key, for errors: "a.toml:7"
  std::shared_ptr<const SurfaceLaw>
      law{};  ///< a conductor, or the model: compare/request/substrate_model.h makes it

  [[nodiscard]] bool is_grey() const;
};

/// Layers from the top down, and the substrate.
struct Stack {
  std::string name;
  std::vector<Layer> layers;
  std::optional<Substrate> substrate;

  /// The explicit geometry that the stack consists of, or nullptr if it is made of layers.
  [[nodiscard]] const GrainGeometry* grains() const;
  /// Throws std::invalid_argument, which names `what`, if the stack is explicit geometry.
  void require_layers(const char* what) const;
  /// Whether the light meets boundaries that a walk through layers alone does not know: interfaces
  /// that change the index, or a substrate that is neither Lambert's nor black.
  [[nodiscard]] bool has_boundaries() const;
  /// Whether an interface changes the index.
  [[nodiscard]] bool has_interfaces() const;
  /// Whether an interface that changes the index is rough: then light that met interfaces alone is
  /// no delta.
  [[nodiscard]] bool has_rough_interfaces() const;
  /// Index of refraction of a layer; for layers.size(): of the medium below them all.
  [[nodiscard]] double index_of(std::size_t layer) const;
  [[nodiscard]] bool is_half_space() const;
  /// Whether light can come from below, and leave there.
  [[nodiscard]] bool is_open_below() const { return !substrate && !is_half_space(); }
  /// Whether a grid varies a layer's density (one of depth 0 counts as none).
  [[nodiscard]] bool has_grid() const;
  /// Whether no albedo, f0 or substrate differs between the channels; a grid's albedo is not looked
  /// at.
  [[nodiscard]] bool is_grey() const;
  /// Whether every rotation about z leaves the stack as it is; no stack with a grid is taken so.
  [[nodiscard]] bool is_symmetric_about_z() const;
  /// Whether global reciprocity is known to hold: every one-sided layer has a vertical mean normal
  /// and no grid (along two paths between the same points the density differs), and the substrate
  /// is no closed form, which may break reciprocity. Across interfaces f / n^2 is reciprocal.
  [[nodiscard]] bool is_reciprocal() const;
  /// Sum over layers of depth times the z part of the mean normal: transmission from above is
  /// exp(-this) times transmission from below along the reversed pair.
  [[nodiscard]] double one_sidedness() const;
  /// Fraction of the light that arrives from w (a unit vector that points away from the stack) and
  /// crosses all layers without a collision; 0 through a half space. Not of explicit geometry.
  [[nodiscard]] double uncollided(Direction w) const;
};

/// Throws std::invalid_argument if a grid varies a layer of the stack: `what`, named in the
/// message, knows homogeneous layers only.
void refuse_grid(const Stack& stack, const std::string& what);

/// Throws std::invalid_argument if the stack has boundaries: `what`, named in the message, knows
/// layers over a Lambertian substrate or none.
void refuse_boundaries(const Stack& stack, const std::string& what);

/// The same layers with every albedo, substrate albedo and f0 at 1, for white furnaces.
[[nodiscard]] Stack whitened(Stack stack);

}  // namespace lamella
