#include "volume/harmonics/mirror_flight.h"

#include <algorithm>
#include <cmath>

#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

const CircleRule& rule_of_panels() {
  static const CircleRule rule = [] {
    CircleRule r{};
    const Quadrature& gauss = cached_gauss_legendre(kCirclePoints);
    for (int j = 0; j < kCirclePoints; ++j) {
      r.place[j] = 2 * gauss.points[j] - 1;
      r.weight[j] = 2 * gauss.weights[j];
    }
    return r;
  }();
  return rule;
}

// How near to the horizon exp(-depth / mu) and 1 / (rate + 1 / mu) vary, as shares of the depth and
// of the other direction's mu, each in units of the projected area.
constexpr double kShareOfDepth = 0.12, kShareOfMu = 0.5;
constexpr double kPerRootOfDepth = 3;

double optical(double rate, double depth) { return rate == 0 || depth == 0 ? 0 : rate * depth; }

void add_zeros_of(const CircleWave& w, std::vector<CircleZero>& zeros) {
  add_zeros(w.a, w.b, w.c, w.d, w.e, zeros);
}

}  // namespace

struct MirrorFlight::Circle {
  Direction p, q, r;

  [[nodiscard]] CircleWave square() const {
    const double qq = dot(q, q), rr = dot(r, r);
    return {dot(p, p) + (qq + rr) / 2, 2 * dot(p, q), 2 * dot(p, r), (qq - rr) / 2, dot(q, r)};
  }
  template <class Map>
  [[nodiscard]] Circle mapped(const Map& map) const {
    return {map(p), map(q), map(r)};
  }
  [[nodiscard]] CircleWave along(Direction axis) const {
    return {dot(p, axis), dot(q, axis), dot(r, axis)};
  }
  [[nodiscard]] Direction at(double cosine, double sine) const { return p + cosine * q + sine * r; }
};

MirrorFlight::MirrorFlight(const MirrorLayers& layers, Direction wi, Direction wo)
    : layers_(layers), wi_(wi), wo_(wo), from_above_(wi.z > 0), mirrors_(layers.mirrors) {
  const bool reflects = (wi.z > 0) == (wo.z > 0);
  const int n = static_cast<int>(layers.parts.size());
  double tau_in = 0, tau_out = 0;
  for (int step = 0; step < n; ++step) {
    const MirrorLayers::Part& part = layers.parts[from_above_ ? step : n - 1 - step];
    CircleLayer met{part.mirror,
                    part.area,
                    part.depth,
                    sigma(*part.medium, wi) / std::abs(wi.z),
                    sigma(*part.medium, -wo) / std::abs(wo.z),
                    tau_in,
                    tau_out};
    tau_in += optical(met.a, part.depth);
    tau_out += optical(met.b, part.depth);
    met_.push_back(met);
  }
  double far = 0;
  for (int step = n; step-- > 0;) {
    CircleLayer& met = met_[step];
    if (!reflects) met.leave = far;
    far += optical(met.b, met.depth);
    met.enter = std::exp(-met.enter);
    met.leave = std::exp(-met.leave);
  }
  // exp(-depth / mu) of light that crosses a thick stack is as narrow as the root of its depth.
  longest_ = layers.longest;
  if (!reflects)
    longest_ = std::min(longest_, kPerRootOfDepth / std::sqrt(tau_in * std::abs(wi.z)));
  const int mirrors = static_cast<int>(mirrors_.size()),
            areas = static_cast<int>(layers.media.size());
  scratch_.resize(circle_scratch(mirrors, areas, layers.channels));
  squares_.resize(areas);
  areas_.resize(areas);
  of_areas_.resize(areas);
  task_.mirrors = mirrors;
  task_.areas = areas;
  task_.layers = n;
  task_.channels = layers.channels;
  task_.mirror = mirrors_.data();
  task_.square_of_area = squares_.data();
  task_.area = of_areas_.data();
  task_.layer = met_.data();
  task_.rule = &rule_of_panels();
  task_.reflects = reflects;
  task_.scratch = scratch_.data();

  const Direction axis = layers.frame.n;
  const double in = dot(wi, axis), out = dot(wo, axis);
  breaks_ = {-1, -in, out, 1};
  if (layers.about_normal) {
    breaks_.push_back(0);
  } else {
    // Where both directions are each other's mirror image about the axis; where circles touch the
    // horizon.
    const double touch = std::hypot(axis.x, axis.y);
    breaks_.insert(breaks_.end(), {in, -out, -touch, touch});
  }
  for (double& cosine : breaks_) cosine = std::clamp(cosine, -1.0, 1.0);
  std::sort(breaks_.begin(), breaks_.end());
}

Rgb MirrorFlight::circle(double cosine) {
  const double sine = std::sqrt((1 - cosine) * (1 + cosine));
  const Frame<double>& frame = layers_.frame;
  const Circle circle{cosine * frame.n, sine * frame.s, sine * frame.t};
  zeros_.clear();
  for (std::size_t k = 0; k < mirrors_.size(); ++k) {
    event(k, 0, wi_, 1, circle);
    event(k, 1, wo_, -1, circle);
  }
  for (std::size_t k = 0; k < squares_.size(); ++k)
    if (const Sggx* sggx = normals_of<Sggx>(*layers_.media[k])) {
      squares_[k] =
          circle.mapped([&](Direction w) { return sggx->matrix().apply_transposed(w); }).square();
      add_zeros_of(squares_[k], zeros_);
    }
  double sum[3] = {0, 0, 0};
  const double height = circle.p.z, swing = circle.q.z;
  if (layers_.about_normal) {
    panels_.place(zeros_, longest_);
    add_arc(circle, height > 0, sum);
  } else if (std::abs(height) >= swing) {
    // Begins and ends where it is nearest to the horizon.
    const double begin = height > 0 ? -kPi : 0;
    const double gap = std::abs(height) - swing;
    const double mu = gap + near_horizon(circle.at(height > 0 ? -1 : 1, 0));
    panels_.place_arc(begin, begin + 2 * kPi, std::sqrt(mu / std::max(swing, 1e-300)), zeros_,
                      longest_);
    add_arc(circle, height > 0, sum);
  } else {
    const double end = std::acos(-height / swing);
    const double slope = std::sqrt((swing - height) * (swing + height));
    const double mu = near_horizon(circle.at(-height / swing, slope / swing));
    const double near = 2 * mu / (slope + std::sqrt(slope * slope + 2 * swing * mu));
    panels_.place_arc(-end, end, near, zeros_, longest_);
    add_arc(circle, true, sum);
    panels_.place_arc(end, 2 * kPi - end, near, zeros_, longest_);
    add_arc(circle, false, sum);
  }
  return layers_.channels == 1 ? sum[0] * layers_.tint : Rgb(sum[0], sum[1], sum[2]);
}

// The mu below which what light meets along w varies.
double MirrorFlight::near_horizon(Direction w) const {
  double least = 2;
  for (const CircleLayer& layer : met_) {
    const double area = sigma(*layers_.media[layer.area], w);
    if (area == 0) continue;
    least = std::min(least, area * kShareOfDepth * layer.depth);
    for (const double rate : {layer.a, layer.b})
      if (rate > 0) least = std::min(least, area * kShareOfMu / rate);
  }
  return least;
}

// The panels of an arc on one side of the horizon.
void MirrorFlight::add_arc(const Circle& circle, bool above, double* sum) {
  for (std::size_t k = 0; k < squares_.size(); ++k) {
    of_areas_[k] = nullptr;
    if (normals_of<Sggx>(*layers_.media[k])) continue;
    areas_[k].resize(static_cast<std::size_t>(panels_.size()) * kCirclePoints);
    for (std::size_t p = 0; p < areas_[k].size(); ++p) {
      const std::size_t panel = p / kCirclePoints;
      const double x = panels_.halves()[panel] * task_.rule->place[p % kCirclePoints];
      const double c = panels_.cosines()[panel], s = panels_.sines()[panel];
      const double cosine = c * std::cos(x) - s * std::sin(x);
      const double sine = s * std::cos(x) + c * std::sin(x);
      areas_[k][p] = sigma(*layers_.media[k], -circle.at(cosine, sine));
    }
    of_areas_[k] = areas_[k].data();
  }
  double of_arc[3] = {0, 0, 0};
  task_.panels = panels_.size();
  task_.cosine = panels_.cosines();
  task_.sine = panels_.sines();
  task_.half = panels_.halves();
  task_.mu = circle.along({0, 0, above ? 1.0 : -1.0});
  task_.onward = above != from_above_;
  task_.sum = of_arc;
  layers_.sum(task_);
  for (int c = 0; c < layers_.channels; ++c) sum[c] += of_arc[c];
}

// One event of one mirror, h = fixed + sign w'.
void MirrorFlight::event(std::size_t k, int which, Direction fixed, double sign,
                         const Circle& circle) {
  CircleMirror& mirror = mirrors_[k];
  // Both directions are unit.
  CircleWave& square = mirror.square[which] = circle.along(2 * sign * fixed);
  square.a += 2;
  const Circle h{fixed + sign * circle.p, sign * circle.q, sign * circle.r};
  CircleWave& other = mirror.other[which];
  if (mirror.is_sggx) {
    const SggxMatrix<double>& inverse = layers_.inverses[k];
    other = h.mapped([&](Direction v) { return inverse.apply(v); }).square();
    if (!mirror.is_constant) add_zeros_of(other, zeros_);
  } else {
    other = h.along(normals_of<Vmf>(*layers_.of_mirror[k])->axis());
  }
  if (!mirror.is_sggx || mirror.has_schlick) add_zeros(square.a, square.b, square.c, zeros_);
}

}  // namespace lamella
