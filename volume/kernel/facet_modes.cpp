#include "volume/kernel/facet_modes.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "phase/math/direction.h"
#include "volume/kernel/forward_projection.h"

namespace lamella {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kPointsPerInterval = 10;

// Ends of intervals in polar angle within (low, high), doubling away from the peak.
std::vector<double> interval_ends(const FacetProfile::Places& places, double low, double high) {
  std::vector<double> ends{low, high};
  const auto add = [&](double at) {
    if (at > low && at < high) ends.push_back(at);
  };
  for (const double edge : places.edges) add(edge);
  add(places.peak);
  for (double step = places.width / 2; step < kPi / 2; step *= 2) {
    add(places.peak - step);
    add(places.peak + step);
  }
  // Towards grazing, where masking and Fresnel's shares are steep.
  for (double step = 0.2; step > 1e-3; step /= 4) add(kPi / 2 - step);
  std::sort(ends.begin(), ends.end());
  ends.erase(
      std::unique(ends.begin(), ends.end(), [](double a, double b) { return b - a < 1e-12; }),
      ends.end());
  return ends;
}

// Means over each node of `set` of the modes of f, the other cosine fixed: [node, mode].
template <class ModesAt>
MatrixXd means_over_nodes(const DirectionSets& set, const FacetProfile::Places& places, int modes,
                          const ModesAt& modes_at) {
  MatrixXd result = MatrixXd::Zero(set.nodes(), modes);
  const Quadrature& rule = cached_gauss_legendre(kPointsPerInterval);
  ArrayXd values(modes);
  for (const NodePanel& panel : set.panels) {
    const double low = std::acos(std::min(1.0, panel.high())),
                 high = std::acos(std::min(1.0, panel.low()));
    const std::vector<double> ends = interval_ends(places, low, high);
    const Index count = static_cast<Index>(ends.size() - 1) * kPointsPerInterval;
    VectorXd u(count);
    MatrixXd samples(count, modes);
    Index k = 0;
    for (std::size_t e = 0; e + 1 < ends.size(); ++e)
      for (int p = 0; p < kPointsPerInterval; ++p, ++k) {
        const double length = ends[e + 1] - ends[e];
        const double theta = ends[e] + length * rule.points[p];
        const double mu = std::cos(theta);
        u[k] = panel.parameter(mu);
        modes_at(mu, values);
        samples.row(k) =
            (length * rule.weights[p] * std::sin(theta) * mu * values).matrix().transpose();
      }
    result.middleRows(panel.first, panel.count) =
        lagrange_values(cached_gauss_legendre(static_cast<int>(panel.count)), u).transpose() *
        samples;
  }
  return (set.flux / (2 * kPi)).cwiseInverse().asDiagonal() * result;
}

}  // namespace

FacetModes::FacetModes(const FacetProfile& profile, const DirectionSets& out,
                       const VectorXd& asked_out, const DirectionSets& in, const VectorXd& asked_in,
                       int modes) {
  const Index rows = out.nodes(), columns = in.nodes();
  f.assign(modes, MatrixXd(rows + asked_out.size(), columns + asked_in.size()));
  oneapi::tbb::parallel_for(Index{0}, columns + asked_in.size(), [&](Index j) {
    const double mu_i = j < columns ? in.in[j] : asked_in[j - columns];
    const MatrixXd means =
        means_over_nodes(out, profile.places(mu_i, true), modes,
                         [&](double mu, ArrayXd& values) { profile.modes(mu_i, mu, values); });
    for (int m = 0; m < modes; ++m) f[m].col(j).head(rows) = means.col(m);
    if (j < columns) return;
    ArrayXd values(modes);
    for (Index i = 0; i < asked_out.size(); ++i) {
      profile.modes(mu_i, asked_out[i], values);
      for (int m = 0; m < modes; ++m) f[m](rows + i, j) = values[m];
    }
  });
  oneapi::tbb::parallel_for(Index{0}, asked_out.size(), [&](Index i) {
    const double mu_o = asked_out[i];
    const MatrixXd means =
        means_over_nodes(in, profile.places(mu_o, false), modes,
                         [&](double mu, ArrayXd& values) { profile.modes(mu, mu_o, values); });
    for (int m = 0; m < modes; ++m) f[m].row(rows + i).head(columns) = means.col(m).transpose();
  });
  energy = out.flux.transpose() * f[0].topRows(rows);
}

}  // namespace lamella
