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

// Beyond it the angle is the smooth variable, before it u.
constexpr double kMiddle = 0.5;

// Ends of intervals in polar angle within (low, high), doubling away from the peak.
std::vector<double> interval_ends(const FacetProfile::Places& places, double low, double middle,
                                  double high) {
  std::vector<double> ends{low, middle, high};
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
  ArrayXd values(modes);
  for (const NodePanel& panel : set.panels) {
    const double low = std::acos(std::min(1.0, panel.high())),
                 high = std::acos(std::min(1.0, panel.low()));
    const std::vector<double> ends = interval_ends(places, low, std::acos(panel.mu(kMiddle)), high);
    // Points for f and for the polynomials, which swing once between two nodes.
    const auto angle = [&](double theta) {
      return std::asin(std::sqrt(panel.parameter(std::cos(theta))));
    };
    std::vector<int> points;
    Index count = 0;
    for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
      const double nodes_there = static_cast<double>(panel.count) * (2 / kPi) *
                                 std::abs(angle(ends[e + 1]) - angle(ends[e]));
      points.push_back(kPointsPerInterval + static_cast<int>(1.2 * nodes_there));
      count += points.back();
    }
    VectorXd u(count);
    MatrixXd samples(count, modes);
    Index k = 0;
    for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
      const Quadrature& rule = cached_gauss_legendre(points[e]);
      const double u0 = e + 2 == ends.size() ? 0 : panel.parameter(std::cos(ends[e + 1]));
      const double u1 = panel.parameter(std::cos(ends[e]));
      const bool by_u = u0 + u1 < 2 * kMiddle;
      for (int p = 0; p < points[e]; ++p, ++k) {
        const double length = by_u ? u1 - u0 : ends[e + 1] - ends[e];
        const double at = (by_u ? u0 : ends[e]) + length * rule.points[p];
        const double mu = by_u ? panel.mu(at) : std::cos(at);
        u[k] = by_u ? at : panel.parameter(mu);
        modes_at(mu, values);
        const double measure =
            length * rule.weights[p] * mu * (by_u ? panel.slope(at) : std::sin(at));
        samples.row(k) = (measure / (u[k] * u[k] * u[k]) * values).matrix().transpose();
      }
    }
    const Quadrature& nodes = cached_gauss_legendre(static_cast<int>(panel.count));
    const VectorXd cubes = nodes.points.array().cube();
    result.middleRows(panel.first, panel.count) =
        cubes.asDiagonal() * (lagrange_values(nodes, u).transpose() * samples);
  }
  return (set.flux / (2 * kPi)).cwiseInverse().asDiagonal() * result;
}

}  // namespace

FacetModes::FacetModes(const FacetProfile& profile, const DirectionSets& out,
                       const VectorXd& asked_out, const DirectionSets& in, const VectorXd& asked_in,
                       int modes, bool with_asked_pairs) {
  const Index rows = out.nodes(), columns = in.nodes();
  f.assign(modes, MatrixXd::Zero(rows + asked_out.size(), columns + asked_in.size()));
  oneapi::tbb::parallel_for(Index{0}, columns + asked_in.size(), [&](Index j) {
    const double mu_i = j < columns ? in.in[j] : asked_in[j - columns];
    const MatrixXd means =
        means_over_nodes(out, profile.places(mu_i, true), modes,
                         [&](double mu, ArrayXd& values) { profile.modes(mu_i, mu, values); });
    for (int m = 0; m < modes; ++m) f[m].col(j).head(rows) = means.col(m);
    if (j < columns || !with_asked_pairs) return;
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
