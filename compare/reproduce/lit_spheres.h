#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "compare/preview/preview.h"
#include "compare/reproduce/reproduction.h"
#include "compare/request/model_request.h"
#include "compare/truth/lobe_table.h"

namespace lamella {

/// Width of a sphere in the pictures of a figure, and the lamp's polar angle [degrees].
inline constexpr int kSphereSize = 128;
inline constexpr double kSphereLamp = 45;

/// A sphere under a distant lamp at kSphereLamp, one sample per pixel.
[[nodiscard]] PreviewColumn lit_sphere(const std::string& name, const LobeTable& table);
[[nodiscard]] PreviewColumn lit_sphere(const std::string& name, const Model& model);
/// `factor`: of f.
[[nodiscard]] PreviewColumn lit_sphere(const std::string& name, const Model& model, double factor);

/// The same view with the lamp elsewhere [degrees]: 0 behind the viewer, 90 on the right, 180
/// behind the sphere.
[[nodiscard]] PreviewView sphere_view(double lamp_theta);
[[nodiscard]] PreviewColumn lit_sphere(const std::string& name, const Model& model,
                                       const PreviewView& view);
[[nodiscard]] PreviewColumn lit_sphere(const std::string& name, const LobeTable& table,
                                       const PreviewView& view);
/// By any reflection.
[[nodiscard]] PreviewColumn lit_sphere(const std::string& name, const ReflectionTowards& f,
                                       const PreviewView& view);

/// A sphere whose pixels are given by their normal, the viewer being at z.
[[nodiscard]] PreviewColumn sphere_of(const std::string& name,
                                      const std::function<Rgb(Direction normal)>& radiance);

/// A sphere in a furnace, light of radiance 1 from everywhere: the albedo of the direction to the
/// viewer, by cubature of the values at 128 cosines and linear between them. For reciprocal models.
[[nodiscard]] PreviewColumn furnace_sphere(const std::string& name, const Model& model);

/// How far a picture is from another, in luminance; relative to the other's root mean square.
struct SphereDifference {
  double rmse = 0;  ///< over all pixels that the lamp lights
  double rim = 0;   ///< over those that are seen at a cosine below kRimCosine
  double mean = 0;  ///< of the mean luminances
};
inline constexpr double kRimCosine = 0.5;
[[nodiscard]] SphereDifference difference(const PreviewColumn& picture, const PreviewColumn& from);
/// Mean luminance over the sphere, and over its rim.
struct SphereLuminance {
  double mean, rim;
};
[[nodiscard]] SphereLuminance luminance_of(const PreviewColumn& picture);

/// The mean red over the mean blue of a picture.
[[nodiscard]] double saturation(const PreviewColumn& picture);

/// Writes the pictures side by side, below each its difference from the first.
void write_spheres(ReproductionContext& context, const std::string& name, const std::string& title,
                   const std::vector<PreviewColumn>& columns);

/// Writes the pictures side by side, without differences; `white` as in draw_gallery.
void write_gallery(ReproductionContext& context, const std::string& name, const std::string& title,
                   const std::vector<PreviewColumn>& columns, std::optional<double> white = {});

/// A stack by its text, the substrate's law made. Throws StackFileError.
[[nodiscard]] Stack figure_stack(const std::string& name, const std::string& toml);
/// Its truth by the solver.
[[nodiscard]] LobeTable solved_table(const Stack& stack, const ReproductionContext& context);
/// Its truth by that many next-event walks per viewing angle.
[[nodiscard]] LobeTable walked_table(const Stack& stack, std::uint64_t walks,
                                     const ReproductionContext& context);
/// A closed form by its request.
[[nodiscard]] BoundModel figure_model(const std::string& request, const Stack* stack = nullptr);

}  // namespace lamella
