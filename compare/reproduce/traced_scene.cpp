#include "compare/reproduce/traced_scene.h"

#include <algorithm>

#include "compare/preview/preview.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

PathSettings settings_of(const ReproductionContext& context) {
  PathSettings settings;
  settings.columns = context.by_quality(24, 128, 256);
  settings.seed = context.seed;
  return settings;
}

}  // namespace

NamedPicture traced(const ReproductionContext& context, const std::string& name,
                    const ViewedObject& object, const LightDome& light,
                    const SurfaceScatter& surface, int samples) {
  PathSettings settings = settings_of(context);
  settings.samples = samples;
  return {name, trace_picture(object, surface, light, settings, context.stop)};
}

EqualTime equal_time(const ReproductionContext& context, const ViewedObject& object,
                     const LightDome& light, const SurfaceScatter& reference,
                     const std::vector<NamedSurface>& surfaces) {
  PathSettings settings = settings_of(context);
  settings.samples = context.by_quality(64, 384, 4096);
  // Numbers of its own, so that the walks of the comparison are others.
  constexpr std::uint64_t kOtherSeed = 1ULL << 33;
  settings.seed += kOtherSeed;
  EqualTime result{
      {"reference", trace_picture(object, reference, light, settings, context.stop)}, {}, {}};
  settings.seed = context.seed;
  settings.seconds = context.by_quality(0.1, 1.5, 20.0);
  constexpr int kEndless = 1000000;
  settings.samples = kEndless;
  for (const NamedSurface& s : surfaces) {
    if (is_set(context.stop)) break;
    // What is made once, places of maps among it, is no part of the time.
    PathSettings first = settings;
    first.seconds.reset();
    first.samples = 1;
    (void)trace_picture(object, *s.surface, light, first, context.stop);
    result.pictures.push_back(
        {s.name, trace_picture(object, *s.surface, light, settings, context.stop)});
    result.errors.push_back(traced_error(result.reference.picture, result.pictures.back().picture));
  }
  return result;
}

double noise_per_sample(const EqualTime& found, std::size_t picture) {
  const auto& samples = found.pictures[picture].picture.samples;
  return found.errors[picture].noise * *std::max_element(samples.begin(), samples.end());
}

PictureLuminance luminance_of(const PathPicture& picture) {
  std::vector<double> values;
  PictureLuminance result;
  for (std::size_t k = 0; k < picture.samples.size(); ++k)
    if (picture.samples[k]) {
      values.push_back(luminance(picture.mean(k)));
      result.mean += values.back();
    }
  if (values.empty()) return result;
  result.mean /= static_cast<double>(values.size());
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  result.bright = *at;
  return result;
}

PathPicture sum_of(const PathPicture& a, const PathPicture& b) {
  PathPicture sum = a;
  for (std::size_t k = 0; k < sum.samples.size(); ++k) {
    sum.sum[k] = static_cast<double>(a.samples[k]) * (a.mean(k) + b.mean(k));
    sum.square[k] = Rgb();
  }
  return sum;
}

void write_traced(ReproductionContext& context, const std::string& name, const std::string& title,
                  const std::vector<NamedPicture>& pictures, bool differences) {
  std::vector<PreviewColumn> columns;
  for (const NamedPicture& named : pictures) columns.push_back(column_of(named));
  context.write(name, [&](PictureFormat format) {
    return differences ? draw_preview(title, columns, format)
                       : draw_gallery(title, columns, {}, format);
  });
}

}  // namespace lamella
