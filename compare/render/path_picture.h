#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/render/light_dome.h"
#include "compare/render/surface_scatter.h"
#include "compare/request/interrupt.h"
#include "volume/mesh/mesh_scene.h"

namespace lamella {

/// An object and its camera: a sphere of radius 1 seen along -z from far away; an endless plane
/// seen by a camera close to it (both as in preview.h); or a mesh seen from far away, a little from
/// above.
class ViewedObject {
 public:
  enum class Kind { sphere, plane, mesh };

  /// sphere, plane, cloth, knot, or the name of an OBJ file. Throws UsageError, naming --shape.
  explicit ViewedObject(const std::string& shape);
  explicit ViewedObject(TriangleMesh mesh);

  struct Ray {
    Direction origin, d;
  };
  /// Through a place on the picture, x to the right and y upwards from its middle; half its width
  /// is 1.
  [[nodiscard]] Ray camera(double x, double y) const;
  [[nodiscard]] std::optional<MeshHit> trace(const Ray& ray) const;
  [[nodiscard]] bool is_free(const Ray& ray) const;
  /// A ray from a hit along d, begun on the side that d points to.
  [[nodiscard]] Ray from(const MeshHit& hit, Direction d) const;
  /// Rows of a picture of that many columns.
  [[nodiscard]] int rows(int columns) const;

 private:
  void frame(const TriangleMesh& mesh);

  Kind kind_ = Kind::sphere;
  std::unique_ptr<MeshScene> mesh_;
  Direction middle_{0, 0, 0};  // of the picture of a mesh, and half of its width
  double half_width_ = 1;
};

struct PathSettings {
  int columns = 192;
  int depth = 4;                    ///< surfaces that a path may meet
  int samples = 64;                 ///< per pixel at most
  std::optional<double> seconds{};  ///< that end the picture earlier, after whole passes
  std::uint64_t seed = 1;
};

struct PathPicture;
/// Sees a picture after every pass, in the thread that asked for it: how many samples there are.
using PathWatch = std::function<void(const PathPicture& so_far, int samples)>;

/// Sums over the samples of every pixel, row by row from the top left.
struct PathPicture {
  int width = 0, height = 0;
  std::vector<std::uint32_t> samples;  ///< of a pixel that met the object; 0: the background
  std::vector<Rgb> sum, square;        ///< of the radiance and its squares, over the samples
  double seconds = 0;
  double cut = 0;  ///< mean over covered samples of the weight of paths ended by `depth`

  [[nodiscard]] Rgb mean(std::size_t pixel) const;
  /// Of the mean, unbiased; 0 for fewer than two samples.
  [[nodiscard]] Rgb variance(std::size_t pixel) const;

  /// What was known on the way, at doubling times.
  struct Checkpoint {
    double seconds;
    int samples;
    double noise;  ///< relative_noise then
  };
  std::vector<Checkpoint> checkpoints{};
};

/// Path tracing with next-event estimation: light from the dome directly and by interreflection.
/// Where a camera's ray meets nothing the picture has no sample. Passes of one sample per pixel;
/// equal numbers of passes give equal pictures for any number of threads. Runs in the calling
/// thread's task arena.
[[nodiscard]] PathPicture trace_picture(const ViewedObject& object, const SurfaceScatter& surface,
                                        const LightDome& light, const PathSettings& settings,
                                        const StopFlag* stop, const PathWatch& watch = {});

/// Mean over the pixels with two samples and more of the luminance's variance over (reference^2 +
/// 1e-2 of its mean square): the relative mean square error that noise makes.
[[nodiscard]] double relative_noise(const PathPicture& picture, const PathPicture& reference);
/// The same of the squared difference of two pictures; noise counts.
[[nodiscard]] double relative_difference(const PathPicture& picture, const PathPicture& reference);

}  // namespace lamella
