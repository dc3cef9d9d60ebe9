#include "volume/solver/row_sampler.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "volume/quadrature/quadrature.h"
#include "volume/solver/closed_orders.h"

namespace lamella {
namespace {

// Panels in mu that hold whole rows of cells, and how many points the first round gives each.
constexpr int kPanels = 16, kPoints = 6, kMaxPoints = 48;
// Powers of t that make f smooth where it is steep, and where it behaves like a root.
constexpr int kSteepPower = 3, kRootPower = 4;

// Where f is steep within a panel: at one of its ends, or nowhere.
enum class Steep { nowhere, low, high };

// Rows k: values at a panel's points to the k-th coefficient of their Legendre series.
Eigen::MatrixXd legendre_transform(int points) {
  const Quadrature& nodes = cached_gauss_legendre(points);
  Eigen::MatrixXd transform(points, points);
  for (int j = 0; j < points; ++j) {
    const double x = 2 * nodes.points[j] - 1;
    double before = 0, now = 1;
    for (int k = 0; k < points; ++k) {
      transform(k, j) = (2 * k + 1) * nodes.weights[j] * now;
      const double next = ((2 * k + 1) * x * now - k * before) / (k + 1);
      before = now;
      now = next;
    }
  }
  return transform;
}

// What the terms beyond the last leave of an error in the means over a panel's rows, from the decay
// of the last two thirds of the series. Gauss's rule sees a whole panel to twice the degree of the
// interpolation that serves its parts.
double series_error(const Eigen::VectorXd& coefficients, bool one_row) {
  const Eigen::Index n = coefficients.size(), third = n / 3;
  const double middle = coefficients.segment(n - 2 * third, third).cwiseAbs().maxCoeff();
  const double last = coefficients.tail(third).cwiseAbs().maxCoeff();
  if (last == 0) return 0;
  const double decay = std::min(1.0, last / std::max(middle, last));
  return last * std::pow(decay, one_row ? 3 : 0.5);
}

}  // namespace

RowModes& RowModes::operator+=(const RowModes& part) {
  for (int order = 0; order < kAllModeOrders; ++order) {
    std::vector<double>& sum = mode[order];
    sum.resize(std::max(sum.size(), part.mode[order].size()), 0.0);
    for (std::size_t m = 0; m < part.mode[order].size(); ++m) sum[m] += part.mode[order][m];
  }
  scale += part.scale;
  error += part.error;
  return *this;
}

// Rows of cells, the first and last perhaps in part, with the points that sample them, in a
// parameter t from 0 to 1 of the elevation e, mu = sin e: odd modes behave like the sine of the
// polar angle, which is smooth in the angle only.
struct RowSampler::Panel {
  int first_row, end_row;
  double low, high;  // elevations
  Steep steep = Steep::nowhere;
  int power = kSteepPower;
  int points = kPoints;

  // edges: where f is not smooth, besides mu = 0.
  [[nodiscard]] static std::vector<Panel> make(const CellGrid& grid, const PanelEdges& edges);
  [[nodiscard]] Eigen::MatrixXd row_weights(const CellGrid& grid) const;

  // Radiance behaves like mu log mu at grazing, and that of mirror flakes like x log x, x the
  // distance from |mu_i|: a distance of t^3 makes that smooth; t^4 does so at a critical angle,
  // where it behaves like the root of x.
  [[nodiscard]] double elevation(double t) const {
    const double length = high - low, back = 1 - t;
    return steep == Steep::low    ? low + length * raised(t)
           : steep == Steep::high ? high - length * raised(back)
                                  : low + length * t;
  }
  [[nodiscard]] double mu(double t) const { return std::sin(elevation(t)); }
  // d mu / dt
  [[nodiscard]] double slope(double t) const {
    const double from = steep == Steep::high ? 1 - t : t;
    const double rise = steep == Steep::nowhere ? 1 : power * from * from;
    return std::cos(elevation(t)) * (high - low) *
           (steep != Steep::nowhere && power == kRootPower ? rise * from : rise);
  }
  // Within [0, 1], whatever mu is.
  [[nodiscard]] double parameter(double m) const {
    const double part = std::clamp((std::asin(m) - low) / (high - low), 0.0, 1.0);
    return steep == Steep::low ? root(part) : steep == Steep::high ? 1 - root(1 - part) : part;
  }
  [[nodiscard]] double raised(double t) const {
    return power == kRootPower ? t * t * t * t : t * t * t;
  }
  [[nodiscard]] double root(double x) const {
    return power == kRootPower ? std::sqrt(std::sqrt(x)) : std::cbrt(x);
  }
};

std::vector<RowSampler::Panel> RowSampler::Panel::make(const CellGrid& grid,
                                                       const PanelEdges& edges) {
  constexpr double kSame = 1e-9;  // elevations
  std::vector<double> steep{0}, roots, ends;
  for (const double mu : edges.steep) steep.push_back(std::asin(mu));
  for (const double mu : edges.root) roots.push_back(std::asin(mu));
  steep.insert(steep.end(), roots.begin(), roots.end());
  const int count = std::min(grid.rows(), kPanels);
  for (int p = 0; p <= count; ++p) ends.push_back(std::asin(grid.edge_mu(p * grid.rows() / count)));
  for (const double e : steep) ends.push_back(e);
  std::sort(ends.begin(), ends.end());
  ends.erase(
      std::unique(ends.begin(), ends.end(), [](double x, double y) { return y - x < kSame; }),
      ends.end());
  const auto is_in = [&](const std::vector<double>& list, double e) {
    return std::any_of(list.begin(), list.end(), [&](double s) { return std::abs(s - e) < kSame; });
  };
  std::vector<Panel> panels;
  const auto add = [&](double from, double to, Steep where) {
    Panel panel{grid.rows(), 0, from, to, where};
    if (where != Steep::nowhere && is_in(roots, where == Steep::low ? from : to))
      panel.power = kRootPower;
    for (int row = 0; row < grid.rows(); ++row)
      if (std::asin(grid.edge_mu(row)) > from + kSame &&
          std::asin(grid.edge_mu(row + 1)) < to - kSame) {
        panel.first_row = std::min(panel.first_row, row);
        panel.end_row = row + 1;
      }
    panels.push_back(panel);
  };
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    const double low = ends[k], high = ends[k + 1], middle = (low + high) / 2;
    const bool at_low = is_in(steep, low), at_high = is_in(steep, high);
    if (at_low && at_high) {
      add(low, middle, Steep::low);
      add(middle, high, Steep::high);
    } else {
      add(low, high, at_low ? Steep::low : at_high ? Steep::high : Steep::nowhere);
    }
  }
  return panels;
}

// Weights of a panel's points for its part of the cosine-weighted mean over each of its rows: the
// integral of the interpolating polynomial.
Eigen::MatrixXd RowSampler::Panel::row_weights(const CellGrid& grid) const {
  const Quadrature& nodes = cached_gauss_legendre(points);
  const Quadrature& rule = cached_gauss_legendre(points + 4);
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(end_row - first_row, points);
  for (int row = first_row; row < end_row; ++row) {
    const double t0 = parameter(grid.edge_mu(row + 1));
    const double t1 = parameter(grid.edge_mu(row));
    for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
      const double t = t0 + (t1 - t0) * rule.points[k];
      const double measure = (t1 - t0) * rule.weights[k] * mu(t) * slope(t);
      for (int j = 0; j < points; ++j) {
        double basis = 1;
        for (int l = 0; l < points; ++l)
          if (l != j) basis *= (t - nodes.points[l]) / (nodes.points[j] - nodes.points[l]);
        weights(row - first_row, j) += measure * basis;
      }
    }
    const double above = grid.edge_mu(row), below = grid.edge_mu(row + 1);
    weights.row(row - first_row) /= (above - below) * (above + below) / 2;
  }
  return weights;
}

RowSampler::RowSampler(const DeterministicSolution& solution, const CellGrid& grid, int channels,
                       bool both_sides, std::vector<double> mu_i, const PanelEdges& edges,
                       double tolerance, const std::atomic<bool>* stop,
                       const std::function<void(double share)>& report)
    : solution_(solution),
      grid_(grid),
      channels_(channels),
      sides_(both_sides ? 2 : 1),
      orders_(is_first_closed(solution.stack()) ? kModeOrders : kAllModeOrders),
      mu_i_(std::move(mu_i)),
      tolerance_(tolerance),
      stop_(stop),
      rows_(mu_i_.size() * channels * sides_ * grid.rows()) {
  std::vector<Panel> panels = Panel::make(grid, edges);
  const double all = static_cast<double>(panels.size());
  while (!panels.empty()) {
    panels = sample(panels);
    report(1 - static_cast<double>(panels.size()) / all);
  }
}

std::vector<RowSampler::Panel> RowSampler::sample(const std::vector<Panel>& panels) {
  std::vector<double> mu_o;
  for (const Panel& panel : panels) {
    const Quadrature& nodes = cached_gauss_legendre(panel.points);
    for (int j = 0; j < panel.points; ++j) mu_o.push_back(panel.mu(nodes.points[j]));
  }
  const std::size_t below = mu_o.size();
  if (sides_ == 2)
    for (std::size_t o = 0; o < below; ++o) mu_o.push_back(-mu_o[o]);
  const DeterministicField field = solution_.field(mu_i_, mu_o, true, stop_);
  std::vector<Panel> refined;
  std::size_t first = 0;
  for (const Panel& panel : panels) {
    const Eigen::MatrixXd weights = panel.row_weights(grid_);
    const Eigen::MatrixXd transform = legendre_transform(panel.points);
    const std::size_t rows = panel.end_row - panel.first_row;
    std::vector<RowModes> parts(mu_i_.size() * channels_ * sides_ * rows);
    std::atomic<bool> good = true;
    tbb::parallel_for(std::size_t{0}, mu_i_.size(), [&](std::size_t i) {
      for (int channel = 0; channel < channels_; ++channel)
        for (int side = 0; side < sides_; ++side)
          if (!take(panel, weights, transform, field, i, channel, first + side * below,
                    &parts[((i * channels_ + channel) * sides_ + side) * rows]))
            good = false;
    });
    first += panel.points;
    if (!good && panel.points < kMaxPoints && !(stop_ && *stop_)) {
      refined.push_back(panel);
      refined.back().points *= 2;
      continue;
    }
    for (std::size_t k = 0; k < parts.size(); ++k)
      rows_[k / rows * grid_.rows() + panel.first_row + k % rows] += parts[k];
  }
  return refined;
}

bool RowSampler::take(const Panel& panel, const Eigen::MatrixXd& weights,
                      const Eigen::MatrixXd& transform, const DeterministicField& field,
                      std::size_t i, int channel, std::size_t first, RowModes* parts) const {
  const int n = panel.points, rows = panel.end_row - panel.first_row;
  const int modes = field.modes(channel);
  const double width = grid_.edge_phi(1);
  Eigen::VectorXd scale(n), error(n);
  for (int j = 0; j < n; ++j) {
    scale[j] = field.scale(channel, i, first + j);
    error[j] = field.error_of_mean(channel, i, first + j, width);
  }
  // One row's mean is Gauss's rule for f times its weight, which is smooth where f is not: f
  // grows like log mu at grazing for light that grazes.
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(n);
  if (rows == 1)
    weight = weights.row(0).transpose().cwiseQuotient(cached_gauss_legendre(n).weights);
  double left = 0;
  // The field's numbers of those orders.
  constexpr std::array<int, kAllModeOrders> kFieldOrder{1, 2, 3, 0, 5};
  Eigen::MatrixXd values(n, orders_);
  std::vector<Eigen::MatrixXd> means;
  for (int m = 0; m < modes; ++m) {
    for (int j = 0; j < n; ++j)
      for (int order = 0; order < orders_; ++order)
        values(j, order) = field.mode(channel, kFieldOrder[order], m, i, first + j);
    means.emplace_back(weights * values);
    left += (m == 0 ? 1 : 2) * share_in_mean(m, width) *
            series_error(transform * weight.cwiseProduct(values.rowwise().sum()), rows == 1);
  }
  const Eigen::VectorXd row_scale = weights * scale, row_error = weights.cwiseAbs() * error;
  for (int r = 0; r < rows; ++r) {
    RowModes& row = parts[r];
    row.scale = row_scale[r];
    row.error = row_error[r] + left;
    for (int order = 0; order < orders_; ++order) {
      row.mode[order].resize(modes);
      for (int m = 0; m < modes; ++m) row.mode[order][m] = means[m](r, order);
    }
  }
  return left <= kQuadratureShare * tolerance_ * row_scale.minCoeff();
}

}  // namespace lamella
