#include "compare/bench/benchmark.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"

namespace lamella {

using Json = nlohmann::ordered_json;

Json to_json(const BenchmarkRow& row) {
  const auto number = [](std::optional<double> x) {
    return x && std::isfinite(*x) ? Json(*x) : Json(nullptr);
  };
  Json out{{"what", row.what},
           {"kind", row.kind},
           {"seconds", number(row.seconds)},
           {"collisions_per_second_per_core", number(row.collisions_per_second_per_core)},
           {"ns_per_eval", number(row.ns_per_eval)},
           {"error", number(row.error)},
           {"baseline", row.baseline.empty() ? Json(nullptr) : Json(row.baseline)},
           {"ratio_to_baseline", number(row.ratio_to_baseline)}};
  if (row.extra.is_object()) out.update(row.extra);
  return out;
}

double noise_of(const LobeEstimate& lobe) {
  double noise = 0, signal = 0;
  for (std::size_t k = 0; k < lobe.value.size(); ++k) {
    noise += lobe.standard_error[k] * lobe.standard_error[k];
    signal += lobe.value[k] * lobe.value[k];
  }
  return signal > 0 ? std::sqrt(noise / signal) : 0;
}

double advance_for(Simulation& simulation, double seconds) {
  double taken = 0;
  for (std::uint64_t walks = std::max<std::uint64_t>(16 * kBatches, simulation.stride());
       taken < seconds; walks *= 2)
    taken += seconds_of([&] { simulation.advance(walks); });
  return taken;
}

const std::vector<BenchmarkStack>& benchmark_stacks() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  static const std::vector<BenchmarkStack> list{
      {"lambert_sphere_halfspace", {TextbookMedium::lambert_sphere, 0, kInfinity, 0.9}},
      {"sggx_slab", {TextbookMedium::sggx_mirror, 0.5, 2, 0.9}},
      {"vmf_halfspace", {TextbookMedium::vmf_lambert, 0.5, kInfinity, 0.9}},
      {"hg_slab", {TextbookMedium::henyey_greenstein, 0.7, 4, 0.9}},
  };
  return list;
}

std::vector<BenchmarkStack> benchmark_media() {
  std::vector<BenchmarkStack> list = benchmark_stacks();
  list.push_back({"sggx_lambert",
                  {TextbookMedium::sggx_lambert, 0.5, 2, 0.9},
                  "[[layer]]\nmedium = \"sggx\"\nroughness = 0.5\nflake = \"lambert\"\n"
                  "thickness = 2\nalbedo = 0.9\n"});
  list.push_back({"vmf_mirror",
                  {TextbookMedium::vmf_mirror, 0.5, 2, 0.9},
                  "[[layer]]\nmedium = \"vmf_flake\"\nroughness = 0.5\nflake = \"mirror\"\n"
                  "thickness = 2\nalbedo = 0.9\n"});
  return list;
}

Stack BenchmarkStack::stack() const {
  return toml.empty() ? load_stack(name) : parse_stack(toml, name, name);
}

Direction benchmark_incident() { return direction_from_degrees(60, 0); }

std::vector<Direction> benchmark_points(int count) {
  // The golden angle apart in phi: no two points share a half plane.
  constexpr double kGoldenAngle = 2.399963229728653;
  std::vector<Direction> points;
  for (int j = 0; j < count; ++j)
    points.push_back(direction_from_mu_phi((j + 0.5) / count, 1 + kGoldenAngle * j));
  return points;
}

}  // namespace lamella
