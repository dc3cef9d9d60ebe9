#include "compare/reproduce/lit_spheres.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "compare/request/substrate_model.h"
#include "phase/math/luminance.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

// What preview.cpp leaves around the sphere.
constexpr double kMargin = 1.04;

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
      const double sine2 = kMargin * kMargin * (u * u + v * v);
      visit(k, sine2 > 1 - kRimCosine * kRimCosine);
    }
}

}  // namespace

PreviewView sphere_view(double lamp_theta) {
  PreviewView view = kView;
  view.lamp_theta = lamp_theta;
  return view;
}

PreviewColumn lit_sphere(const std::string& name, const ReflectionTowards& f,
                         const PreviewView& view) {
  return {name, render_lamp(f, {}, view)};
}

PreviewColumn lit_sphere(const std::string& name, const LobeTable& table, const PreviewView& view) {
  Specular specular;
  if (table.has_specular()) specular = [&](Direction wo) { return table.specular(wo); };
  return {name, render_lamp([&](Direction wo) { return table.towards(wo); }, specular, view)};
}

PreviewColumn lit_sphere(const std::string& name, const LobeTable& table) {
  return lit_sphere(name, table, kView);
}

namespace {

PreviewColumn lit_sphere_of(const std::string& name, const Model& model, double factor,
                            const PreviewView& view) {
  const auto f = [&](Direction wo) {
    return [&model, wo, factor](Direction wi) { return factor * model.eval(wi, wo); };
  };
  return {name, render_lamp(
                    f, [&](Direction wo) { return model.specular(wo); }, view)};
}

}  // namespace

PreviewColumn lit_sphere(const std::string& name, const Model& model, double factor) {
  return lit_sphere_of(name, model, factor, kView);
}

PreviewColumn lit_sphere(const std::string& name, const Model& model, const PreviewView& view) {
  return lit_sphere_of(name, model, 1, view);
}

PreviewColumn lit_sphere(const std::string& name, const Model& model) {
  return lit_sphere(name, model, kView);
}

PreviewColumn sphere_of(const std::string& name,
                        const std::function<Rgb(Direction normal)>& radiance) {
  const auto pixels = static_cast<std::size_t>(kSphereSize) * kSphereSize;
  PreviewColumn column{name,
                       {.width = kSphereSize,
                        .height = kSphereSize,
                        .radiance = std::vector<Rgb>(pixels),
                        .covered = std::vector<bool>(pixels)}};
  for (int y = 0; y < kSphereSize; ++y)
    for (int x = 0; x < kSphereSize; ++x) {
      const auto k = static_cast<std::size_t>(y) * kSphereSize + x;
      const double u = kMargin * ((2 * x + 1.0) / kSphereSize - 1);
      const double v = kMargin * (1 - (2 * y + 1.0) / kSphereSize);
      const double z2 = 1 - u * u - v * v;
      if (z2 <= 0) continue;
      column.image.covered[k] = true;
      column.image.radiance[k] = radiance({u, v, std::sqrt(z2)});
    }
  return column;
}

PreviewColumn furnace_sphere(const std::string& name, const Model& model) {
  constexpr int kNodes = 128;
  std::vector<Rgb> albedos(kNodes + 1);
  tbb::parallel_for(0, kNodes + 1, [&](int k) {
    albedos[k] = model.Model::albedo_with_error(direction_from_mu_phi(k / double{kNodes}, 0)).value;
  });
  return sphere_of(name, [&](Direction n) {
    const int k = std::min(kNodes - 1, static_cast<int>(n.z * kNodes));
    const double t = n.z * kNodes - k;
    return (1 - t) * albedos[k] + t * albedos[k + 1];
  });
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

double saturation(const PreviewColumn& picture) {
  Rgb sum;
  for (const Rgb& v : picture.image.radiance) sum += v;
  return sum.r / sum.b;
}

void write_spheres(ReproductionContext& context, const std::string& name, const std::string& title,
                   const std::vector<PreviewColumn>& columns) {
  context.write(name, [&](PictureFormat format) { return draw_preview(title, columns, format); });
}

void write_gallery(ReproductionContext& context, const std::string& name, const std::string& title,
                   const std::vector<PreviewColumn>& columns, std::optional<double> white) {
  context.write(name,
                [&](PictureFormat format) { return draw_gallery(title, columns, white, format); });
}

Stack figure_stack(const std::string& name, const std::string& toml) {
  return with_surface_model(parse_stack(toml, "reproduction", name));
}

LobeTable solved_table(const Stack& stack, const ReproductionContext& context) {
  TruthRequest request{.stack = stack};
  request.estimator = Estimator::deterministic;
  request.seed = context.seed;
  // Pictures of eight bits show no more.
  request.tolerance = context.by_quality(1e-2, 1e-3, 1e-4);
  LobeTable table = LobeTable::make(request, context.stop);
  context.go_on();
  return table;
}

LobeTable walked_table(const Stack& stack, std::uint64_t walks,
                       const ReproductionContext& context) {
  TruthRequest request{.stack = stack};
  request.estimator = Estimator::next_event;
  request.given = {WalkSetting::walks};
  request.effort.walks = walks;
  request.seed = context.seed;
  request.isa = isa_from_text("auto");
  LobeTable table = LobeTable::make(request, context.stop);
  context.go_on();
  return table;
}

BoundModel figure_model(const std::string& request, const Stack* stack) {
  return bind_model(parse_model_request(request), stack);
}

}  // namespace lamella
