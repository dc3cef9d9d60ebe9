#include "volume/solver/diffuse_rows.h"

#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "phase/stack/single_scattering.h"
#include "volume/kernel/lambert_flake_kernel.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kFewestModes = 32, kMostModes = 256;
constexpr int kMostPanels = 64;
// Panels towards mu = 0, where f may vary like 1 / (mu_i + mu) with a small mu_i.
constexpr int kGrazingPanels = 4;

VectorXd modes_of(const Medium& medium, double mu_o, double mu_i, int modes) {
  if (const auto* sggx = std::get_if<LambertFlakes<Sggx>>(&medium))
    return lambert_flake_modes(sggx->ndf, mu_o, mu_i, modes);
  return lambert_flake_modes(std::get<LambertFlakes<Vmf>>(medium).ndf, mu_o, mu_i, modes);
}

// f of the diffuse layers at one pair of cosines: a row per layer, a column per mode in pi - phi.
class DiffuseModes {
 public:
  DiffuseModes(const Stack& stack, Direction wi, bool up) : stack_(stack), wi_(wi), up_(up) {
    for (std::size_t k = 0; k < stack.layers.size(); ++k)
      if (is_diffuse(stack.layers[k])) layers_.push_back(k);
  }

  [[nodiscard]] std::size_t layers() const { return layers_.size(); }
  [[nodiscard]] Rgb albedo(std::size_t k) const { return stack_.layers[layers_[k]].albedo; }

  [[nodiscard]] MatrixXd at(double mu, int modes) const {
    MatrixXd f = MatrixXd::Zero(static_cast<Eigen::Index>(layers_.size()), modes);
    std::vector<double> transport(stack_.layers.size());
    single_scattering_transport(stack_, wi_, direction_from_mu_phi(up_ ? mu : -mu, 0), transport);
    for (std::size_t k = 0; k < layers_.size(); ++k) {
      const double through = transport[layers_[k]];
      if (!(through > 0)) continue;
      const Medium& medium = stack_.layers[layers_[k]].medium;
      f.row(static_cast<Eigen::Index>(k)) =
          through / sigma(medium, wi_) * modes_of(medium, up_ ? mu : -mu, wi_.z, modes).transpose();
    }
    return f;
  }

 private:
  const Stack& stack_;
  Direction wi_;
  bool up_;
  std::vector<std::size_t> layers_;
};

// The integral over mu of mu f in elevations e0 to e1, mu = sin e.
struct Panel {
  double e0, e1;
  MatrixXd value{};
  double error = 0;  // of any cell

  Panel(const DiffuseModes& f, double from, double to, int modes) : e0(from), e1(to) {
    const auto integral = [&](int points) {
      const Quadrature& rule = cached_gauss_legendre(points);
      MatrixXd sum = MatrixXd::Zero(static_cast<Eigen::Index>(f.layers()), modes);
      for (int a = 0; a < points; ++a) {
        const double e = e0 + (e1 - e0) * rule.points[a], mu = std::sin(e);
        sum += (e1 - e0) * rule.weights[a] * mu * std::cos(e) * f.at(mu, modes);
      }
      return sum;
    };
    value = integral(4);
    const MatrixXd off = (value - integral(3)).cwiseAbs();
    error = 2 * (2 * off.sum() - off.col(0).sum());
  }
};

struct RowMeans {
  MatrixXd modes;
  double error = 0;
};

RowMeans row_means(const DiffuseModes& f, double mu0, double mu1, double mu_i, int modes,
                   double tolerance) {
  const double size = (mu1 - mu0) * (mu1 + mu0) / 2;
  std::vector<double> ends{std::asin(mu0)};
  const double high = std::asin(mu1), mirror = std::asin(mu_i);
  if (mu0 == 0)
    for (int k = kGrazingPanels - 1; k > 0; --k) ends.push_back(std::ldexp(high, -k));
  ends.push_back(high);
  // The overlap of two clamped cosines is not smooth where they are equal.
  if (mirror > ends.front() && mirror < high) {
    ends.push_back(mirror);
    std::sort(ends.begin(), ends.end());
  }
  std::vector<Panel> panels;
  for (std::size_t k = 0; k + 1 < ends.size(); ++k)
    panels.emplace_back(f, ends[k], ends[k + 1], modes);
  const auto error = [&] {
    double sum = 0;
    for (const Panel& panel : panels) sum += panel.error;
    return sum / size;
  };
  while (error() > tolerance && panels.size() < kMostPanels) {
    const auto worst =
        std::max_element(panels.begin(), panels.end(),
                         [](const auto& a, const auto& b) { return a.error < b.error; });
    const double e0 = worst->e0, e1 = worst->e1, middle = (e0 + e1) / 2;
    *worst = Panel(f, e0, middle, modes);
    panels.emplace_back(f, middle, e1, modes);
  }
  RowMeans row{MatrixXd::Zero(static_cast<Eigen::Index>(f.layers()), modes), error()};
  for (const Panel& panel : panels) row.modes += panel.value / size;
  return row;
}

// What modes beyond the last leave in a cell, from the last ones, which fall faster than m^-3.
double tail_of(const MatrixXd& modes) {
  constexpr int kLast = 4;
  const double last = modes.rightCols(kLast).cwiseAbs().rowwise().maxCoeff().sum();
  return last * static_cast<double>(modes.cols());
}

}  // namespace

bool is_diffuse(const Layer& layer) {
  return !layer.interface && layer.depth() > 0 && traits(layer.medium).shape == PhaseShape::diffuse;
}

MatrixXd column_cosines(const CellGrid& grid, int modes) {
  MatrixXd cosines(grid.columns(), modes);
  const double width = grid.edge_phi(1);
  for (int column = 0; column < grid.columns(); ++column)
    for (int m = 0; m < modes; ++m) {
      const double half = m * width / 2;
      cosines(column, m) = std::cos(m * (kPi - grid.edge_phi(column) - width / 2)) *
                           (m == 0 ? 1 : std::sin(half) / half);
    }
  return cosines;
}

Rgb diffuse_mean(const Stack& stack, Direction wi, bool up, double mu_o) {
  const DiffuseModes f(stack, with_grazing_limit(wi), up);
  const MatrixXd mean = f.at(mu_o, 1);
  Rgb sum;
  for (std::size_t k = 0; k < f.layers(); ++k)
    sum += mean(static_cast<Eigen::Index>(k), 0) * f.albedo(k);
  return sum;
}

std::vector<CellMean> diffuse_cells(const Stack& stack, const CellGrid& grid, Direction wi, bool up,
                                    double tolerance) {
  wi = with_grazing_limit(wi);
  const DiffuseModes f(stack, wi, up);
  std::vector<CellMean> cells(grid.cells());
  tbb::parallel_for(0, grid.rows(), [&](int row) {
    RowMeans means;
    int modes = kFewestModes;
    for (;; modes *= 2) {
      means = row_means(f, grid.edge_mu(row + 1), grid.edge_mu(row), std::abs(wi.z), modes,
                        tolerance / 2);
      if (tail_of(means.modes) <= tolerance / 2 || modes >= kMostModes) break;
    }
    const MatrixXd cosines = column_cosines(grid, modes);
    for (int column = 0; column < grid.columns(); ++column) {
      CellMean& cell = cells[row * grid.columns() + column];
      for (std::size_t k = 0; k < f.layers(); ++k) {
        const auto layer = means.modes.row(static_cast<Eigen::Index>(k));
        const double mean = 2 * layer.dot(cosines.row(column)) - layer[0];
        cell.value += mean * f.albedo(k);
      }
      cell.error =
          Rgb(means.error + tail_of(means.modes) + kPairModesError * means.modes.col(0).sum());
    }
  });
  return cells;
}

}  // namespace lamella
