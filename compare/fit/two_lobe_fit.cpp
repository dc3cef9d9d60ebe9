#include "compare/fit/two_lobe_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "compare/fit/bounded_least_squares.h"
#include "compare/fit/nonnegative_least_squares.h"
#include "phase/stack/single_scattering.h"

namespace lamella {
namespace {

constexpr double kLargestFactor = 1e3;
// Narrower flakes than this are narrower than a cell.
constexpr double kLeastRoughness = 0.02, kMostRoughness = 0.999, kLargestG = 0.98;
// Lobes of rougher flakes are wider than a part of a cell.
constexpr double kNarrowRoughness = 0.2;
// A layer's lobe sends out at most ten times the light that meets its flakes. On cells that its
// peak leaves dark nothing else holds it: it would fit their noise with any weight.
constexpr double kBrightest = 10;
constexpr int kIterations = 40;
constexpr double kTolerance = 1e-6;

// Layers with factors of their own, or the last of them with all that share its factors.
struct Group {
  int first = 0, end = 0;
  bool flakes = false;     // one layer of flakes, whose f0 is free
  bool particles = false;  // roughness is g
  double own = 0;          // roughness or g; 0: not free
  bool deep = false;       // whether the depth is free
  [[nodiscard]] int columns() const { return flakes ? 2 : 1; }
};

std::vector<Group> groups_of(const Stack& stack) {
  const int layers = static_cast<int>(stack.layers.size());
  std::vector<Group> groups;
  for (int k = 0; k < std::min(layers, kSpongecakeLayers); ++k) {
    Group g{.first = k, .end = k + 1 < kSpongecakeLayers ? k + 1 : layers};
    const Layer& layer = stack.layers[k];
    g.particles = std::holds_alternative<HenyeyGreenstein>(layer.medium);
    g.flakes = !g.particles && g.end == k + 1;
    const char* key = g.particles ? "g" : "roughness";
    bool alike = layer.parameters.has(key);
    for (int j = g.first; j < g.end; ++j) {
      const Layer& other = stack.layers[j];
      alike = alike && other.medium_name == layer.medium_name && other.parameters.has(key) &&
              other.parameters.number(key) == layer.parameters.number(key);
      g.deep = g.deep || (std::isfinite(other.depth()) && other.depth() > 0);
    }
    if (alike) g.own = layer.parameters.number(key);
    groups.push_back(g);
  }
  return groups;
}

// A number of the search, scaled to [0, 1].
struct Scale {
  double from, to;
  bool logarithmic;
  [[nodiscard]] double value(double x) const {
    return logarithmic ? from * std::pow(to / from, x) : from + x * (to - from);
  }
  [[nodiscard]] double place(double v) const {
    const double x =
        logarithmic ? std::log(v / from) / std::log(to / from) : (v - from) / (to - from);
    return std::clamp(x, 0.0, 1.0);
  }
};

class Search {
 public:
  Search(const Stack& stack, const std::vector<LobeCell>& cells, int channels)
      : stack_(stack), cells_(cells), channels_(channels), groups_(groups_of(stack)) {
    for (const Group& g : groups_) {
      columns_ += g.columns();
      if (g.own != 0)
        scales_.push_back(g.particles ? Scale{-kLargestG, kLargestG, false}
                                      : Scale{kLeastRoughness, kMostRoughness, true});
      if (g.deep) scales_.push_back({1 / kLargestFactor, kLargestFactor, true});
    }
    has_unit_columns_ = std::all_of(groups_.begin(), groups_.end(), [&](const Group& g) {
      const Layer& layer = stack.layers[g.first];
      const auto is_positive = [](Rgb x) { return x.r > 0 && x.g > 0 && x.b > 0; };
      return g.flakes && is_positive(layer.albedo) && is_positive(layer.f0);
    });
    is_grey_ = std::all_of(stack.layers.begin(), stack.layers.end(),
                           [](const Layer& l) { return l.albedo.is_grey() && l.f0.is_grey(); });
    if (stack.is_open_below()) constants_ = 2;
    columns_ += constants_;
    for (const LobeCell& cell : cells)
      for (int c = 0; c < channels; ++c) square_ += cell.truth[c] * cell.truth[c];
    if (!(square_ > 0)) throw std::invalid_argument("the stack has no multiple scattering to fit");
  }

  [[nodiscard]] TwoLobeFit find(const StopFlag* stop) const {
    TwoLobeFit fit;
    double least = std::numeric_limits<double>::infinity();
    std::vector<double> best;
    const UnitProblem problem{
        .parameters = static_cast<int>(scales_.size()),
        .residuals = static_cast<int>(cells_.size()) * channels_,
        .evaluate = [this](std::span<const double> x, std::span<double> residuals) {
          return residuals_at(x, residuals);
        }};
    std::vector<double> residuals(problem.residuals);
    for (const bool rough : {false, true}) {
      if (is_set(stop) && !best.empty()) break;
      std::vector<double> x = start(rough);
      double cost = 0;
      if (x.empty()) {
        (void)residuals_at(x, residuals);
        for (const double r : residuals) cost += 0.5 * r * r;
      } else {
        UnitMinimum found =
            minimum_from(problem, x, {kIterations, kTolerance, [stop] { return is_set(stop); }});
        fit.iterations += found.iterations;
        cost = found.cost;
        x = std::move(found.x);
      }
      if (cost >= least) continue;
      least = cost;
      best = std::move(x);
    }
    fit.lobes = lobes_at(best);
    fit.relative_rmse = std::sqrt(2 * least);
    return fit;
  }

 private:
  [[nodiscard]] std::vector<double> start(bool rough) const {
    std::vector<double> x;
    for (const Group& g : groups_) {
      if (g.own != 0) {
        const double at = g.particles ? (rough ? 0.3 : 0.9) * g.own
                          : rough     ? 0.9
                                      : std::min(1.3 * g.own, 0.95);
        x.push_back(scales_[x.size()].place(at));
      }
      if (g.deep) x.push_back(0.5);
    }
    return x;
  }

  [[nodiscard]] std::vector<SpongecakeFactors> shape_at(std::span<const double> x) const {
    std::vector<SpongecakeFactors> factors(groups_.size());
    std::size_t at = 0;
    for (std::size_t k = 0; k < groups_.size(); ++k) {
      if (groups_[k].own != 0) {
        factors[k].roughness = scales_[at].value(x[at]) / groups_[k].own;
        ++at;
      }
      if (groups_[k].deep) {
        factors[k].depth = scales_[at].value(x[at]);
        ++at;
      }
    }
    return factors;
  }

  // [cell][column], of channel c.
  void fill_columns(const Stack& second, int c, std::vector<double>& columns) const {
    std::vector<LayerSingle> layers(second.layers.size());
    columns.assign(cells_.size() * columns_, 0);
    for (std::size_t n = 0; n < cells_.size(); ++n) {
      double* row = &columns[n * columns_];
      const double weight = 1.0 / static_cast<double>(cells_[n].wo.size());
      for (const Direction wo : cells_[n].wo) {
        single_scattering_by_layer(second, cells_[n].wi, wo, layers);
        int at = 0;
        for (const Group& g : groups_) {
          for (int k = g.first; k < g.end; ++k) {
            const Layer& own = stack_.layers[k];
            const double f0 = own.f0[c], a = weight * (has_unit_columns_ ? 1 : own.albedo[c]);
            if (!g.flakes) {
              row[at] += a * (f0 * layers[k].full + (1 - f0) * layers[k].edge);
            } else {
              if (f0 > 0) row[at] += a * layers[k].full;
              row[at + 1] += a * layers[k].edge;
            }
          }
          at += g.columns();
        }
      }
      row[columns_ - constants_ + (cells_[n].reflected ? 0 : 1)] = 1 / kPi;
    }
  }

  // The largest coefficient of every column, of channel c: of optical depth tau a layer's single
  // scattering has at most the share min(1, tau) of the light along the normal. Where light comes
  // from above alone, what passes the layers above, in and out, is left of it.
  [[nodiscard]] std::vector<double> largest(const Stack& second, int c) const {
    std::vector<double> most;
    double above = 0;
    for (const Group& g : groups_) {
      double bound = std::numeric_limits<double>::infinity();
      for (int k = g.first; k < g.end; ++k) {
        const double albedo = has_unit_columns_ ? 1 : stack_.layers[k].albedo[c];
        const double light = std::min(1.0, second.layers[k].depth()) * std::exp(-2 * above);
        bound = std::min(bound, kBrightest / (albedo * light));
        if (!stack_.is_open_below()) above += second.layers[k].depth();
      }
      most.insert(most.end(), g.columns(), bound);
    }
    most.resize(columns_, std::numeric_limits<double>::infinity());
    return most;
  }

  // The columns' coefficients of every channel; what they leave over, if asked for.
  std::vector<std::vector<double>> coefficients(const std::vector<SpongecakeFactors>& factors,
                                                std::span<double> residuals) const {
    const Stack second = spongecake_second_stack(stack_, factors);
    std::vector<std::vector<double>> found;
    std::vector<double> columns;
    const double scale = 1 / std::sqrt(square_);
    for (int c = 0; c < channels_; ++c) {
      if (c == 0 || !(has_unit_columns_ || is_grey_)) fill_columns(second, c, columns);
      NormalEquations equations(columns_);
      for (std::size_t n = 0; n < cells_.size(); ++n)
        equations.add({&columns[n * columns_], static_cast<std::size_t>(columns_)},
                      cells_[n].truth[c]);
      found.push_back(bounded_solution(std::move(equations), largest(second, c)));
      for (std::size_t n = 0; n < cells_.size() && !residuals.empty(); ++n) {
        double f = 0;
        for (int k = 0; k < columns_; ++k) f += columns[n * columns_ + k] * found.back()[k];
        residuals[n * channels_ + c] = scale * (f - cells_[n].truth[c]);
      }
    }
    return found;
  }

  bool residuals_at(std::span<const double> x, std::span<double> residuals) const {
    (void)coefficients(shape_at(x), residuals);
    return std::all_of(residuals.begin(), residuals.end(),
                       [](double r) { return std::isfinite(r); });
  }

  [[nodiscard]] SpongecakeLobes lobes_at(std::span<const double> x) const {
    SpongecakeLobes lobes{.factors = shape_at(x), .reflect = {}, .transmit = {}};
    const std::vector<std::vector<double>> found = coefficients(lobes.factors, {});
    for (int c = 0; c < 3; ++c) {
      const std::vector<double>& at = found[channels_ == 3 ? c : 0];
      int column = 0;
      for (std::size_t k = 0; k < groups_.size(); ++k) {
        const double full = at[column];
        double sum = full;
        if (groups_[k].flakes) {
          const double f0 = stack_.layers[groups_[k].first].f0[c];
          sum += at[column + 1];
          if (f0 > 0 && sum > 0) lobes.factors[k].f0[c] = full / sum / f0;
        }
        if (has_unit_columns_) sum /= stack_.layers[groups_[k].first].albedo[c];
        lobes.factors[k].albedo[c] = sum;
        column += groups_[k].columns();
      }
      lobes.reflect[c] = at[column];
      if (constants_ == 2) lobes.transmit[c] = at[column + 1];
    }
    return lobes;
  }

  const Stack& stack_;
  const std::vector<LobeCell>& cells_;
  int channels_;
  std::vector<Group> groups_;
  std::vector<Scale> scales_;
  // Columns of albedo 1, which are those of all channels: flakes alone, none of them black.
  bool has_unit_columns_ = false;
  bool is_grey_ = false;
  int columns_ = 0, constants_ = 1;
  double square_ = 0;
};

}  // namespace

std::vector<Direction> cell_nodes(Direction wi, int row, int column, int mu_cells, int phi_cells,
                                  bool up, int parts) {
  const double node[2] = {0.5 - std::sqrt(3.0) / 6, 0.5 + std::sqrt(3.0) / 6};
  const int count = 2 * parts;
  const auto at = [&](int n) { return (n / 2 + node[n % 2]) / parts; };
  std::vector<Direction> nodes;
  for (int n = 0; n < count * count; ++n) {
    const double mu2 = 1 - (row + at(n / count)) / mu_cells;
    const double phi = 2 * kPi * (column + at(n % count)) / phi_cells;
    nodes.push_back(direction_from_mu_phi((up ? 1 : -1) * std::sqrt(mu2), azimuth(wi) + phi));
  }
  return nodes;
}

int cell_parts(const Stack& stack) {
  return std::any_of(stack.layers.begin(), stack.layers.end(),
                     [](const Layer& layer) {
                       return !std::holds_alternative<HenyeyGreenstein>(layer.medium) &&
                              layer.parameters.has("roughness") &&
                              layer.parameters.number("roughness") < kNarrowRoughness;
                     })
             ? 2
             : 1;
}

Rgb value_of(const Stack& second, const SpongecakeLobes& lobes, const LobeCell& cell) {
  Rgb sum;
  for (const Direction wo : cell.wo) sum += single_scattering(second, cell.wi, wo).layers;
  return 1.0 / static_cast<double>(cell.wo.size()) * sum +
         1 / kPi * (cell.reflected ? lobes.reflect : lobes.transmit);
}

TwoLobeFit fit_two_lobes(const Stack& stack, const std::vector<LobeCell>& cells, int channels,
                         const StopFlag* stop) {
  return Search(stack, cells, channels).find(stop);
}

}  // namespace lamella
