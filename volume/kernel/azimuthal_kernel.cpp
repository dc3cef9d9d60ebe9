#include "volume/kernel/azimuthal_kernel.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "volume/kernel/forward_projection.h"
#include "volume/kernel/kernel_profiles.h"
#include "volume/kernel/lambert_flake_kernel.h"

namespace lamella {
namespace {

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
                    bool two_sided, const MatrixProduct& product) {
  const VectorXd &out = sets.out, &in = sets.in;
  KernelModes kernel;
  Parts empty;
  for (MatrixXd& part : empty) part.resize(out.size(), in.size());
  kernel.modes.assign(modes, empty);
  kernel.white = empty;
  for (int part = 0; part < (two_sided ? 2 : 4); ++part)
    oneapi::tbb::parallel_for(Eigen::Index{0}, in.size(), [&](Eigen::Index j) {
      std::vector<CosinePair> pairs;
      for (const double mu_o : out) pairs.push_back({kSignIn[part] * in[j], kSignOut[part] * mu_o});
      const MatrixXd found = many_pair_modes(profile, f0, pairs, modes, product);
      for (int m = 0; m < modes; ++m) kernel.modes[m][part].col(j) = found.row(m);
      kernel.white[part].col(j) = found.row(modes);
    });
  if (two_sided)
    for (int part = 0; part < 2; ++part) {
      for (Parts& mode : kernel.modes) mode[part + 2] = mode[part];
      kernel.white[part + 2] = kernel.white[part];
    }
  return kernel;
}

template <class Ndf>
KernelModes modes_of(const LambertFlakes<Ndf>& medium, double, const DirectionSets& sets, int modes,
                     const MatrixProduct& product) {
  return lambert_flake_modes(medium.ndf, sets.out, sets.in, modes, product);
}

// Media whose kernel is known in closed form.
template <class M>
KernelModes modes_of(const M& medium, double f0, const DirectionSets& sets, int modes,
                     const MatrixProduct& product) {
  static_assert(
      requires { kernel_profile(medium); },
      "the solver needs a kernel_profile() of this medium: see kernel_profiles.h");
  const MediumTraits traits = medium.traits();
  const auto profile = kernel_profile(medium);
  KernelModes kernel = sampled(profile, f0, sets, modes, traits.two_sided, product);
  if (traits.shape == PhaseShape::jump || !is_resolved(traits.mean_cosine, sets))
    project_forward(profile, f0, sets, traits.two_sided, product, kernel);
  return kernel;
}

}  // namespace

KernelModes kernel_modes(const Medium& medium, double f0, const DirectionSets& sets, int modes,
                         const MatrixProduct& product) {
  return std::visit([&](const auto& m) { return modes_of(m, f0, sets, modes, product); }, medium);
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
      [](double, double, double) { return 4.0; }, true, true};
  return sampled(profile, 1, sets, modes, true, MatrixProduct());
}

}  // namespace lamella
