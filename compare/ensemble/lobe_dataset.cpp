#include "compare/ensemble/lobe_dataset.h"

#include <fmt/format.h>

#include "compare/ensemble/stack_ensemble.h"
#include "compare/files/zip_entries.h"

namespace lamella {
namespace {

template <class T>
std::string npy(const std::string& type, const std::string& shape, const std::vector<T>& numbers) {
  return npy_header(type, shape) +
         std::string(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T));
}

void put(std::vector<float>& to, double x) { to.push_back(static_cast<float>(x)); }

void put_layer(std::vector<float>& to, const Layer& layer) {
  const Direction axis = layer.parameters.vector("axis");
  put(to, layer.parameters.number("roughness"));
  for (int c = 0; c < 3; ++c) put(to, layer.albedo[c]);
  put(to, layer.depth());
  for (int c = 0; c < 3; ++c) put(to, layer.f0[c]);
  put(to, layer.parameters.choice("shape") == "fiber" ? 1 : 0);
  for (const double x : {axis.x, axis.y, axis.z}) put(to, x);
}

}  // namespace

LobeDatum lobe_datum(const LobeDatasetPlan& plan, std::uint64_t number) {
  LobeDatum datum{random_spongecake_stack(plan.layers, plan.seed, number), {}};
  const std::uint64_t seed =
      plan.seed + (((number + 1) * 16 + static_cast<std::uint64_t>(plan.layers)) << 8);
  datum.lobes = multiple_lobes(datum.stack,
                               random_directions(plan.directions, plan.layers, plan.seed, number),
                               plan.grid, plan.walks, seed);
  return datum;
}

std::string block_name(std::uint64_t block) { return fmt::format("block_{:05}.npz", block); }

std::string lobe_block(const std::vector<LobeDatum>& data, std::uint64_t first) {
  const std::size_t n = data.size(), layers = data.front().stack.layers.size(),
                    directions = data.front().lobes.incident.size();
  const CellGrid& grid = data.front().lobes.grid;
  std::vector<std::uint64_t> number;
  std::vector<float> parameters, incident, f, noise;
  for (const LobeDatum& one : data) {
    number.push_back(first + number.size());
    for (const Layer& layer : one.stack.layers) put_layer(parameters, layer);
    for (const Direction w : one.lobes.incident)
      for (const double x : {w.x, w.y, w.z}) put(incident, x);
    f.insert(f.end(), one.lobes.value.begin(), one.lobes.value.end());
    put(noise, one.lobes.relative_noise());
  }
  std::string bytes;
  ZipEntries zip;
  const auto add = [&](const std::string& name, const std::string& array) {
    bytes += zip.begin(name + ".npy", checksum(array), array.size());
    bytes += array;
  };
  add("number", npy("<u8", fmt::format("({},)", n), number));
  add("parameters", npy("<f4", fmt::format("({}, {}, 12)", n, layers), parameters));
  add("w_i", npy("<f4", fmt::format("({}, {}, 3)", n, directions), incident));
  add("f",
      npy("<f4", fmt::format("({}, {}, 2, {}, {}, 3)", n, directions, grid.rows(), grid.columns()),
          f));
  add("noise", npy("<f4", fmt::format("({},)", n), noise));
  return bytes + zip.end();
}

}  // namespace lamella
