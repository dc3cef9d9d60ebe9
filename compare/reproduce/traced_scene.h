#pragma once

#include <string>
#include <vector>

#include "compare/render/path_report.h"
#include "compare/reproduce/reproduction.h"

namespace lamella {

// Objects under light, by paths (compare/render), for figures.

/// One picture of `samples` paths per pixel.
[[nodiscard]] NamedPicture traced(const ReproductionContext& context, const std::string& name,
                                  const ViewedObject& object, const LightDome& light,
                                  const SurfaceScatter& surface, int samples);

/// A surface of an equal-time comparison.
struct NamedSurface {
  std::string name;
  const SurfaceScatter* surface;
};

/// Pictures that had the same seconds, each with its errors from a reference by many samples.
struct EqualTime {
  NamedPicture reference;
  std::vector<NamedPicture> pictures;  ///< fewer once the context is stopped
  std::vector<TracedError> errors;     ///< in the same order
};
[[nodiscard]] EqualTime equal_time(const ReproductionContext& context, const ViewedObject& object,
                                   const LightDome& light, const SurfaceScatter& reference,
                                   const std::vector<NamedSurface>& surfaces);

/// The noise that one sample per pixel would have.
[[nodiscard]] double noise_per_sample(const EqualTime& found, std::size_t picture);

/// The mean luminance over the object, and the 99th percentile of its pixels.
struct PictureLuminance {
  double mean = 0, bright = 0;
};
[[nodiscard]] PictureLuminance luminance_of(const PathPicture& picture);

/// The light of both added; samples of the first.
[[nodiscard]] PathPicture sum_of(const PathPicture& a, const PathPicture& b);

/// Writes pictures side by side at one exposure; `differences`: those from the first, too.
void write_traced(ReproductionContext& context, const std::string& name, const std::string& title,
                  const std::vector<NamedPicture>& pictures, bool differences);

}  // namespace lamella
