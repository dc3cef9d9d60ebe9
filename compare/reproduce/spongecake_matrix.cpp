#include "compare/reproduce/spongecake_matrix.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "phase/math/luminance.h"

namespace lamella {

MultipleLobes matrix_truth(const Stack& stack, std::uint64_t walks, std::uint64_t seed,
                           const StopFlag* stop) {
  const std::vector<MatrixDirection> directions = matrix_directions(kMatrixGrid);
  std::vector<MultipleLobes> rows(directions.size());
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t k) {
    rows[k] = multiple_lobes(stack, {direction_from_mu_phi(directions[k].mu, directions[k].phi)},
                             kMatrixGrid, walks, seed + (k << 8), stop);
  });
  MultipleLobes all{
      .grid = kMatrixGrid, .incident = {}, .walks = walks, .value = {}, .variance = {}};
  // Of what is stopped, rows may be missing.
  if (is_set(stop)) return all;
  for (const MultipleLobes& row : rows) {
    all.incident.push_back(row.incident.front());
    all.value.insert(all.value.end(), row.value.begin(), row.value.end());
    all.variance.insert(all.variance.end(), row.variance.begin(), row.variance.end());
  }
  return all;
}

MultipleLobes thinned(const MultipleLobes& matrix, std::size_t step) {
  MultipleLobes some{
      .grid = matrix.grid, .incident = {}, .walks = matrix.walks, .value = {}, .variance = {}};
  const std::size_t numbers = 3 * matrix.cells_per_direction();
  for (std::size_t k = 0; k < matrix.incident.size(); k += step) {
    some.incident.push_back(matrix.incident[k]);
    const auto from = static_cast<std::ptrdiff_t>(k * numbers);
    const auto to = static_cast<std::ptrdiff_t>((k + 1) * numbers);
    some.value.insert(some.value.end(), matrix.value.begin() + from, matrix.value.begin() + to);
    some.variance.insert(some.variance.end(), matrix.variance.begin() + from,
                         matrix.variance.begin() + to);
  }
  return some;
}

std::vector<double> luminances(const std::vector<Rgb>& values, const std::vector<Rgb>& more) {
  std::vector<double> out;
  for (std::size_t k = 0; k < values.size(); ++k)
    out.push_back(luminance(more.empty() ? values[k] : values[k] + more[k]));
  return out;
}

std::vector<double> minus(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out;
  for (std::size_t k = 0; k < a.size(); ++k) out.push_back(a[k] - b[k]);
  return out;
}

LobeMatrix spongecake_matrix(const SpongecakeTrial& trial, const SpongecakeLobes& network,
                             const std::optional<SpongecakeLobes>& fit, bool all_orders,
                             const std::string& title) {
  const std::vector<Rgb> more = all_orders ? trial.single() : std::vector<Rgb>();
  const std::vector<double> truth = luminances(trial.truth(), more);
  const std::vector<double> model = luminances(trial.values(network), more);
  LobeMatrix matrix{.grid = kMatrixGrid, .panels = {}, .title = title, .subtitle = {}};
  matrix.subtitle =
      fmt::format("{}: rows are incident directions, columns outgoing cells; f [1/sr], luminance",
                  all_orders ? "all orders" : "orders 2 and up");
  matrix.panels.push_back({"truth", truth, false});
  matrix.panels.push_back({"network", model, false});
  if (fit) matrix.panels.push_back({"best fit", luminances(trial.values(*fit), more), false});
  matrix.panels.push_back({"network - truth", minus(model, truth), true});
  return matrix;
}

}  // namespace lamella
