#include "analytic/model/clipped_cosine.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "phase/math/direction.h"

namespace lamella {
namespace {

constexpr std::array<const char*, 5> kNames{"mis", "cltc", "ltc", "cosine", "uniform"};

/// Of the clipped unit disc, over pi.
double clipped_area(double d) { return 0.5 * (1 + 1 / std::sqrt(1 + d * d)); }

Direction transformed(const ClippedCosine& m, Direction h) {
  return normalized(Direction{m.a * h.x + m.b * h.z, m.c * h.y, m.d * h.x + h.z});
}

Direction above(Direction w) { return {w.x, w.y, std::max(w.z, 0.0)}; }

Direction from_disc(double x, double y) {
  return {x, y, std::sqrt(std::max(0.0, 1 - x * x - y * y))};
}

Direction sample_cosine(double u2, double u3) {
  const double radius = std::sqrt(u2), phi = 2 * kPi * u3;
  return from_disc(radius * std::cos(phi), radius * std::sin(phi));
}

Direction sample_uniform(double u2, double u3) {
  const double s = std::sqrt((1 - u2) * (1 + u2)), phi = 2 * kPi * u3;
  return {s * std::cos(phi), s * std::sin(phi), u2};
}

/// The part of the unit disc over which d x + z > 0: half the disc and, on the side where d x < 0,
/// half an ellipse. Each chord of the disc is squeezed onto its part.
Direction sample_clipped(const ClippedCosine& m, double u2, double u3) {
  const double radius = std::sqrt(u2), phi = 2 * kPi * u3;
  const double y = radius * std::sin(phi);
  const double chord = std::sqrt(std::max(0.0, 1 - y * y));
  const double x =
      std::copysign(1.0, m.d) * (chord + clipped_area(m.d) * (radius * std::cos(phi) - chord));
  return above(transformed(m, from_disc(x, y)));
}

/// The lobe without the clip.
double transformed_pdf(const ClippedCosine& m, Direction wi) {
  const double e = m.a - m.b * m.d, determinant = m.c * e;
  // The adjugate of M times w_i
  const Direction h{m.c * (wi.x - m.b * wi.z), e * wi.y, m.c * (m.a * wi.z - m.d * wi.x)};
  const double l2 = dot(h, h);
  return std::max(0.0, h.z) * determinant * determinant / (l2 * l2 * kPi);
}

}  // namespace

ParameterInfo sampler_parameter() {
  return {.name = "sampler",
          .kind = ParameterKind::choice,
          .unit = "1",
          .doc = "how w_i is drawn; changes no value",
          .default_value = kNames[0],
          .choices = {kNames.begin(), kNames.end()}};
}

HemisphereSampler sampler_of(const Parameters& parameters) {
  const auto it = std::find(kNames.begin(), kNames.end(), parameters.choice("sampler"));
  return static_cast<HemisphereSampler>(it - kNames.begin());
}

Direction ClippedCosine::sample(HemisphereSampler sampler, double u1, double u2, double u3) const {
  switch (sampler) {
    case HemisphereSampler::mis:
      return u1 < uniform ? sample_uniform(u2, u3) : sample_clipped(*this, u2, u3);
    case HemisphereSampler::cltc:
      return sample_clipped(*this, u2, u3);
    case HemisphereSampler::ltc:
      return transformed(*this, sample_cosine(u2, u3));
    case HemisphereSampler::cosine:
      return sample_cosine(u2, u3);
    case HemisphereSampler::uniform:
      break;
  }
  return sample_uniform(u2, u3);
}

double ClippedCosine::pdf(HemisphereSampler sampler, Direction wi) const {
  if (sampler == HemisphereSampler::ltc) return transformed_pdf(*this, wi);
  if (wi.z < 0) return 0;
  const auto clipped = [&] { return transformed_pdf(*this, wi) / clipped_area(d); };
  switch (sampler) {
    case HemisphereSampler::mis:
      return uniform / (2 * kPi) + (1 - uniform) * clipped();
    case HemisphereSampler::cltc:
      return clipped();
    case HemisphereSampler::cosine:
      return wi.z / kPi;
    default:
      return 1 / (2 * kPi);
  }
}

Frame<double> frame_towards(Direction w) {
  const double s = std::sqrt(w.x * w.x + w.y * w.y);
  const Direction x = s > 0 ? Direction{w.x / s, w.y / s, 0} : Direction{1, 0, 0};
  return {x, {-x.y, x.x, 0}, {0, 0, 1}};
}

}  // namespace lamella
