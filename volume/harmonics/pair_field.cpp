#include "volume/harmonics/pair_field.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lamella {
namespace {

constexpr int kMaxHalvings = 16;
constexpr double kShareOfPoint = 0.5;  // of the tolerance, for each value
// A part whose two middle lines leave this many times the tolerance is halved at once.
constexpr double kHopeless = 3;
constexpr double kSame = 1e-12;

}  // namespace

struct PairField::Part {
  LegendrePatch patch;
  double error = 0;
  // Where it was halved: along q or along p.
  bool along_q = false;
  std::unique_ptr<Part> first, second;

  [[nodiscard]] int count() const { return first ? first->count() + second->count() : 1; }
};

// Halves parts until they hold.
struct PairField::Builder {
  const PairField& field;
  const MirrorPairs& pairs;
  Direction wi;
  const std::function<double(double mu)>& tolerance;
  const std::atomic<bool>* stop;

  struct Range {
    double q0, q1, p0, p1;
  };

  [[nodiscard]] Direction at(const Band& band, int root, const Range& r, double u, double v) const {
    const double theta = band.theta(r.q0 + (r.q1 - r.q0) * u);
    return field.direction(theta, field.azimuth_at(root, theta, r.p0 + (r.p1 - r.p0) * v));
  }

  std::unique_ptr<Part> build(const Band& band, int root, const Range& r, int halvings) const {
    auto part = std::make_unique<Part>();
    if (stop && *stop) return part;
    // The least of its corners, its edges and its middle.
    double allowed = std::numeric_limits<double>::infinity();
    for (const double u : {0.0, 0.5, 1.0})
      for (const double v : {0.0, 0.5, 1.0})
        allowed = std::min(allowed, tolerance(std::abs(at(band, root, r, u, v).z)));
    double of_points = 0;
    const auto f = [&](double u, double v) {
      const MirrorPairs::Value value =
          pairs(wi, field.within(at(band, root, r, u, v)), kShareOfPoint * allowed);
      of_points = std::max(of_points, value.error);
      return value.f;
    };
    LegendrePatch::LeftOver left = LegendrePatch::on_axes(f);
    if (left.sum() > kHopeless * allowed && halvings < kMaxHalvings) {
      halve(band, root, r, halvings, left, *part);
      return part;
    }
    part->patch = LegendrePatch(f);
    left = part->patch.left_over();
    double error = left.sum();
    if (error <= allowed || halvings == kMaxHalvings) error = std::max(error, part->patch.off(f));
    part->error = error + of_points;
    if (error <= allowed || halvings == kMaxHalvings) return part;
    halve(band, root, r, halvings, left, *part);
    return part;
  }

  void halve(const Band& band, int root, const Range& r, int halvings, LegendrePatch::LeftOver left,
             Part& part) const {
    part.along_q = left.u > left.v;
    Range low = r, high = r;
    if (part.along_q)
      low.q1 = high.q0 = (r.q0 + r.q1) / 2;
    else
      low.p1 = high.p0 = (r.p0 + r.p1) / 2;
    tbb::parallel_invoke([&] { part.first = build(band, root, low, halvings + 1); },
                         [&] { part.second = build(band, root, high, halvings + 1); });
  }
};

double PairField::Band::theta(double q) const {
  const double y = crowds_at_from && crowds_at_to ? q * q * (3 - 2 * q)
                   : crowds_at_from               ? q * q
                   : crowds_at_to                 ? q * (2 - q)
                                                  : q;
  return from + (to - from) * y;
}

double PairField::Band::q(double theta) const {
  const double y = std::clamp((theta - from) / (to - from), 0.0, 1.0);
  if (crowds_at_from && crowds_at_to) return 0.5 - std::sin(std::asin(1 - 2 * y) / 3);
  if (crowds_at_from) return std::sqrt(y);
  if (crowds_at_to) return 1 - std::sqrt(1 - y);
  return y;
}

bool PairField::applies(const MirrorPairs& pairs) {
  return !pairs.is_empty() && !pairs.layers().about_normal;
}

bool PairField::folds_phi(const MirrorLayers& layers, Direction wi) {
  return layers.is_symmetric_about_axis && std::abs(dot(wi, layers.frame.t)) < kSame;
}

bool PairField::folds_theta(const MirrorLayers& layers, Direction wi) {
  return layers.is_symmetric_across_axis && std::abs(layers.frame.n.z) < kSame &&
         std::abs(dot(wi, layers.frame.n)) < kSame;
}

// Measured: 100 to 400 parts at tolerances of 1e-5 and 1e-6, widths of 0.5 and 0.1, and for each
// the middle lines of one more that is halved at once.
double PairField::expected_pairs(const MirrorPairs& pairs, Direction wi, double tolerance,
                                 double width) {
  const double digits = std::max(0.3, -std::log10(tolerance) - 3);
  const double parts = 96 * digits * std::pow(0.1 / std::min(width, 1.0), 0.3);
  const double folds =
      (folds_phi(pairs.layers(), wi) ? 2 : 1) * (folds_theta(pairs.layers(), wi) ? 2 : 1);
  return parts * kValuesOfPart / folds;
}

PairField::PairField(const MirrorPairs& pairs, Direction wi, bool up,
                     const std::function<double(double mu)>& tolerance,
                     const std::atomic<bool>* stop)
    : frame_(pairs.layers().frame), is_up_(up) {
  const double sign = up ? 1 : -1;
  frame_.s = sign * frame_.s;
  frame_.t = sign * frame_.t;
  height_ = sign * frame_.n.z;
  swing_ = sign * frame_.s.z;
  folds_phi_ = folds_phi(pairs.layers(), wi);
  folds_theta_ = folds_theta(pairs.layers(), wi);
  // Bands end where circles touch the horizon and at the polar angles of w_i and -w_i.
  const double touch = std::acos(std::min(1.0, swing_));
  const double in = std::acos(std::clamp(dot(wi, frame_.n), -1.0, 1.0));
  const double first = height_ > 0 ? 0 : touch, last = height_ > 0 ? kPi - touch : kPi;
  std::vector<double> ends{first, last, in, kPi - in, touch, kPi - touch};
  if (folds_theta_) ends.push_back(kPi / 2);
  std::sort(ends.begin(), ends.end());
  const auto is_touch = [&](double theta) {
    return std::abs(theta - touch) < kSame || std::abs(theta - (kPi - touch)) < kSame;
  };
  double from = first;
  for (const double end : ends) {
    if (end < from + 1e-9 || end > last + kSame) continue;
    if (!folds_theta_ || (from + end) / 2 < kPi / 2)
      bands_.push_back({from, end, is_touch(from), is_touch(end)});
    from = end;
  }
  const Builder builder{*this, pairs, wi, tolerance, stop};
  struct Root {
    Band* band;
    int root;
  };
  std::vector<Root> roots;
  for (Band& band : bands_) {
    band.roots.resize(this->roots());
    for (int k = 0; k < this->roots(); ++k) roots.push_back({&band, k});
  }
  tbb::parallel_for(std::size_t{0}, roots.size(), [&](std::size_t k) {
    const auto& [band, root] = roots[k];
    band->roots[root] = builder.build(*band, root, {0, 1, 0, 1}, 0);
  });
  is_whole_ = !(stop && *stop);
}

PairField::~PairField() = default;
PairField::PairField(PairField&&) noexcept = default;

// The halves of the arcs on both sides of azimuth 0, or one where azimuths come in pairs.
int PairField::roots() const { return folds_phi_ ? 1 : 2; }

Direction PairField::direction(double theta, double phi) const {
  const double s = std::sin(theta);
  return std::cos(theta) * frame_.n + s * std::cos(phi) * frame_.s + s * std::sin(phi) * frame_.t;
}

// Ends of arcs lie on the horizon but for rounding, on either side.
Direction PairField::within(Direction w) const {
  constexpr double kLowest = 1e-9;
  const double mu = is_up_ ? w.z : -w.z;
  return mu > kLowest ? w : direction_from_mu_phi(is_up_ ? kLowest : -kLowest, azimuth(w));
}

double PairField::end_of_arc(double theta) const {
  const double s = swing_ * std::sin(theta);
  const double h = height_ * std::cos(theta);
  return s > 0 ? std::acos(std::clamp(-h / s, -1.0, 1.0)) : h > 0 ? kPi : kPi / 2;
}

double PairField::azimuth_at(int root, double theta, double p) const {
  return (root == 0 ? 1 : -1) * end_of_arc(theta) * p * (2 - p);
}

PairField::Place PairField::place(double theta, double phi) const {
  const double share = std::min(1.0, std::abs(phi) / end_of_arc(theta));
  return {phi < 0 && !folds_phi_ ? 1 : 0, 1 - std::sqrt(1 - share)};
}

PairField::Value PairField::at(Direction wo) const {
  double theta = std::acos(std::clamp(dot(wo, frame_.n), -1.0, 1.0));
  const double phi = std::atan2(dot(wo, frame_.t), dot(wo, frame_.s));
  if (folds_theta_ && theta > kPi / 2) theta = kPi - theta;
  const Band* band = &bands_.front();
  for (const Band& other : bands_)
    if (theta >= other.from) band = &other;
  const auto [root, p] = place(theta, phi);
  const Part* part = band->roots[root].get();
  double u = band->q(theta), v = p;
  while (part->first) {
    double& x = part->along_q ? u : v;
    x *= 2;
    const bool above = x >= 1;
    if (above) x -= 1;
    part = above ? part->second.get() : part->first.get();
  }
  return {part->patch.at(u, v), part->error};
}

int PairField::parts() const {
  int sum = 0;
  for (const Band& band : bands_)
    for (const auto& root : band.roots) sum += root->count();
  return sum;
}

}  // namespace lamella
