#include "volume/harmonics/depth_panels.h"

#include <algorithm>
#include <cmath>

#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kRule = 24;  // points of the rule that serves exp(-y) up to kLargest
constexpr double kLargest = 24;

// Distances from a boundary at which panels end, up to the middle, all in optical depth.
std::vector<double> edges_to(double middle, double finest) {
  std::vector<double> edges{0};
  double at = std::min(finest, middle);
  while (at < middle) {
    edges.push_back(at);
    at = at < 0.3 ? 4 * at : at + std::max(1.0, 0.4 * at);
  }
  // No sliver in the middle.
  if (edges.size() > 2 && middle - edges.back() < 0.3 * (edges.back() - edges[edges.size() - 2]))
    edges.back() = middle;
  else
    edges.push_back(middle);
  return edges;
}

}  // namespace

DepthPanels::DepthPanels(double depth, double scale, double finest, int nodes)
    : nodes_(nodes), depth_(depth) {
  const std::vector<double> edges =
      edges_to(depth * scale / 2, std::clamp(finest * scale, 1e-12, 1.0));
  const int half = static_cast<int>(edges.size()) - 1;
  const Quadrature& rule = cached_gauss_legendre(nodes);
  const auto add = [&](int edge, bool mirrored) {
    const double length = (edges[edge + 1] - edges[edge]) / scale;
    const double top = mirrored ? depth - edges[edge + 1] / scale : edges[edge] / scale;
    kind_.push_back(edge);
    for (int j = 0; j < nodes; ++j) {
      place_.push_back(top + length * rule.points[j]);
      weight_.push_back(length * rule.weights[j]);
    }
  };
  for (int edge = 0; edge < half; ++edge) {
    kinds_.push_back((edges[edge + 1] - edges[edge]) / scale);
    add(edge, false);
  }
  for (int edge = half; edge-- > 0;) add(edge, true);
}

PanelIntegrals::PanelIntegrals(int nodes) : nodes_(nodes), points_(nodes + 1) {
  points_.head(nodes) = cached_gauss_legendre(nodes).points;
  points_[nodes] = 1;
  const Quadrature& rule = cached_gauss_legendre(kRule);
  for (int i = 0; i <= nodes; ++i) {
    MatrixXd powers = MatrixXd::Zero(nodes, nodes), values(nodes, kRule);
    for (int j = 0; j < nodes; ++j) {
      // The product over k of (t - t_k) / (t_j - t_k), t = t_i s, power by power.
      VectorXd polynomial = VectorXd::Zero(nodes);
      polynomial[0] = 1;
      int degree = 0;
      for (int k = 0; k < nodes; ++k) {
        if (k == j) continue;
        const double below = points_[j] - points_[k];
        for (int d = ++degree; d >= 0; --d)
          polynomial[d] = ((d > 0 ? points_[i] * polynomial[d - 1] : 0) -
                           points_[k] * (d < degree ? polynomial[d] : 0)) /
                          below;
      }
      powers.row(j) = points_[i] * polynomial.transpose();
      for (int q = 0; q < kRule; ++q) {
        const double t = points_[i] * rule.points[q];
        double value = 1;
        for (int k = 0; k < nodes; ++k)
          if (k != j) value *= (t - points_[k]) / (points_[j] - points_[k]);
        values(j, q) = points_[i] * rule.weights[q] * value;
      }
    }
    powers_.push_back(std::move(powers));
    values_.push_back(std::move(values));
  }
}

void PanelIntegrals::moments(double y, double* phi) const {
  phi[0] = -std::expm1(-y) / y;
  for (int k = 1; k < nodes_; ++k) phi[k] = (1 - k * phi[k - 1]) / y;
}

void PanelIntegrals::at(double x, double* gather, double* leave, double* pass) const {
  const Quadrature& rule = cached_gauss_legendre(kRule);
  double phi[64], decay[kRule];
  for (int i = gather ? 0 : nodes_; i <= nodes_; ++i) {
    const double y = x * points_[i];
    double* row = i < nodes_ ? gather + i : leave;
    const int stride = i < nodes_ ? nodes_ : 1;
    if (i < nodes_) pass[i] = std::exp(-y);
    if (y > kLargest) {
      moments(y, phi);
      for (int j = 0; j < nodes_; ++j) {
        double sum = 0;
        for (int k = 0; k < nodes_; ++k) sum += powers_[i](j, k) * phi[k];
        row[j * stride] = sum;
      }
    } else {
      for (int q = 0; q < kRule; ++q) decay[q] = std::exp(-y * (1 - rule.points[q]));
      for (int j = 0; j < nodes_; ++j) {
        double sum = 0;
        for (int q = 0; q < kRule; ++q) sum += values_[i](j, q) * decay[q];
        row[j * stride] = sum;
      }
    }
  }
}

}  // namespace lamella
