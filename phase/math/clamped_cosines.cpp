#include "phase/math/clamped_cosines.h"

namespace lamella {
namespace {

// Half width of the arc in which a + b cos(phi) is positive, b >= 0; in [0, pi].
double half_arc(double a, double b) {
  if (a >= b) return kPi;
  if (a <= -b) return 0;
  return std::acos(-a / b);
}

}  // namespace

ClampedCosines::ClampedCosines(Direction wi, Direction wo, Direction axis)
    : ui_(std::clamp(dot(wi, axis), -1.0, 1.0)),
      uo_(std::clamp(dot(wo, axis), -1.0, 1.0)),
      si_(length(cross(wi, axis))),
      so_(length(cross(wo, axis))) {
  const Direction ti = wi - ui_ * axis, to = wo - uo_ * axis;
  gap_ = std::atan2(length(cross(ti, to)), dot(ti, to));
  const Direction normal = cross(wi, wo);
  const double sine = length(normal);
  meeting_ = sine > 0 ? std::min(1.0, std::abs(dot(normal, axis)) / sine) : 0;
}

double ClampedCosines::overlap(double v) const {
  const double s = std::sqrt(std::max(0.0, (1 - v) * (1 + v)));
  const double ai = ui_ * v, bi = si_ * s, ao = uo_ * v, bo = so_ * s;
  const double arc_i = half_arc(ai, bi), arc_o = half_arc(ao, bo);
  const double cos_gap = std::cos(gap_);
  const auto integral = [&](double from, double to) {
    if (!(to > from)) return 0.0;
    const auto primitive = [&](double phi) {
      return ai * ao * phi + ao * bi * std::sin(phi) + ai * bo * std::sin(phi - gap_) +
             bi * bo * (phi * cos_gap / 2 + std::sin(2 * phi - gap_) / 4);
    };
    return primitive(to) - primitive(from);
  };
  if (arc_i == kPi && arc_o == kPi) return integral(-kPi, kPi);
  if (arc_i == kPi) return integral(gap_ - arc_o, gap_ + arc_o);
  if (arc_o == kPi) return integral(-arc_i, arc_i);
  // The arc about 0 against the one about gap, and against its copy a turn earlier.
  return integral(std::max(-arc_i, gap_ - arc_o), std::min(arc_i, gap_ + arc_o)) +
         integral(-arc_i, std::min(arc_i, gap_ + arc_o - 2 * kPi));
}

}  // namespace lamella
