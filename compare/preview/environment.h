#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

/// Radiance that arrives from everywhere: the same from all sides, or a lat-long picture. y is up
/// in the scene; the picture's top row is up, its middle column the direction away from the viewer
/// (-z).
///
/// The picture is the display window of an EXR: black where the data window does not reach, cut
/// where it reaches beyond. Texels are constant and count by their solid angle. Pictures of more
/// than kMostColumns x kMostRows texels are kept in blocks: of each its flux, exact, and the
/// centroid of its light, so that a sun of one texel shines from where it stands.
///
/// The least radiance of the picture is light from everywhere, for which no directions are needed
/// (`uniform`); what is above it is a tree of blocks of blocks (`nodes`), each with its flux and
/// centroid: to integrate a lobe against them one descends until the lobe is smooth over a node.
class Environment {
 public:
  static constexpr int kMostColumns = 1024, kMostRows = 512;

  Environment() = default;  ///< uniform, radiance 1
  /// From an EXR: its channels R, G, B (or Y) as find_colors has them. Throws OutputError if it
  /// cannot be read, UsageError if it has no such channels or values that are negative or not
  /// finite.
  explicit Environment(const std::string& path);
  /// From texels row by row from the top left, finite and not negative.
  Environment(int width, int height, const std::vector<Rgb>& texels);

  /// Whether every direction has the same radiance.
  [[nodiscard]] bool is_uniform() const { return nodes_.empty(); }
  /// The least radiance, per channel.
  [[nodiscard]] Rgb uniform() const { return uniform_; }
  /// What was taken of a file, for people: "part 0, layer ViewLayer.Combined"; else empty.
  [[nodiscard]] const std::string& source() const { return source_; }

  /// Light above `uniform` from a rectangle of latitudes and longitudes.
  struct Node {
    float flux[3];      ///< integral of radiance over solid angle [sr]
    float centroid[3];  ///< mean direction of the light, not longer than 1; the channels' mean
    std::uint16_t column, columns, row, rows;  ///< of blocks
    std::int32_t children;                     ///< index of the first of two; -1: one block
  };
  /// The first is the whole sphere; those without light have been left out (flux 0).
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
  /// Whether a block is one texel, and so of one radiance; else only its centroid is known.
  [[nodiscard]] bool blocks_are_texels() const { return blocks_are_texels_; }
  /// The direction of the middle of a node, and its extent: angles between its parallels and along
  /// the longest of them.
  [[nodiscard]] Direction middle(const Node& node) const;
  struct Extent {
    double latitude, longitude;
  };
  [[nodiscard]] Extent extent(const Node& node) const;
  /// Longitude of a block's left edge from -z towards +x, and polar angle of its upper edge from
  /// +y.
  [[nodiscard]] double longitude(double column) const { return kPi * (2 * column / columns_ - 1); }
  [[nodiscard]] double polar_angle(double row) const { return kPi * row / rows_; }

 private:
  struct Picture;
  struct Light;
  void keep(const Picture& picture);
  Light build(std::int32_t index, const std::vector<Light>& blocks);

  Rgb uniform_{1};
  int columns_ = 0, rows_ = 0;
  bool blocks_are_texels_ = true;
  std::vector<Node> nodes_;
  // Of every edge and middle of a column, a row of blocks.
  std::vector<double> sine_of_longitude_, cosine_of_longitude_, sine_of_angle_, cosine_of_angle_;
  std::string source_;
};

/// The direction of a longitude and polar angle as Environment has them.
[[nodiscard]] Direction lat_long_direction(double longitude, double polar_angle);

}  // namespace lamella
