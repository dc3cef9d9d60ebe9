#pragma once

#include <array>
#include <string>

namespace lamella {

/// How a pixel's numbers become a value: as they are; as a direction, 2 c - 1 per channel; or as an
/// angle in the plane of the stack.
enum class MapEncoding { value, normal, angle };
/// What lies beyond a picture's edges: the picture again, the picture mirrored, or its edge.
enum class MapWrap { repeat, mirror, clamp };
enum class MapFilter { linear, nearest };
/// automatic: sRGB where an integer picture is the value of a colour, else linear.
enum class MapColorSpace { automatic, linear, srgb };
/// Which channel is taken for a number: the luminance of a colour picture, or a channel of it.
enum class MapChannel { automatic, red, green, blue, alpha };

/// A picture in the place of a number, a colour or a direction, as a stack file names it. Its
/// pixels belong to compare/maps; here the picture is a name and what its numbers mean.
struct MapReference {
  std::string file;    ///< as the stack file has it
  std::string folder;  ///< what a relative name starts from; empty: working directory
  MapEncoding encoding = MapEncoding::value;
  MapWrap wrap = MapWrap::repeat;
  MapFilter filter = MapFilter::linear;
  MapColorSpace color_space = MapColorSpace::automatic;
  MapChannel channel = MapChannel::automatic;
  /// The values of the numbers 0 and 1; of angles in degrees. Linear in between and beyond.
  std::array<double, 2> scale{0, 1};
};

}  // namespace lamella
