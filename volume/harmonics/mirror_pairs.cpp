#include "volume/harmonics/mirror_pairs.h"

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <vector>

#include "volume/harmonics/circle_points.h"
#include "volume/harmonics/circle_sum.h"

namespace lamella {

// What does not depend on the directions.
struct MirrorLayers {
  struct Part {
    const Medium* medium;
    int mirror;  // which of the mirrors, or -1
    int area;    // which of the media
    double depth;
  };
  Stack stack;
  std::vector<CircleMirror> mirrors;
  std::vector<const Medium*> of_mirror;
  std::vector<SggxMatrix<double>> inverses;  // of mirrors with SGGX
  std::vector<const Medium*> media;          // distinct ones, for their projected areas
  std::vector<Part> parts;
  double longest = 2 * kPi;  // of a part of the circle
  int channels = 1;
  void (*sum)(const CircleTask& task) = &circle_sum;
};

namespace {

using Part = MirrorLayers::Part;
using Wave = CircleWave;

// Their error on a circle, relative to f: at most kCircleError.
constexpr int kPointsPerPart = 9;
constexpr double kCircleError = 3e-8;
constexpr int kMaxPanels = 400;

double optical(double rate, double depth) { return rate == 0 || depth == 0 ? 0 : rate * depth; }

template <class Ndf>
const Ndf* normals_of(const Medium& medium) {
  if (const auto* m = std::get_if<MirrorFlakes<Ndf>>(&medium)) return &m->ndf;
  if (const auto* m = std::get_if<LambertFlakes<Ndf>>(&medium)) return &m->ndf;
  return nullptr;
}

// Vectors p + q cos + r sin.
struct Circle {
  Direction p, q, r;

  [[nodiscard]] Wave square() const {
    const double qq = dot(q, q), rr = dot(r, r);
    return {dot(p, p) + (qq + rr) / 2, 2 * dot(p, q), 2 * dot(p, r), (qq - rr) / 2, dot(q, r)};
  }
  template <class Map>
  [[nodiscard]] Circle mapped(const Map& map) const {
    return {map(p), map(q), map(r)};
  }
  [[nodiscard]] Wave along(Direction axis) const {
    return {dot(p, axis), dot(q, axis), dot(r, axis)};
  }
};

void add_zeros_of(const Wave& w, std::vector<CircleZero>& zeros) {
  add_zeros(w.a, w.b, w.c, w.d, w.e, zeros);
}

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

// One pair of directions.
class Flight {
 public:
  Flight(const MirrorLayers& layers, Direction wi, Direction wo)
      : layers_(layers), wi_(wi), wo_(wo), mirrors_(layers.mirrors) {
    from_above_ = wi.z > 0;
    const bool reflects = (wi.z > 0) == (wo.z > 0);
    const int n = static_cast<int>(layers.parts.size());
    double tau_in = 0, tau_out = 0;
    for (int step = 0; step < n; ++step) {
      const Part& part = layers.parts[from_above_ ? step : n - 1 - step];
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
    task_.reflects = reflects;
    task_.scratch = scratch_.data();
  }
  Flight(const Flight&) = delete;
  Flight& operator=(const Flight&) = delete;

  // The integrand over mu', all but the common factor.
  [[nodiscard]] Rgb circle(double mu) {
    const double s = std::sqrt((1 - mu) * (1 + mu));
    const Circle circle{{0, 0, mu}, {s, 0, 0}, {0, s, 0}};
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
    points_.place(zeros_, layers_.longest);
    for (std::size_t k = 0; k < squares_.size(); ++k) {
      of_areas_[k] = nullptr;
      if (normals_of<Sggx>(*layers_.media[k])) continue;
      areas_[k].resize(points_.size());
      for (int p = 0; p < points_.size(); ++p)
        areas_[k][p] =
            sigma(*layers_.media[k], {-s * points_.cosines()[p], -s * points_.sines()[p], -mu});
      of_areas_[k] = areas_[k].data();
    }
    double sum[3] = {0, 0, 0};
    task_.points = points_.size();
    task_.cosine = points_.cosines();
    task_.sine = points_.sines();
    task_.weight = points_.weights();
    task_.inverse_mu = 1 / std::abs(mu);
    task_.onward = (mu > 0) != from_above_;
    task_.sum = sum;
    layers_.sum(task_);
    if (layers_.channels == 1) return Rgb(task_.inverse_mu * sum[0]);
    return task_.inverse_mu * Rgb(sum[0], sum[1], sum[2]);
  }

 private:
  // One event of one mirror, h = fixed + sign w'.
  void event(std::size_t k, int which, Direction fixed, double sign, const Circle& circle) {
    CircleMirror& mirror = mirrors_[k];
    // Both directions are unit.
    Wave& square = mirror.square[which] = circle.along(2 * sign * fixed);
    square.a += 2;
    const Circle h{fixed + sign * circle.p, sign * circle.q, sign * circle.r};
    Wave& other = mirror.other[which];
    if (mirror.is_sggx) {
      const SggxMatrix<double>& inverse = layers_.inverses[k];
      other = h.mapped([&](Direction v) { return inverse.apply(v); }).square();
      add_zeros_of(other, zeros_);
    } else {
      other = h.along(normals_of<Vmf>(*layers_.of_mirror[k])->axis());
    }
    if (!mirror.is_sggx || mirror.has_schlick) add_zeros(square.a, square.b, square.c, zeros_);
  }

  const MirrorLayers& layers_;
  Direction wi_, wo_;
  bool from_above_;
  std::vector<CircleLayer> met_;
  CirclePoints points_{kPointsPerPart, kCirclePoints};
  // Of one circle.
  std::vector<CircleMirror> mirrors_;
  std::vector<Wave> squares_;
  std::vector<std::vector<double>> areas_;
  std::vector<const double*> of_areas_;
  std::vector<CircleZero> zeros_;
  std::vector<double> scratch_;
  CircleTask task_{};
};

// A part of an interval [low, high] of mu', in t: mu' = low + (high - low) t^3 (10 - 15 t + 6 t^2).
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
void integrate(Flight& flight, Panel& panel) {
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

MirrorPairs::MirrorPairs(const Stack& stack, Isa isa) {
  auto layers = std::make_unique<MirrorLayers>();
  layers->stack = stack;
  if (const auto sum = circle_sum_lanes_for(isa)) layers->sum = sum;
  for (const Layer& layer : layers->stack.layers) {
    if (layer.interface || layer.depth() == 0) continue;
    const Medium& medium = layer.medium;
    Part part{&medium, -1, 0, layer.depth()};
    const auto same = std::find_if(layers->media.begin(), layers->media.end(),
                                   [&](const Medium* m) { return *m == medium; });
    part.area = static_cast<int>(same - layers->media.begin());
    if (same == layers->media.end()) layers->media.push_back(&medium);
    if (!layer.albedo.is_grey() || !layer.f0.is_grey()) layers->channels = 3;
    CircleMirror mirror{};
    SggxMatrix<double> inverse{};
    mirror.has_schlick = !(layer.f0 == Rgb(1));
    for (int c = 0; c < 3; ++c) {
      mirror.albedo[c] = layer.albedo[c];
      mirror.f0[c] = layer.f0[c];
    }
    if (const auto* of_sggx = std::get_if<MirrorFlakes<Sggx>>(&medium)) {
      const SggxMatrix<double>& a = of_sggx->ndf.matrix();
      inverse = a.inverse();
      mirror.is_sggx = true;
      mirror.scale = 1 / (4 * kPi * a.determinant());
      // The trace bounds what it sums.
      const auto squares = [](const SggxMatrix<double>& m) {
        return m.a00 * m.a00 + m.a10 * m.a10 + m.a11 * m.a11 + m.a20 * m.a20 + m.a21 * m.a21 +
               m.a22 * m.a22;
      };
      mirror.least = 1 / squares(inverse);
      mirror.largest = squares(a);
    } else if (const auto* of_vmf = std::get_if<MirrorFlakes<Vmf>>(&medium)) {
      mirror.kappa = vmf_concentration(of_vmf->ndf.alpha());
      mirror.scale = of_vmf->ndf.density_of(of_vmf->ndf.axis()) / 4;
      layers->longest = std::min(layers->longest, 2 * of_vmf->ndf.alpha());
    }
    if (std::holds_alternative<MirrorFlakes<Sggx>>(medium) ||
        std::holds_alternative<MirrorFlakes<Vmf>>(medium)) {
      part.mirror = static_cast<int>(layers->mirrors.size());
      layers->mirrors.push_back(mirror);
      layers->of_mirror.push_back(&medium);
      layers->inverses.push_back(inverse);
    }
    layers->parts.push_back(part);
  }
  layers_ = std::move(layers);
}

MirrorPairs::MirrorPairs(MirrorPairs&&) noexcept = default;
MirrorPairs& MirrorPairs::operator=(MirrorPairs&&) noexcept = default;
MirrorPairs::~MirrorPairs() = default;

bool MirrorPairs::is_empty() const { return layers_->mirrors.empty(); }

MirrorPairs::Value MirrorPairs::operator()(Direction wi, Direction wo, double tolerance) const {
  if (is_empty() || (!layers_->stack.is_open_below() && (wi.z < 0 || wo.z < 0))) return {};
  Flight flight(*layers_, wi, wo);
  const double common = 1 / (std::abs(wi.z) * std::abs(wo.z));
  std::array<double, 5> breaks{-1, 0, 1, -wi.z, wo.z};
  std::sort(breaks.begin(), breaks.end());
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
