#include "compare/reproduce/lit_spheres.h"

#include <algorithm>
#include <cmath>

#include "compare/request/substrate_model.h"
#include "phase/math/luminance.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

constexpr PreviewView kView{PreviewScene::sphere, PreviewLight::lamp, kSphereSize, kSphereLamp, 0};

// Calls visit(k, is_rim) for every pixel of the sphere.
template <class Visit>
void for_pixels(const PreviewImage& image, const Visit& visit) {
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const auto k = static_cast<std::size_t>(y) * image.width + x;
      if (!image.covered[k]) continue;
      // The sphere fills its square but for preview.cpp's margin.
      const double u = (2 * x + 1.0) / image.width - 1, v = (2 * y + 1.0) / image.height - 1;
      const double sine2 = 1.04 * 1.04 * (u * u + v * v);
      visit(k, sine2 > 1 - kRimCosine * kRimCosine);
    }
}

}  // namespace

PreviewColumn lit_sphere(const std::string& name, const LobeTable& table) {
  Specular specular;
  if (table.has_specular()) specular = [&](Direction wo) { return table.specular(wo); };
  return {name, render_lamp([&](Direction wo) { return table.towards(wo); }, specular, kView)};
}

PreviewColumn lit_sphere(const std::string& name, const Model& model, double factor) {
  const auto f = [&](Direction wo) {
    return [&model, wo, factor](Direction wi) { return factor * model.eval(wi, wo); };
  };
  return {name, render_lamp(
                    f, [&](Direction wo) { return model.specular(wo); }, kView)};
}

PreviewColumn lit_sphere(const std::string& name, const Model& model) {
  return lit_sphere(name, model, 1);
}

SphereDifference difference(const PreviewColumn& picture, const PreviewColumn& from) {
  double square = 0, of_rim = 0, error = 0, error_of_rim = 0, sum = 0, sum_from = 0;
  for_pixels(from.image, [&](std::size_t k, bool is_rim) {
    const double a = luminance(picture.image.radiance[k]), b = luminance(from.image.radiance[k]);
    const double d = (a - b) * (a - b);
    square += b * b;
    error += d;
    sum += a;
    sum_from += b;
    if (!is_rim) return;
    of_rim += b * b;
    error_of_rim += d;
  });
  return {std::sqrt(error / square), std::sqrt(error_of_rim / of_rim), sum / sum_from - 1};
}

SphereLuminance luminance_of(const PreviewColumn& picture) {
  double sum = 0, pixels = 0, of_rim = 0, rim_pixels = 0;
  for_pixels(picture.image, [&](std::size_t k, bool is_rim) {
    const double v = luminance(picture.image.radiance[k]);
    sum += v;
    ++pixels;
    if (!is_rim) return;
    of_rim += v;
    ++rim_pixels;
  });
  return {sum / pixels, of_rim / rim_pixels};
}

void write_spheres(ReproductionContext& context, const std::string& name, const std::string& title,
                   const std::vector<PreviewColumn>& columns) {
  context.write(name, [&](PictureFormat format) { return draw_preview(title, columns, format); });
}

Stack figure_stack(const std::string& name, const std::string& toml) {
  return with_surface_model(parse_stack(toml, "reproduction", name));
}

LobeTable solved_table(const Stack& stack, const ReproductionContext& context) {
  TruthRequest request{.stack = stack};
  request.estimator = Estimator::deterministic;
  request.seed = context.seed;
  return LobeTable::make(request, context.stop);
}

LobeTable walked_table(const Stack& stack, std::uint64_t walks,
                       const ReproductionContext& context) {
  TruthRequest request{.stack = stack};
  request.estimator = Estimator::next_event;
  request.given = {WalkSetting::walks};
  request.effort.walks = walks;
  request.seed = context.seed;
  request.isa = isa_from_text("auto");
  return LobeTable::make(request, context.stop);
}

BoundModel figure_model(const std::string& request, const Stack* stack) {
  return bind_model(parse_model_request(request), stack);
}

}  // namespace lamella
