#include "analytic/model/directional_integral.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace lamella {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPoints = 15;
// A line of neighbours whose sixth differences tell the noise, and the lines of a panel.
constexpr int kLine = 12, kDifference = 6, kLines = 3;
// Steps of a line of neighbours, in units of a panel: fine enough that a function which the panel's
// rule resolves has no sixth difference, and, with the narrowest panel (radians), coarser than
// neighbours in single precision.
constexpr double kLineStep = 1.0 / 64;
constexpr double kNarrowest = 1e-5;
// A panel has missed a peak if it holds a direction, or has a corner, at which the function is this
// factor above the largest value at its nodes.
constexpr double kMissedPeak = 10;
// Share of the tolerance that a panel's error may be whatever its noise: next to a singular point
// panels could be halved for ever without changing the sum.
constexpr double kNegligible = 1e-4;
// Standard deviations of the noise that are told as error, and those of the rules' difference that
// noise explains.
constexpr double kToldDeviations = 4, kExplainedDeviations = 4;
// Beyond this mu another rule begins: models vary fastest next to grazing.
constexpr double kGrazing = 0.1;

/// Nodes in [-1, 1] with the weights of Kronrod's rule and of the Gauss rule inside, 0 where that
/// has no node.
struct Rules {
  std::array<double, kPoints> node{}, kronrod{}, embedded{};
  double noise = 0;  ///< standard deviation of the difference of a panel's rules, per that of f

  Rules() {
    using boost::math::quadrature::gauss;
    using boost::math::quadrature::gauss_kronrod;
    const auto& x = gauss_kronrod<double, kPoints>::abscissa();
    const auto& k = gauss_kronrod<double, kPoints>::weights();
    const auto& g = gauss<double, kPoints / 2>::weights();
    constexpr int kMiddle = kPoints / 2;
    for (int i = 0; i <= kMiddle; ++i) {
      // Every other node of Kronrod's rule is one of the Gauss rule, the middle one among them.
      const double inner = i % 2 == 0 ? g[i / 2] : 0;
      for (const int at : {kMiddle - i, kMiddle + i}) {
        node[at] = at < kMiddle ? -x[i] : x[i];
        kronrod[at] = k[i] / 2;
        embedded[at] = inner / 2;
      }
    }
    double squares = 0;
    for (int i = 0; i < kPoints; ++i)
      for (int j = 0; j < kPoints; ++j) {
        const double d = (kronrod[i] - embedded[i]) * kronrod[j];
        squares += d * d;
      }
    noise = std::sqrt(squares);
  }
};

const Rules& rules() {
  static const Rules shared;
  return shared;
}

struct Panel {
  double side = 1, mu0 = 0, mu1 = 0, phi0 = 0, phi1 = 0;
  Rgb value{}, size{};  // integrals of the function and of its absolute value
  Rgb error{};          // along both axes together
  Rgb noise{};          // standard deviation of a value times the panel's measure
  double largest = 0;   // absolute value of the function times mu at a node
  double corner = 0;    // the same at its corners above the horizon
  bool halve_mu = false;
  double priority = 0;

  [[nodiscard]] Direction at(double mu, double phi) const {
    return direction_from_mu_phi(side * mu, phi);
  }
  /// Widths in radians, that along phi where it is widest.
  [[nodiscard]] double height() const { return angle_from_normal(mu0) - angle_from_normal(mu1); }
  [[nodiscard]] double width() const { return (phi1 - phi0) * sine_of(mu0); }
  [[nodiscard]] bool is_narrow() const { return (halve_mu ? height() : width()) < kNarrowest; }

  [[nodiscard]] static double sine_of(double mu) { return std::sqrt((1 - mu) * (1 + mu)); }
  [[nodiscard]] static double angle_from_normal(double mu) { return std::atan2(sine_of(mu), mu); }
};

/// A direction where models have their peaks, and the absolute value of the function times mu
/// there.
struct Peak {
  double side, mu, phi, value;

  [[nodiscard]] bool is_pole() const { return mu == 1; }
  [[nodiscard]] bool is_in(const Panel& p) const {
    constexpr double kRounding = 1e-12;
    if (side != p.side || mu < p.mu0 - kRounding || mu > p.mu1 + kRounding) return false;
    if (is_pole()) return true;
    const double turns = (phi - p.phi0 + kRounding) / (2 * kPi);
    return 2 * kPi * (turns - std::floor(turns)) <= p.phi1 - p.phi0 + 2 * kRounding;
  }
};

double largest_channel(Rgb v) { return std::max({std::abs(v.r), std::abs(v.g), std::abs(v.b)}); }

class Integral {
 public:
  Integral(const DirectionalFunction& g, const IntegralLimits& limits) : g_(g), limits_(limits) {}

  DirectionalIntegral run(Direction wi, std::span<const double> sides);

 private:
  void measure(Panel& panel);
  void measure_noise(Panel& panel);
  void evaluate();
  void find_peaks(Direction wi, std::span<const double> sides);
  void add(const Panel& panel, double sign);
  void push(Panel panel);
  [[nodiscard]] bool reached() const;
  /// How far a panel's error is above what its noise explains, in units of the integral.
  [[nodiscard]] double excess(const Panel& panel) const;

  const DirectionalFunction& g_;
  const IntegralLimits& limits_;
  Clock::time_point start_ = Clock::now();
  std::vector<Peak> peaks_;
  std::vector<Panel> heap_;
  std::vector<Panel> settled_;
  std::vector<Direction> directions_;
  std::vector<Rgb> values_;
  Rgb size_, error_;
  std::uint64_t evaluations_ = 0;
  bool narrow_ = false;  // a panel that could not be halved had more error than noise
};

void Integral::evaluate() {
  values_.assign(directions_.size(), Rgb());
  g_(directions_, values_);
  evaluations_ += directions_.size();
  for (std::size_t k = 0; k < values_.size(); ++k)
    if (const Rgb v = values_[k]; !std::isfinite(v.r + v.g + v.b))
      throw std::domain_error(
          fmt::format("a value that is not finite: ({}, {}, {}) at w_o = ({}, {}, {})", v.r, v.g,
                      v.b, directions_[k].x, directions_[k].y, directions_[k].z));
}

void Integral::measure(Panel& p) {
  const Rules& rule = rules();
  const double mu_middle = (p.mu0 + p.mu1) / 2, mu_half = (p.mu1 - p.mu0) / 2;
  const double phi_middle = (p.phi0 + p.phi1) / 2, phi_half = (p.phi1 - p.phi0) / 2;
  directions_.clear();
  for (const double x : rule.node)
    for (const double y : rule.node)
      directions_.push_back(p.at(mu_middle + mu_half * x, phi_middle + phi_half * y));
  for (const double mu : {p.mu0, p.mu1})
    for (const double phi : {p.phi0, p.phi1})
      if (mu > 0) directions_.push_back(p.at(mu, phi));
  evaluate();
  const double area = 4 * mu_half * phi_half;
  Rgb along_mu, along_phi;
  for (int i = 0; i < kPoints; ++i) {
    const double mu = mu_middle + mu_half * rule.node[i];
    for (int j = 0; j < kPoints; ++j) {
      const Rgb f = area * mu * values_[static_cast<std::size_t>(i) * kPoints + j];
      const double both = rule.kronrod[i] * rule.kronrod[j];
      p.value += both * f;
      for (int c = 0; c < 3; ++c) p.size[c] += both * std::abs(f[c]);
      along_mu += (rule.kronrod[i] - rule.embedded[i]) * rule.kronrod[j] * f;
      along_phi += rule.kronrod[i] * (rule.kronrod[j] - rule.embedded[j]) * f;
    }
  }
  for (std::size_t k = 0; k < values_.size(); ++k) {
    double& largest = k < kPoints * kPoints ? p.largest : p.corner;
    largest = std::max(largest, std::abs(directions_[k].z) * largest_channel(values_[k]));
  }
  double mu_error = 0, phi_error = 0;
  for (int c = 0; c < 3; ++c) {
    p.error[c] = std::abs(along_mu[c]) + std::abs(along_phi[c]);
    mu_error = std::max(mu_error, std::abs(along_mu[c]));
    phi_error = std::max(phi_error, std::abs(along_phi[c]));
  }
  if (!std::isfinite(p.error.r + p.error.g + p.error.b))
    throw std::domain_error("values so large that their integral is not finite");
  p.halve_mu = mu_error >= phi_error;
  measure_noise(p);
}

// The smallest of the lines' estimates: a kink or a jump that crosses one is no noise.
void Integral::measure_noise(Panel& p) {
  const double dmu = p.mu1 - p.mu0, dphi = p.phi1 - p.phi0;
  directions_.clear();
  std::array<double, kLines * kLine> mus{};
  for (int line = 0; line < kLines; ++line)
    for (int k = 0; k < kLine; ++k) {
      // At the corners of a triangle, which no straight edge meets all, in different directions.
      constexpr std::array<double, kLines> kX{0.1, 0.7, 0.3}, kY{0.15, 0.3, 0.75};
      const double x = kX[line] + kLineStep * k;
      const double y = kY[line] + (line % 2 == 0 ? kLineStep : -0.71 * kLineStep) * k;
      mus[static_cast<std::size_t>(line) * kLine + k] = p.mu0 + dmu * x;
      directions_.push_back(p.at(p.mu0 + dmu * x, p.phi0 + dphi * y));
    }
  evaluate();
  // (k!)^2 / (2 k)! of k = 6: what independent values of variance 1 have as mean square of their
  // sixth differences, inverted.
  constexpr double kScale = 1.0 / 924;
  for (int c = 0; c < 3; ++c) {
    double least = std::numeric_limits<double>::infinity();
    for (int line = 0; line < kLines; ++line) {
      std::array<double, kLine> d{};
      for (int k = 0; k < kLine; ++k) {
        const std::size_t at = static_cast<std::size_t>(line) * kLine + k;
        d[k] = mus[at] * values_[at][c];
      }
      for (int order = 1; order <= kDifference; ++order)
        for (int k = 0; k + order < kLine; ++k) d[k] = d[k + 1] - d[k];
      double squares = 0;
      for (int k = 0; k + kDifference < kLine; ++k) squares += d[k] * d[k];
      least = std::min(least, std::sqrt(kScale * squares / (kLine - kDifference)));
    }
    p.noise[c] = least * dmu * dphi;
  }
}

double Integral::excess(const Panel& p) const {
  const double explained = kExplainedDeviations * 2 * rules().noise;  // along both axes
  double most = 0;
  for (int c = 0; c < 3; ++c)
    if (p.error[c] > explained * p.noise[c] &&
        p.error[c] > kNegligible * limits_.tolerance * size_[c])
      most = std::max(most, std::min(p.error[c] / size_[c], 1e300));
  return most;
}

void Integral::add(const Panel& p, double sign) {
  size_ += sign * p.size;
  error_ += sign * p.error;
}

// The normal, the mirrored direction, the light's own and the one straight on, where they lie on a
// side that is asked for.
void Integral::find_peaks(Direction wi, std::span<const double> sides) {
  directions_.clear();
  for (const double side : sides) {
    const Direction towards = wi.z * side < 0 ? -wi : wi;
    for (const Direction& w :
         {Direction{0, 0, side}, towards, Direction{-towards.x, -towards.y, towards.z}})
      // Next to the horizon there is no room for a peak, and models may have no value.
      if (std::abs(w.z) > kNarrowest) directions_.push_back(w);
  }
  evaluate();
  for (std::size_t k = 0; k < directions_.size(); ++k) {
    const Direction w = directions_[k];
    peaks_.push_back({.side = w.z < 0 ? -1.0 : 1.0,
                      .mu = std::min(1.0, std::abs(w.z)),
                      .phi = azimuth(w),
                      .value = std::abs(w.z) * largest_channel(values_[k])});
  }
}

// What no halving betters is settled.
void Integral::push(Panel p) {
  p.priority = excess(p);
  double missed = p.corner;
  bool pole = false;
  for (const Peak& peak : peaks_)
    if (peak.value >= missed && peak.is_in(p)) {
      missed = peak.value;
      pole = peak.is_pole();
    }
  if (missed > kMissedPeak * p.largest) {
    p.halve_mu = pole || p.height() >= p.width();
    p.priority = std::numeric_limits<double>::infinity();
    if (p.is_narrow()) {
      // The peak is narrower than any panel: what it may hold is error.
      const Rgb unseen(missed * (p.mu1 - p.mu0) * (p.phi1 - p.phi0));
      p.error += unseen;
      error_ += unseen;
    }
  }
  if (p.is_narrow() && p.priority > 0) narrow_ = true;
  if (p.is_narrow() || p.priority == 0) {
    settled_.push_back(p);
    return;
  }
  heap_.push_back(p);
  std::push_heap(heap_.begin(), heap_.end(),
                 [](const Panel& a, const Panel& b) { return a.priority < b.priority; });
}

bool Integral::reached() const {
  if (!heap_.empty() && std::isinf(heap_.front().priority)) return false;  // a peak was missed
  for (int c = 0; c < 3; ++c)
    if (error_[c] > limits_.tolerance * size_[c]) return false;
  return true;
}

DirectionalIntegral Integral::run(Direction wi, std::span<const double> sides) {
  std::vector<double> edges{0, kGrazing, 1};
  const double cosine = std::min(1.0, std::abs(wi.z)), theta = Panel::angle_from_normal(cosine);
  if (std::all_of(edges.begin(), edges.end(), [&](double edge) {
        return std::abs(theta - Panel::angle_from_normal(edge)) > kNarrowest;
      }))
    edges.push_back(cosine);
  std::sort(edges.begin(), edges.end());
  find_peaks(wi, sides);
  const double phi = azimuth(wi);
  std::vector<Panel> first;
  for (const double side : sides)
    for (std::size_t k = 0; k + 1 < edges.size(); ++k)
      for (int quarter = 0; quarter < 4; ++quarter) {
        Panel p{.side = side,
                .mu0 = edges[k],
                .mu1 = edges[k + 1],
                .phi0 = phi + quarter * kPi / 2,
                .phi1 = phi + (quarter + 1) * kPi / 2};
        measure(p);
        add(p, 1);
        first.push_back(p);
      }
  for (const Panel& p : first) push(p);

  DirectionalIntegral result;
  for (;;) {
    if (reached()) {
      result.end = IntegralEnd::tolerance;
      break;
    }
    if (heap_.empty()) {
      result.end = narrow_ ? IntegralEnd::limit : IntegralEnd::noise;
      break;
    }
    if (evaluations_ >= limits_.evaluations) {
      result.end = IntegralEnd::limit;
      break;
    }
    if (std::chrono::duration<double>(Clock::now() - start_).count() > limits_.seconds) {
      result.end = IntegralEnd::time;
      break;
    }
    std::pop_heap(heap_.begin(), heap_.end(),
                  [](const Panel& a, const Panel& b) { return a.priority < b.priority; });
    const Panel parent = heap_.back();
    heap_.pop_back();
    add(parent, -1);
    for (const bool upper : {false, true}) {
      Panel half{.side = parent.side,
                 .mu0 = parent.mu0,
                 .mu1 = parent.mu1,
                 .phi0 = parent.phi0,
                 .phi1 = parent.phi1};
      if (parent.halve_mu)
        (upper ? half.mu0 : half.mu1) = (parent.mu0 + parent.mu1) / 2;
      else
        (upper ? half.phi0 : half.phi1) = (parent.phi0 + parent.phi1) / 2;
      measure(half);
      add(half, 1);
      push(half);
    }
  }
  // Sums anew: adding and taking away leaves rounding.
  Rgb noise;
  for (const auto* list : {&heap_, &settled_})
    for (const Panel& p : *list) {
      result.value += p.value;
      result.error += p.error;
      noise += p.noise;
    }
  result.error += kToldDeviations * noise;
  result.evaluations = evaluations_;
  return result;
}

}  // namespace

const char* to_text(IntegralEnd end) {
  switch (end) {
    case IntegralEnd::tolerance:
      return "tolerance";
    case IntegralEnd::noise:
      return "noise";
    case IntegralEnd::limit:
      return "limit";
    case IntegralEnd::time:
      break;
  }
  return "time";
}

const char* reason_of(IntegralEnd end) {
  switch (end) {
    case IntegralEnd::tolerance:
      return "the tolerance";
    case IntegralEnd::noise:
      return "noise of the values";
    case IntegralEnd::limit:
      return "the limit of evaluations (a jump, or a very sharp feature?)";
    case IntegralEnd::time:
      break;
  }
  return "the limit of time";
}

DirectionalIntegral integrate_projected(const DirectionalFunction& g, Direction wi,
                                        std::span<const double> sides,
                                        const IntegralLimits& limits) {
  return Integral(g, limits).run(wi, sides);
}

}  // namespace lamella
