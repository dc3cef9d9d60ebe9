#include "compare/nearest/model_fit.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "analytic/coated/coat.h"
#include "compare/fit/bounded_least_squares.h"
#include "compare/judge/projection.h"
#include "compare/request/errors.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

constexpr double kAgreement = 1e-3;    // relative difference of misfits that count as the same
constexpr double kAtEnd = 1e-7;        // of the range
constexpr double kNoEffect = 1e-9;     // of the largest column of the Jacobian
constexpr double kSingular = 1e-5;     // of the largest singular value of scaled columns
constexpr int kCoarse = 2, kFine = 4;  // points of a cell along each dimension
constexpr double kCoatStep = 2e-3;     // of derivatives beside tables that are quick
constexpr int kCorrections = 2;        // of these rules by the exact projection

// A model's residuals in a norm, and what the truth's errors are in their unit.
class Residuals {
 public:
  Residuals(const FitTarget& target, FitNorm norm) : target_(target), norm_(norm) {
    const std::size_t block = target.block(), lobes = target.lobes.size();
    std::size_t runs = 0;
    for (const TargetLobe& lobe : target.lobes) runs = std::max(runs, lobe.run + 1);
    std::vector<double> squares(runs), counts(runs);
    for (std::size_t l = 0; l < lobes; ++l)
      for (std::size_t k = l * block; k < (l + 1) * block; ++k) {
        squares[target.lobes[l].run] += target.value[k] * target.value[k];
        ++counts[target.lobes[l].run];
      }
    double all = 0;
    for (const double s : squares) all += s / static_cast<double>(runs);
    for (std::size_t r = 0; r < runs; ++r) {
      // A direction without light counts by the light of the others.
      const double square = squares[r] > 0 ? squares[r] : all;
      scale_.push_back(std::sqrt(square * static_cast<double>(runs)));
      floor_.push_back(kLogFloor * std::sqrt(square / counts[r]));
    }
  }

  [[nodiscard]] std::size_t size() const { return target_.value.size(); }

  void of(std::span<const double> means, std::span<double> residuals) const {
    for (std::size_t k = 0; k < size(); ++k) {
      const std::size_t run = target_.lobes[k / target_.block()].run;
      const double truth = target_.value[k];
      residuals[k] = norm_ == FitNorm::relative ? (means[k] - truth) / scale_[run]
                                                : std::log((std::max(means[k], 0.0) + floor_[run]) /
                                                           (std::max(truth, 0.0) + floor_[run])) /
                                                      std::sqrt(static_cast<double>(size()));
    }
  }

  // The truth's errors as errors of the residuals.
  [[nodiscard]] std::vector<double> errors() const {
    std::vector<double> out(size());
    for (std::size_t k = 0; k < size(); ++k) {
      const std::size_t run = target_.lobes[k / target_.block()].run;
      out[k] = norm_ == FitNorm::relative
                   ? target_.error[k] / scale_[run]
                   : target_.error[k] / (std::max(target_.value[k], 0.0) + floor_[run]) /
                         std::sqrt(static_cast<double>(size()));
    }
    return out;
  }

 private:
  const FitTarget& target_;
  FitNorm norm_;
  std::vector<double> scale_, floor_;  // per run
};

// The k-th point of a Kronecker sequence in n dimensions (Roberts 2018: powers of the root of
// x^(n + 1) = x + 1).
std::vector<double> spread_point(int k, std::size_t n) {
  double root = 1.5;
  for (int i = 0; i < 64; ++i) root = std::pow(1 + root, 1 / (static_cast<double>(n) + 1));
  std::vector<double> point(n);
  double step = 1;
  for (double& x : point) {
    step /= root;
    x = 0.5 + (k + 1) * step;
    x -= std::floor(x);
  }
  return point;
}

// `correction`: what is added to the means, or empty.
UnitProblem problem_of(const FitSubject& subject, FitPass pass, const FitTarget& target,
                       const Residuals& residuals, const std::vector<double>& correction) {
  UnitProblem problem;
  problem.parameters = static_cast<int>(subject.free.size());
  problem.residuals = static_cast<int>(target.value.size());
  problem.step = subject.step;
  problem.evaluate = [&, pass](std::span<const double> x, std::span<double> out) {
    std::optional<std::vector<double>> means = subject.means(x, pass);
    if (!means) return false;
    for (std::size_t k = 0; k < correction.size(); ++k) (*means)[k] += correction[k];
    residuals.of(*means, out);
    return std::all_of(out.begin(), out.end(), [](double r) { return std::isfinite(r); });
  };
  return problem;
}

// The model's means over cells as a comparison has them: by a projection that refines cells.
std::vector<double> projected_means(const Model& model, const ModelInfo& info,
                                    const FitTarget& target) {
  std::vector<double> means;
  for (const TargetLobe& lobe : target.lobes) {
    const bool up = (lobe.wi.z > 0) == lobe.reflected;
    const ProjectedLobes found = project(model, info, lobe.wi, target.grid, up, target.channels);
    means.insert(means.end(), found.lobes[Order::all].begin(), found.lobes[Order::all].end());
  }
  return means;
}

double cost_of(const UnitProblem& problem, const std::vector<double>& x,
               std::vector<double>& scratch) {
  if (!problem.evaluate(x, scratch)) return std::numeric_limits<double>::infinity();
  double cost = 0;
  for (const double r : scratch) cost += r * r / 2;
  return cost;
}

// States, deviations and covariance of the numbers.
void add_uncertainty(ModelFit& fit, const UnitMinimum& at, const Residuals& residuals,
                     bool is_bounded) {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto n = static_cast<Eigen::Index>(fit.numbers.size());
  const auto rows = static_cast<Eigen::Index>(at.residuals.size());
  fit.covariance.assign(fit.numbers.size() * fit.numbers.size(), 0.0);
  if (n == 0) return;
  const Eigen::Map<const Matrix> jacobian(at.jacobian.data(), rows, n);
  const double largest = jacobian.colwise().norm().maxCoeff();
  std::vector<Eigen::Index> open;
  for (Eigen::Index k = 0; k < n; ++k) {
    FittedNumber& number = fit.numbers[static_cast<std::size_t>(k)];
    const double x = at.x[static_cast<std::size_t>(k)];
    if (!(jacobian.col(k).norm() > kNoEffect * largest)) {
      number.state = FreeState::without_effect;
      number.deviation = number.of_truth = std::numeric_limits<double>::infinity();
    } else if (x < kAtEnd) {
      number.state = FreeState::at_low;
    } else if (x > 1 - kAtEnd) {
      number.state = FreeState::at_high;
    } else {
      open.push_back(k);
    }
  }
  if (open.empty()) return;
  const auto m = static_cast<Eigen::Index>(open.size());
  // Columns of unit length, in the parameters' own units.
  Eigen::MatrixXd scaled(rows, m);
  Eigen::VectorXd unit(m);
  for (Eigen::Index j = 0; j < m; ++j) {
    const auto k = static_cast<std::size_t>(open[static_cast<std::size_t>(j)]);
    const double length = jacobian.col(static_cast<Eigen::Index>(k)).norm();
    scaled.col(j) = jacobian.col(static_cast<Eigen::Index>(k)) / length;
    unit(j) = fit.numbers[k].number.slope(at.x[k]) / length;
  }
  // The eigenvectors of J^T J are J's right singular vectors.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled.transpose() * scaled);
  const Eigen::VectorXd& squares = eigen.eigenvalues();
  const Eigen::MatrixXd& vectors = eigen.eigenvectors();
  std::vector<bool> lost(static_cast<std::size_t>(m));
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(m);
  for (Eigen::Index s = 0; s < m; ++s) {
    if (squares(s) > kSingular * kSingular * squares(m - 1)) {
      inverse(s) = 1 / squares(s);
      continue;
    }
    for (Eigen::Index j = 0; j < m; ++j)
      if (std::abs(vectors(j, s)) > 1e-2) lost[static_cast<std::size_t>(j)] = true;
  }
  // x = unit * gain * residuals, to first order.
  const Eigen::MatrixXd inner = vectors * inverse.asDiagonal() * vectors.transpose();
  const Eigen::MatrixXd gain = inner * scaled.transpose();
  const double freedom = std::max<double>(static_cast<double>(rows - m), 1);
  const double square = 2 * at.cost / freedom;
  const std::vector<double> errors = residuals.errors();
  for (Eigen::Index j = 0; j < m; ++j) {
    const auto k = static_cast<std::size_t>(open[static_cast<std::size_t>(j)]);
    FittedNumber& number = fit.numbers[k];
    if (lost[static_cast<std::size_t>(j)]) {
      number.state = FreeState::undetermined;
      number.deviation = number.of_truth = std::numeric_limits<double>::infinity();
      continue;
    }
    double sum = 0;
    for (Eigen::Index row = 0; row < rows; ++row) {
      const double part = std::abs(gain(j, row)) * errors[static_cast<std::size_t>(row)];
      sum += is_bounded ? part : part * part;
    }
    number.of_truth = std::abs(unit(j)) * (is_bounded ? sum : std::sqrt(sum));
    number.deviation = std::abs(unit(j)) * std::sqrt(square * inner(j, j));
    for (Eigen::Index i = 0; i < m; ++i) {
      if (lost[static_cast<std::size_t>(i)]) continue;
      const auto other = static_cast<std::size_t>(open[static_cast<std::size_t>(i)]);
      fit.covariance[k * fit.numbers.size() + other] = square * unit(j) * unit(i) * inner(j, i);
    }
  }
}

// What is left over per lobe and in all.
void add_lobes(ModelFit& fit, const FitTarget& target, const std::vector<double>& means) {
  const auto cells = static_cast<std::size_t>(target.grid.cells());
  const auto channels = static_cast<std::size_t>(target.channels);
  std::size_t runs = 0;
  for (const TargetLobe& lobe : target.lobes) runs = std::max(runs, lobe.run + 1);
  std::vector<double> all_error(runs), all_noise(runs), all_truth(runs);
  for (std::size_t l = 0; l < target.lobes.size(); ++l) {
    const TargetLobe& lobe = target.lobes[l];
    FittedLobe left{
        .wi = lobe.wi, .reflected = lobe.reflected, .energy_missing = lobe.energy_missing};
    double error = 0, noise = 0, truth = 0;
    for (std::size_t c = 0; c < channels; ++c)
      for (std::size_t cell = 0; cell < cells; ++cell) {
        const std::size_t k = (l * channels + c) * cells + cell;
        const double weight =
            (channels == 1 ? 1 : kLuminanceWeights[c]) * target.grid.projected_solid_angle();
        left.energy_truth += weight * target.value[k];
        left.energy_model += weight * means[k];
        error += (means[k] - target.value[k]) * (means[k] - target.value[k]);
        truth += target.value[k] * target.value[k];
        if (!target.is_bounded) noise += target.error[k] * target.error[k];
      }
    const auto share = [&](double x) {
      return truth > 0 ? std::sqrt(x / truth)
                       : (x > 0 ? std::numeric_limits<double>::infinity() : 0.0);
    };
    left.relative_rmse = share(error);
    left.noise = share(noise);
    all_error[lobe.run] += error;
    all_noise[lobe.run] += noise;
    all_truth[lobe.run] += truth;
    fit.lobes.push_back(left);
  }
  double light = 0, error = 0, noise = 0;
  for (const double t : all_truth) light += t / static_cast<double>(runs);
  for (std::size_t r = 0; r < runs; ++r) {
    const double truth = (all_truth[r] > 0 ? all_truth[r] : light) * static_cast<double>(runs);
    error += all_error[r] / truth;
    noise += all_noise[r] / truth;
  }
  fit.relative_rmse = std::sqrt(error);
  fit.noise = std::sqrt(noise);
  fit.relative_rmse_without_noise = std::sqrt(std::max(error - noise, 0.0));
}

// The request with the numbers found, six digits each.
ModelRequest request_of(const ParametricModel& model, const Parameters& found) {
  ModelRequest request = model.request;
  std::vector<std::string> done;
  for (const FreeNumber& free : model.free) {
    if (std::find(done.begin(), done.end(), free.key) != done.end()) continue;
    done.push_back(free.key);
    const ParameterValue& value = found.at(free.key);
    std::string text;
    if (const Rgb* c = std::get_if<Rgb>(&value))
      text = c->is_grey() ? fmt::format("{:.6g}", c->r)
                          : fmt::format("{:.6g},{:.6g},{:.6g}", c->r, c->g, c->b);
    else
      text = fmt::format("{:.6g}", std::get<double>(value));
    request.values.emplace_back(free.key, text);
    request.sources[free.key] = "fitted";
  }
  return request;
}

}  // namespace

std::string to_text(FitNorm norm) { return norm == FitNorm::relative ? "relative" : "log"; }

std::string to_text(FreeState state) {
  switch (state) {
    case FreeState::found:
      return "found";
    case FreeState::at_low:
      return "at its lowest";
    case FreeState::at_high:
      return "at its highest";
    case FreeState::without_effect:
      return "no effect";
    case FreeState::undetermined:
      break;
  }
  return "undetermined";
}

ModelFit fit_subject(const FitSubject& subject, const FitTarget& given, FitNorm norm,
                     const StopFlag* stop) {
  FitTarget target = given;
  if (!subject.own_error.empty()) {
    // Errors of both: bounds are small beside the noise of walks, and count as a part of it.
    target.is_bounded = false;
    for (std::size_t k = 0; k < target.error.size(); ++k)
      target.error[k] = std::hypot(target.error[k], subject.own_error[k]);
  }
  const Residuals residuals(target, norm);
  const std::size_t n = subject.free.size();
  std::vector<double> nothing, correction;
  const UnitProblem first = problem_of(subject, FitPass::coarse, target, residuals, nothing);
  const UnitProblem last = problem_of(subject, FitPass::fine, target, residuals, correction);
  std::vector<double> scratch(residuals.size());

  // Where to begin: the defaults, then the best of the points tried.
  std::vector<std::pair<double, std::vector<double>>> tried;
  std::vector<double> standard;
  for (const FreeNumber& free : subject.free) standard.push_back(free.standard);
  const double of_standard = cost_of(first, standard, scratch);
  for (int k = 0; n > 0 && k < subject.tried && !is_set(stop); ++k) {
    std::vector<double> x = spread_point(k, n);
    const double cost = cost_of(first, x, scratch);
    if (std::isfinite(cost)) tried.emplace_back(cost, std::move(x));
  }
  std::stable_sort(tried.begin(), tried.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::vector<double>> starts;
  if (std::isfinite(of_standard)) starts.push_back(standard);
  for (auto& [cost, x] : tried)
    if (starts.size() < static_cast<std::size_t>(subject.starts)) starts.push_back(std::move(x));
  if (starts.empty())
    throw UsageError(
        fmt::format("fit: {}: no values at any of its parameters; allowed: keys that "
                    "the model takes together",
                    subject.name));

  const auto stopped = [stop] { return is_set(stop); };
  ModelFit fit;
  std::vector<double> best;
  std::vector<double> costs;
  for (std::vector<double>& start : starts) {
    if (!best.empty() && is_set(stop)) break;
    if (n == 0) {
      best = start;
      break;
    }
    const UnitMinimum found = minimum_from(first, std::move(start),
                                           {.iterations = 40, .tolerance = 1e-6, .stop = stopped});
    fit.iterations += found.iterations;
    if (best.empty() || found.cost < *std::min_element(costs.begin(), costs.end())) best = found.x;
    costs.push_back(found.cost);
  }
  fit.starts = static_cast<int>(costs.size());
  for (const double cost : costs)
    fit.agreeing +=
        std::sqrt(cost) <=
        (1 + kAgreement) * std::sqrt(*std::min_element(costs.begin(), costs.end())) + 1e-9;
  UnitMinimum end = minimum_from(
      last, best, {.iterations = subject.steps, .tolerance = subject.tolerance, .stop = stopped});
  fit.iterations += end.iterations;
  // What the rule of points misses, at kinks above all, hardly depends on the parameters: found at
  // one place it holds at the next.
  std::vector<double> means;
  const auto means_at = [&](FitPass pass) {
    std::optional<std::vector<double>> found = subject.means(end.x, pass);
    if (!found) throw std::domain_error("the parameters found give no values");
    return *std::move(found);
  };
  for (int pass = 0; pass <= kCorrections; ++pass) {
    means = means_at(subject.has_exact ? FitPass::exact : FitPass::fine);
    if (!subject.has_exact || pass == kCorrections || n == 0 || stopped()) break;
    const std::vector<double> ruled = means_at(FitPass::fine);
    correction.resize(means.size());
    for (std::size_t k = 0; k < means.size(); ++k) correction[k] = means[k] - ruled[k];
    end = minimum_from(
        last, end.x,
        {.iterations = subject.steps / 2, .tolerance = subject.tolerance, .stop = stopped});
    fit.iterations += end.iterations;
  }

  for (std::size_t k = 0; k < n; ++k) {
    FittedNumber number;
    number.number = subject.free[k];
    number.value = subject.free[k].value(end.x[k]);
    fit.numbers.push_back(std::move(number));
  }
  add_uncertainty(fit, end, residuals, target.is_bounded);
  add_lobes(fit, target, means);
  fit.misfit = std::sqrt(2 * end.cost);
  fit.scaled = end.x;
  return fit;
}

ModelFit fit_model(const ParametricModel& model, const FitTarget& target, FitNorm norm, Isa isa,
                   const StopFlag* stop) {
  const CellPoints coarse = cell_points(target, kCoarse), fine = cell_points(target, kFine);
  FitSubject subject{.name = model.info->name,
                     .free = model.free,
                     .means = {},
                     .step = has_coat_tables(model.info->name) ? kCoatStep : kUnitStep,
                     .starts = kStarts,
                     .tried = kTried};
  subject.means = [&](std::span<const double> x,
                      FitPass pass) -> std::optional<std::vector<double>> {
    try {
      // Searches have a coat's tables quickly; what that misses the exact projection corrects.
      std::optional<QuickCoats> quick;
      if (pass != FitPass::exact) quick.emplace();
      const std::unique_ptr<Model> made = model.make(x);
      if (pass == FitPass::exact) return projected_means(*made, *model.info, target);
      return cell_means(*made, target, pass == FitPass::fine ? fine : coarse, isa);
    } catch (const ParameterError&) {
      return std::nullopt;
    }
  };
  ModelFit fit = fit_subject(subject, target, norm, stop);
  fit.info = model.info;
  fit.request = request_of(model, model.parameters(fit.scaled));
  return fit;
}

}  // namespace lamella
