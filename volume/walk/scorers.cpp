#include "volume/walk/scorers.h"

namespace lamella {

int CellTargets::find(Direction wo) const {
  if (wo.z < 0 && !both_sides) return -1;
  double phi = std::atan2(wo.y, wo.x) - incident_azimuth;
  phi -= 2 * kPi * std::floor(phi / (2 * kPi));
  return grid.cell(wo.z * wo.z, phi) + (wo.z < 0 ? grid.cells() : 0);
}

CellDirections::CellDirections(const CellTargets& targets)
    : targets_(targets),
      column_cos_(targets.grid.columns()),
      column_sin_(targets.grid.columns()) {}

void CellDirections::redraw(std::uint64_t seed, std::uint64_t index, std::vector<double>& x,
                            std::vector<double>& y, std::vector<double>& z,
                            std::vector<double>& inverse_mu) {
  // Each cell still sees all of itself over the walks, at the price of two numbers.
  RandomStream stream(seed, index, StreamPurpose::targets);
  const double u_mu = stream.uniform(), u_phi = stream.uniform();
  const CellGrid& grid = targets_.grid;
  const int columns = grid.columns(), cells = grid.cells(), count = targets_.count();
  for (int column = 0; column < columns; ++column) {
    const double phi = targets_.incident_azimuth + 2 * kPi * (column + u_phi) / grid.phi_cells;
    column_cos_[column] = std::cos(phi);
    column_sin_[column] = std::sin(phi);
  }
  for (int row = 0; row < grid.rows(); ++row) {
    const double mu2 = (grid.mu_cells - row - u_mu) / grid.mu_cells;
    const double mu = std::sqrt(mu2), s = std::sqrt(1 - mu2);
    for (int column = 0; column < columns; ++column)
      for (int j = row * columns + column; j < count; j += cells) {
        x[j] = s * column_cos_[column];
        y[j] = s * column_sin_[column];
        z[j] = j < cells ? mu : -mu;
        inverse_mu[j] = 1 / mu;
      }
  }
}

void TargetDirections::resize(int count, std::size_t layers) {
  for (auto* v : {&x, &y, &z, &inverse_mu}) v->resize(count);
  rate.assign(layers, std::vector<double>(count));
  beyond.assign(layers, std::vector<double>(count));
}

void TargetDirections::trace(const WalkStack& stack, int row_length) {
  const std::size_t n = stack.layers.size();
  for (std::size_t k = 0; k < n; ++k) {
    const Medium& medium = *stack.layers[k].medium;
    for (int j = 0; j < count(); ++j)
      rate[k][j] = j % row_length == 0 ? sigma(medium, {-x[j], -y[j], -z[j]}) * inverse_mu[j]
                                       : rate[k][j - 1];
  }
  for (int j = 0; j < count(); ++j) {
    double tau = 0;
    for (std::size_t step = 0; step < n; ++step) {
      const std::size_t k = j < up ? step : n - 1 - step;
      beyond[k][j] = tau;
      if (rate[k][j] > 0) tau += stack.layers[k].depth * rate[k][j];
    }
  }
}

template <int C>
NextEventScorer<C>::NextEventScorer(const CellTargets& cells, const WalkStack& stack,
                                    BatchTally& tally)
    : cells_(&cells), stack_(stack), tally_(tally) {
  directions_.resize(cells.count(), stack.layers.size());
  directions_.up = cells.grid.cells();
  cell_directions_.emplace(cells);
  symmetric_ = cells.grid.folded;
  if (!stack.layers.empty()) last_depth_ = stack.layers.back().depth;
}

template <int C>
NextEventScorer<C>::NextEventScorer(const std::vector<Direction>& points, const WalkStack& stack,
                                    BatchTally& tally)
    : stack_(stack), tally_(tally) {
  directions_.resize(static_cast<int>(points.size()), stack.layers.size());
  if (!stack.layers.empty()) last_depth_ = stack.layers.back().depth;
  for (std::size_t j = 0; j < points.size(); ++j) {
    directions_.x[j] = points[j].x;
    directions_.y[j] = points[j].y;
    directions_.z[j] = points[j].z;
    directions_.inverse_mu[j] = 1 / std::abs(points[j].z);
    directions_.up += points[j].z > 0;
  }
  directions_.trace(stack, 1);
}

template <int C>
void NextEventScorer<C>::begin_walk(std::uint64_t seed, std::uint64_t index) {
  if (!cells_) return;
  cell_directions_->redraw(seed, index, directions_.x, directions_.y, directions_.z,
                           directions_.inverse_mu);
  directions_.trace(stack_, symmetric_ ? cells_->grid.columns() : 1);
}

template class NextEventScorer<1>;
template class NextEventScorer<3>;

}  // namespace lamella
