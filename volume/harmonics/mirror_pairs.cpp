#include "volume/harmonics/mirror_pairs.h"

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <vector>

#include "volume/harmonics/mirror_flight.h"

namespace lamella {
namespace {

// Of a circle's integral, relative to f.
constexpr double kCircleError = 3e-8;
constexpr int kMaxPanels = 400;

// The rules of Gauss (7 points) and Kronrod (15) on (-1, 1).
struct GaussKronrod {
  std::array<double, 15> points{}, kronrod{}, gauss{};

  GaussKronrod() {
    using Rule = boost::math::quadrature::gauss_kronrod<double, 15>;
    using Few = boost::math::quadrature::gauss<double, 7>;
    for (int k = 0; k < 8; ++k)
      for (const int sign : {-1, 1}) {
        const int place = 7 + sign * k;
        points[place] = sign * Rule::abscissa()[k];
        kronrod[place] = Rule::weights()[k];
        if (k % 2 == 0) gauss[place] = Few::weights()[k / 2];
      }
  }
};

// A part of an interval [low, high] of a circle's cosine c, in t: c = low + (high - low) t^3 (10 -
// 15 t + 6 t^2).
struct Panel {
  double low, high, t0 = 0, t1 = 1;
  Rgb value{};
  double error = 0;

  [[nodiscard]] double at(double t) const {
    const double length = high - low;
    return t < 0.5 ? low + length * step(t) : high - length * step(1 - t);
  }
  [[nodiscard]] double slope(double t) const {
    return (high - low) * 30 * t * t * (1 - t) * (1 - t);
  }
  friend bool operator<(const Panel& a, const Panel& b) { return a.error < b.error; }

 private:
  [[nodiscard]] static double step(double t) { return t * t * t * (10 + t * (6 * t - 15)); }
};

// Piessens et al. 1983, QUADPACK: the error of the finer rule from the difference of both.
void integrate(MirrorFlight& flight, Panel& panel) {
  static const GaussKronrod rule;
  std::array<Rgb, 15> values;
  Rgb gauss;
  panel.value = Rgb();
  const double half = (panel.t1 - panel.t0) / 2;
  for (int k = 0; k < 15; ++k) {
    const double t = panel.t0 + half * (1 + rule.points[k]);
    values[k] = half * panel.slope(t) * flight.circle(panel.at(t));
    panel.value += rule.kronrod[k] * values[k];
    gauss += rule.gauss[k] * values[k];
  }
  panel.error = 0;
  for (int c = 0; c < 3; ++c) {
    const double difference = std::abs(panel.value[c] - gauss[c]);
    double spread = 0;
    for (int k = 0; k < 15; ++k)
      spread += rule.kronrod[k] * std::abs(values[k][c] - panel.value[c] / 2);
    const double error =
        spread > 0 ? spread * std::min(1.0, std::pow(100 * difference / spread, 1.5)) : difference;
    panel.error = std::max(panel.error, error);
  }
}

}  // namespace

MirrorPairs::MirrorPairs(const Stack& stack, Isa isa, MirrorCircles circles)
    : layers_(std::make_unique<MirrorLayers>(stack, isa, circles)) {}

MirrorPairs::MirrorPairs(MirrorPairs&&) noexcept = default;
MirrorPairs& MirrorPairs::operator=(MirrorPairs&&) noexcept = default;
MirrorPairs::~MirrorPairs() = default;

bool MirrorPairs::is_empty() const { return layers_->mirrors.empty(); }

MirrorPairs::Value MirrorPairs::operator()(Direction wi, Direction wo, double tolerance) const {
  if (is_empty() || (!layers_->stack.is_open_below() && (wi.z < 0 || wo.z < 0))) return {};
  MirrorFlight flight(*layers_, wi, wo);
  const double common = 1 / (std::abs(wi.z) * std::abs(wo.z));
  const std::vector<double>& breaks = flight.breaks();
  std::vector<Panel> panels;
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k)
    if (breaks[k + 1] - breaks[k] > 1e-13) panels.push_back({breaks[k], breaks[k + 1]});
  double error = 0;
  for (Panel& panel : panels) {
    integrate(flight, panel);
    error += panel.error;
  }
  std::make_heap(panels.begin(), panels.end());
  while (common * error > tolerance && panels.size() < kMaxPanels) {
    std::pop_heap(panels.begin(), panels.end());
    Panel left = panels.back();
    panels.pop_back();
    error -= left.error;
    Panel right = left;
    left.t1 = right.t0 = (left.t0 + left.t1) / 2;
    for (Panel* half : {&left, &right}) {
      integrate(flight, *half);
      error += half->error;
      panels.push_back(*half);
      std::push_heap(panels.begin(), panels.end());
    }
  }
  // Sums anew: adding and taking away leaves rounding.
  Value result;
  for (const Panel& panel : panels) {
    result.f += common * panel.value;
    result.error += common * panel.error;
  }
  result.error += kCircleError * result.f.max();
  return result;
}

}  // namespace lamella
