#include "compare/fit/bounded_least_squares.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <stdexcept>

namespace lamella {
namespace {

// Central differences, one-sided by as much as a bound cuts off.
bool differentiate(const UnitProblem& problem, const double* x, double* jacobian) {
  const auto n = static_cast<std::size_t>(problem.parameters);
  const auto rows = static_cast<std::size_t>(problem.residuals);
  std::vector<double> at(x, x + n), above(rows), below(rows);
  for (std::size_t k = 0; k < n; ++k) {
    const double high = std::min(1.0, x[k] + problem.step),
                 low = std::max(0.0, x[k] - problem.step);
    at[k] = high;
    if (!problem.evaluate(at, above)) return false;
    at[k] = low;
    if (!problem.evaluate(at, below)) return false;
    at[k] = x[k];
    for (std::size_t row = 0; row < rows; ++row)
      jacobian[row * n + k] = (above[row] - below[row]) / (high - low);
  }
  return true;
}

class UnitCost : public ceres::CostFunction {
 public:
  explicit UnitCost(const UnitProblem& problem) : problem_(problem) {
    set_num_residuals(problem.residuals);
    mutable_parameter_block_sizes()->push_back(problem.parameters);
  }
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override {
    const auto n = static_cast<std::size_t>(problem_.parameters);
    const auto rows = static_cast<std::size_t>(problem_.residuals);
    if (!problem_.evaluate({x[0], n}, {residuals, rows})) return false;
    return !jacobians || !jacobians[0] || differentiate(problem_, x[0], jacobians[0]);
  }

 private:
  const UnitProblem& problem_;
};

class StopBetweenSteps : public ceres::IterationCallback {
 public:
  explicit StopBetweenSteps(const std::function<bool()>& stop) : stop_(stop) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*step*/) override {
    return stop_() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const std::function<bool()>& stop_;
};

}  // namespace

UnitMinimum minimum_from(const UnitProblem& problem, std::vector<double> start,
                         const UnitEffort& effort) {
  UnitMinimum end;
  const auto rows = static_cast<std::size_t>(problem.residuals);
  end.residuals.resize(rows);
  end.x = std::move(start);
  if (!problem.evaluate(end.x, end.residuals))
    throw std::domain_error("the parameters to begin with give no values");
  if (problem.parameters > 0) {
    ceres::Problem ceres_problem;
    ceres_problem.AddResidualBlock(new UnitCost(problem), nullptr, end.x.data());
    for (int k = 0; k < problem.parameters; ++k) {
      ceres_problem.SetParameterLowerBound(end.x.data(), k, 0);
      ceres_problem.SetParameterUpperBound(end.x.data(), k, 1);
    }
    ceres::Solver::Options options;
    options.max_num_iterations = effort.iterations;
    options.function_tolerance = effort.tolerance;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = 1e-9;
    options.linear_solver_type = ceres::DENSE_QR;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    StopBetweenSteps between(effort.stop);
    if (effort.stop) {
      options.callbacks.push_back(&between);
      options.update_state_every_iteration = true;
    }
    ceres::Solver::Summary summary;
    ceres::Solve(options, &ceres_problem, &summary);
    end.iterations = static_cast<int>(summary.iterations.size());
    for (double& x : end.x) x = std::clamp(x, 0.0, 1.0);
  }
  end.jacobian.resize(rows * static_cast<std::size_t>(problem.parameters));
  if (!problem.evaluate(end.x, end.residuals) ||
      !differentiate(problem, end.x.data(), end.jacobian.data()))
    throw std::domain_error("the parameters found give no values");
  for (const double r : end.residuals) end.cost += r * r / 2;
  return end;
}

}  // namespace lamella
