#include "compare/judge/parameter_steps.h"

namespace lamella {

bool is_white(const ParameterInfo& p) {
  for (const char* name :
       {"albedo", "f0", "bulk_albedo", "base.albedo", "base_color", "specular_color", "color"})
    if (p.name == name) return true;
  return false;
}

bool is_shape(const ParameterInfo& p) {
  constexpr double kWidestRange = 100;
  const bool fixed = p.name.ends_with("ior") || p.name.ends_with("_y");
  return p.kind == ParameterKind::number && !p.name.starts_with("bulk_") &&
         p.max - p.min <= kWidestRange && !fixed;
}

std::vector<double> steps_of_range(const ParameterInfo& p, int steps) {
  std::vector<double> list;
  for (int k = 0; k < steps; ++k) {
    double x = p.min + (p.max - p.min) * k / (steps - 1);
    if (x == p.max && p.max_open) x -= 1e-3 * (p.max - p.min);
    if (x == p.min && p.min_open) x += 1e-3 * (p.max - p.min);
    list.push_back(x);
  }
  return list;
}

}  // namespace lamella
