#include "volume/kernel/azimuthal_kernel.h"

#include <algorithm>
#include <cmath>

#include "volume/kernel/forward_projection.h"
#include "volume/kernel/kernel_profiles.h"
#include "volume/kernel/lambert_flake_kernel.h"

namespace lamella {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Whether the nodes resolve a particle's forward peak: then plain values converge exponentially,
// else it is projected like a mirror's jump.
bool is_resolved(double g, const DirectionSets& sets) {
  constexpr double kPeaked = 0.85, kNodesPerPeak = 4;
  return g <= kPeaked || static_cast<double>(sets.nodes()) * (1 - g) >= kNodesPerPeak;
}

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

template <class M>
KernelModes projected(const M& medium, double f0, const DirectionSets& sets, int modes,
                      bool two_sided) {
  const auto profile = kernel_profile(medium);
  KernelModes kernel = sampled(profile, f0, sets, modes, two_sided);
  project_forward(profile, f0, sets, two_sided, kernel);
  return kernel;
}

}  // namespace

KernelModes kernel_modes(const Medium& medium, double f0, const DirectionSets& sets, int modes) {
  struct Visitor {
    double f0;
    const DirectionSets& sets;
    int modes;

    KernelModes operator()(const MirrorFlakes<Sggx>& m) const {
      return projected(m, f0, sets, modes, true);
    }
    KernelModes operator()(const MirrorFlakes<Vmf>& m) const {
      return projected(m, f0, sets, modes, false);
    }
    KernelModes operator()(const LambertFlakes<Sggx>& m) const {
      return lambert_flake_modes(m.ndf, sets.out, sets.in, modes);
    }
    KernelModes operator()(const LambertFlakes<Vmf>& m) const {
      return lambert_flake_modes(m.ndf, sets.out, sets.in, modes);
    }
    KernelModes operator()(const LambertSphere& m) const {
      return sampled(kernel_profile(m), 1, sets, modes, true);
    }
    KernelModes operator()(const HenyeyGreenstein& m) const {
      return is_resolved(m.g, sets) ? sampled(kernel_profile(m), 1, sets, modes, true)
                                    : projected(m, 1, sets, modes, true);
    }
  };
  return std::visit(Visitor{f0, sets, modes}, medium);
}

KernelModes legendre_modes(std::span<const double> terms, const DirectionSets& sets, int modes) {
  const auto profile = Profile{
      [&](double hxy2, double hz) {
        const double cosine = 1 - (hxy2 + hz * hz) / 2;
        double sum = 0, before = 0, now = 1;
        for (std::size_t l = 0; l < terms.size(); ++l) {
          const double order = static_cast<double>(l);
          sum += terms[l] * now;
          const double next = ((2 * order + 1) * cosine * now - order * before) / (order + 1);
          before = now;
          now = next;
        }
        return sum / (4 * kPi);
      },
      [](double, double, double) { return 4.0; }, true};
  return sampled(profile, 1, sets, modes, true);
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
