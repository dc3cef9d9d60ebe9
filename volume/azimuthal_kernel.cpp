#include "volume/azimuthal_kernel.h"

#include <algorithm>
#include <cmath>

#include "volume/forward_projection.h"
#include "volume/lambert_flake_kernel.h"
#include "volume/pair_modes.h"

namespace lamella {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Mean cosine above which a particle's forward peak is projected like a mirror's jump; below, the
// nodes resolve it and the plain values converge faster.
constexpr double kPeaked = 0.85;

constexpr int kSignIn[4] = {1, 1, -1, -1};
constexpr int kSignOut[4] = {1, -1, -1, 1};

template <class P>
KernelModes sampled(const P& profile, double f0, const DirectionSets& sets, int modes,
                    bool two_sided) {
  const VectorXd &out = sets.out, &in = sets.in;
  KernelModes kernel;
  Parts empty;
  for (MatrixXd& part : empty) part.resize(out.size(), in.size());
  kernel.modes.assign(modes, empty);
  kernel.white = empty;
  ArrayXd values(modes);
  for (int part = 0; part < (two_sided ? 2 : 4); ++part)
    for (Eigen::Index j = 0; j < in.size(); ++j)
      for (Eigen::Index i = 0; i < out.size(); ++i) {
        pair_modes(profile, f0, kSignIn[part] * in[j], kSignOut[part] * out[i], values,
                   kernel.white[part](i, j));
        for (int m = 0; m < modes; ++m) kernel.modes[m][part](i, j) = values[m];
      }
  if (two_sided)
    for (int part = 0; part < 2; ++part) {
      for (Parts& mode : kernel.modes) mode[part + 2] = mode[part];
      kernel.white[part + 2] = kernel.white[part];
    }
  return kernel;
}

template <class Ndf>
KernelModes mirror(const MirrorFlakes<Ndf>& flakes, double ratio, double f0,
                   const DirectionSets& sets, int modes, bool two_sided) {
  const double shrink = std::min(1.0, ratio * ratio);
  const auto profile = Profile{[&](double hxy2, double hz) {
                                 // Opposite directions: the limit across the vertical plane.
                                 if (hxy2 == 0 && hz == 0) hxy2 = 1;
                                 return flakes.ndf.density_of({std::sqrt(hxy2), 0, hz}) / 4;
                               },
                               [&](double mu_i, double mu_o, double gap) {
                                 return gap + shrink * (mu_i + mu_o) * (mu_i + mu_o);
                               },
                               true};
  KernelModes kernel = sampled(profile, f0, sets, modes, two_sided);
  project_forward(profile, f0, sets, two_sided, kernel);
  return kernel;
}

}  // namespace

KernelModes kernel_modes(const Medium& medium, double f0, const DirectionSets& sets, int modes) {
  const auto opposite = [](double mu_i, double mu_o, double gap) {
    return gap + (mu_i + mu_o) * (mu_i + mu_o);
  };
  struct Visitor {
    double f0;
    const DirectionSets& sets;
    int modes;
    const decltype(opposite)& reach;

    KernelModes operator()(const MirrorFlakes<Sggx>& m) const {
      const double ratio = m.ndf.sigma({1, 0, 0}) / m.ndf.sigma({0, 0, 1});
      return mirror(m, ratio, f0, sets, modes, true);
    }
    KernelModes operator()(const MirrorFlakes<Vmf>& m) const {
      return mirror(m, m.ndf.alpha(), f0, sets, modes, false);
    }
    KernelModes operator()(const LambertFlakes<Sggx>& m) const {
      return lambert_flake_modes(m.ndf, sets.out, sets.in, modes);
    }
    KernelModes operator()(const LambertFlakes<Vmf>& m) const {
      return lambert_flake_modes(m.ndf, sets.out, sets.in, modes);
    }
    KernelModes operator()(const LambertSphere&) const {
      return sampled(
          Profile{[](double hxy2, double hz) {
                    return lambert_sphere_phase(std::max(-1.0, 1 - (hxy2 + hz * hz) / 2));
                  },
                  reach, true},
          1, sets, modes, true);
    }
    KernelModes operator()(const HenyeyGreenstein& m) const {
      const double g = std::abs(m.g);
      const double width = g > 0 ? (1 - g) * (1 - g) / g : 1e3;
      const bool forward = m.g >= 0;
      const auto profile = Profile{[&](double hxy2, double hz) {
                                     return henyey_greenstein_phase(m.g, 1 - (hxy2 + hz * hz) / 2);
                                   },
                                   [&](double mu_i, double mu_o, double gap) {
                                     const double dz = forward ? mu_i + mu_o : mu_i - mu_o;
                                     return width + gap + dz * dz;
                                   },
                                   forward};
      KernelModes kernel = sampled(profile, 1, sets, modes, true);
      if (m.g > kPeaked) project_forward(profile, 1, sets, true, kernel);
      return kernel;
    }
  };
  return std::visit(Visitor{f0, sets, modes, opposite}, medium);
}

bool is_same_medium(const Medium& a, const Medium& b) {
  if (a.index() != b.index()) return false;
  const auto same_ndf = [](const auto& m, const auto& n) {
    using Ndf = std::decay_t<decltype(m)>;
    if constexpr (std::is_same_v<Ndf, Sggx>) {
      const auto &p = m.matrix(), &q = n.matrix();
      return p.a00 == q.a00 && p.a10 == q.a10 && p.a11 == q.a11 && p.a20 == q.a20 &&
             p.a21 == q.a21 && p.a22 == q.a22;
    } else {
      return m.alpha() == n.alpha() && m.axis() == n.axis();
    }
  };
  return std::visit(
      [&](const auto& m) {
        using M = std::decay_t<decltype(m)>;
        const M& n = std::get<M>(b);
        if constexpr (std::is_same_v<M, HenyeyGreenstein>)
          return m.g == n.g;
        else if constexpr (std::is_same_v<M, LambertSphere>)
          return true;
        else
          return same_ndf(m.ndf, n.ndf);
      },
      a);
}

bool is_two_sided(const Medium& medium) {
  return !std::holds_alternative<MirrorFlakes<Vmf>>(medium) &&
         !std::holds_alternative<LambertFlakes<Vmf>>(medium);
}

}  // namespace lamella
