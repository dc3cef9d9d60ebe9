#include "compare/fit/sampler_fit.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

namespace lamella {
namespace {

constexpr double kLeastUniform = 0.02;

/// A direction of the rule in the frame of w_o, and f |mu_i| there times the root of its weight.
struct Node {
  Direction wi;
  double value;
};

/// Nodes over half of the hemisphere: isotropic models do not change with the sign of phi. Steps in
/// mu^(1/2) gather them at grazing directions.
std::vector<Node> nodes_of(const Model& model, Direction wo) {
  using Rule = boost::math::quadrature::gauss<double, 30>;
  std::vector<std::pair<double, double>> unit;  // on [0, 1]
  for (std::size_t k = 0; k < Rule::abscissa().size(); ++k)
    for (const double sign : {-1.0, 1.0})
      unit.emplace_back((1 + sign * Rule::abscissa()[k]) / 2, Rule::weights()[k] / 2);
  std::vector<Node> nodes;
  for (const auto& [x, wx] : unit)
    for (const auto& [y, wy] : unit) {
      const double mu = x * x, phi = kPi * y;
      const Direction wi = direction_from_mu_phi(mu, phi);
      const double weight = 2 * wx * 2 * x * kPi * wy;  // dmu dphi, both signs of phi
      nodes.push_back({wi, model.eval(wi, wo).g * mu * std::sqrt(weight)});
    }
  return nodes;
}

ClippedCosine lobe_of(const double* p) {
  return {.a = p[0], .b = p[1], .c = p[2], .d = p[3], .uniform = p[4]};
}

double second_moment(const std::vector<Node>& nodes, HemisphereSampler sampler,
                     const ClippedCosine& lobe) {
  double sum = 0;
  for (const Node& n : nodes) sum += n.value * n.value / lobe.pdf(sampler, n.wi);
  return sum;
}

struct Residuals {
  const std::vector<Node>& nodes;

  bool operator()(const double* p, double* residuals) const {
    const ClippedCosine lobe = lobe_of(p);
    if (!(lobe.c > 0 && lobe.a - lobe.b * lobe.d > 0)) return false;
    for (std::size_t k = 0; k < nodes.size(); ++k)
      residuals[k] = nodes[k].value / std::sqrt(lobe.pdf(HemisphereSampler::mis, nodes[k].wi));
    return true;
  }
};

void improve(const std::vector<Node>& nodes, std::array<double, 5>& p) {
  ceres::Problem problem;
  using Cost = ceres::NumericDiffCostFunction<Residuals, ceres::CENTRAL, ceres::DYNAMIC, 5>;
  problem.AddResidualBlock(
      new Cost(new Residuals{nodes}, ceres::TAKE_OWNERSHIP, static_cast<int>(nodes.size())),
      nullptr, p.data());
  problem.SetParameterLowerBound(p.data(), 4, kLeastUniform);
  problem.SetParameterUpperBound(p.data(), 4, 1);
  ceres::Solver::Options options;
  options.max_num_iterations = 200;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

}  // namespace

SamplingLobeTable fit_sampling_lobes(
    const std::function<std::unique_ptr<Model>(double roughness)>& model, int roughnesses,
    int cosines) {
  SamplingLobeTable table{.roughnesses = roughnesses, .cosines = cosines};
  std::vector<std::array<double, 5>> last(cosines, {1, 0, 1, 0, 0.1});
  for (int i = 0; i < roughnesses; ++i) {
    const double root = static_cast<double>(i) / (roughnesses - 1);
    const auto rough = model(root * root);
    for (int j = 0; j < cosines; ++j) {
      const double x = static_cast<double>(j) / (cosines - 1);
      const Direction wo = with_grazing_limit(direction_from_mu_phi(x * x, 0));
      const std::vector<Node> nodes = nodes_of(*rough, wo);
      const double before = second_moment(nodes, HemisphereSampler::cosine, {});
      ClippedCosine lobe;
      double after = before;
      if (i > 0) {
        // From the smoother neighbour and from the more grazing one: the better of both.
        std::array<double, 5> p = last[j];
        improve(nodes, p);
        if (j > 0) {
          std::array<double, 5> q = last[j - 1];
          improve(nodes, q);
          if (second_moment(nodes, HemisphereSampler::mis, lobe_of(q.data())) <
              second_moment(nodes, HemisphereSampler::mis, lobe_of(p.data())))
            p = q;
        }
        last[j] = p;
        lobe = lobe_of(p.data());
        after = second_moment(nodes, HemisphereSampler::mis, lobe);
      }
      table.lobes.push_back(lobe);
      table.cosine_moment.push_back(before);
      table.moment.push_back(after);
    }
  }
  return table;
}

std::string to_initializers(const SamplingLobeTable& table) {
  std::string text;
  for (const ClippedCosine& l : table.lobes)
    text +=
        fmt::format("{{{:.5g}, {:.5g}, {:.5g}, {:.5g}, {:.5g}}},\n", l.a, l.b, l.c, l.d, l.uniform);
  return text;
}

}  // namespace lamella
