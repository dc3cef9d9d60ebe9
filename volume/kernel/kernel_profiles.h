#pragma once

#include "phase/medium/medium.h"
#include "volume/kernel/pair_modes.h"

namespace lamella {

/// The kernel sigma p [1/sr] at albedo 1 and f0 = 1 of the media that have it in closed form, as a
/// function of h = w_i + w_o by |h_xy|^2 and h_z, with its nearest complex singularity
/// (volume/kernel/pair_modes.h). Vertical axes.
[[nodiscard]] inline auto kernel_profile(const MirrorFlakes<Sggx>& m) {
  const double across = m.ndf.sigma({1, 0, 0}), along = m.ndf.sigma({0, 0, 1});
  const double across2 = across * across, along2 = along * along;
  const double scale = 1 / (4 * kPi * across2 * along);
  const double shrink = std::min(1.0, across2 / along2);
  return Profile{[=](double hxy2, double hz) {
                   const double hz2 = hz * hz;
                   // Opposite directions: the limit across the vertical plane.
                   if (hxy2 == 0 && hz == 0) hxy2 = 1;
                   const double ratio = (hxy2 + hz2) / (hxy2 / across2 + hz2 / along2);
                   return scale * ratio * ratio;
                 },
                 [=](double mu_i, double mu_o, double gap) {
                   return gap + shrink * (mu_i + mu_o) * (mu_i + mu_o);
                 },
                 true, true};
}

[[nodiscard]] inline auto kernel_profile(const MirrorFlakes<Vmf>& m) {
  const double sign = m.ndf.axis().z < 0 ? -1 : 1;
  const double alpha = m.ndf.alpha(), kappa = vmf_concentration(alpha);
  const double peak = m.ndf.density_of(m.ndf.axis()) / 4;
  const double shrink = std::min(1.0, alpha * alpha);
  return Profile{[=](double hxy2, double hz) {
                   if (hxy2 == 0 && hz == 0) hxy2 = 1;
                   const double length = std::sqrt(hxy2 + hz * hz), up = sign * hz;
                   // cosine - 1, without cancellation near 1
                   const double less = up > 0 ? -hxy2 / (length * (length + up)) : up / length - 1;
                   return peak * std::exp(kappa * less);
                 },
                 [=](double mu_i, double mu_o, double gap) {
                   return gap + shrink * (mu_i + mu_o) * (mu_i + mu_o);
                 },
                 true, false};
}

[[nodiscard]] inline auto kernel_profile(const LambertSphere&) {
  return Profile{
      [](double hxy2, double hz) {
        return lambert_sphere_phase(std::max(-1.0, 1 - (hxy2 + hz * hz) / 2));
      },
      [](double mu_i, double mu_o, double gap) { return gap + (mu_i + mu_o) * (mu_i + mu_o); },
      true, true};
}

[[nodiscard]] inline auto kernel_profile(const Rayleigh&) {
  return Profile{
      [](double hxy2, double hz) { return rayleigh_phase(1 - (hxy2 + hz * hz) / 2); },
      [](double mu_i, double mu_o, double gap) { return gap + (mu_i + mu_o) * (mu_i + mu_o); },
      true, true};
}

[[nodiscard]] inline auto kernel_profile(const HenyeyGreenstein& m) {
  const double g = m.g, size = std::abs(g);
  const double width = size > 0 ? (1 - size) * (1 - size) / size : 1e3;
  const bool forward = g >= 0;
  return Profile{
      // |h|^2 / 2 = 1 - cosine; rounding must not leave the peak of g < 0 behind.
      [=](double hxy2, double hz) {
        const double half = (hxy2 + hz * hz) / 2;
        return henyey_greenstein_phase_beside(g, forward ? half : std::max(0.0, 2 - half));
      },
      [=](double mu_i, double mu_o, double gap) {
        const double dz = forward ? mu_i + mu_o : mu_i - mu_o;
        return width + gap + dz * dz;
      },
      forward, true};
}

/// Calls f with the profile of a medium that has one; false for Lambertian flakes.
template <class F>
bool visit_profile(const Medium& medium, const F& f) {
  return std::visit(
      [&](const auto& m) {
        if constexpr (requires { kernel_profile(m); }) {
          f(kernel_profile(m));
          return true;
        } else {
          return false;
        }
      },
      medium);
}

}  // namespace lamella
