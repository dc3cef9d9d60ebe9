#include "volume/run/saved_walks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "volume/result/number_bytes.h"

namespace lamella {
namespace {

// Every number of EnergySums is a double.
constexpr std::size_t kEnergies = sizeof(EnergySums) / sizeof(double);
static_assert(std::is_trivially_copyable_v<EnergySums> &&
              sizeof(EnergySums) == kEnergies * sizeof(double));

bool are_finite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

BatchTally read_tally(NumberReader& in, std::size_t targets) {
  BatchTally tally;
  tally.walks = in.get<std::uint64_t>();
  tally.collisions = in.get<std::uint64_t>();
  tally.holes = in.get<std::uint64_t>();
  std::array<double, kEnergies> energies{};
  in.fill(std::span<double>(energies));
  if (targets > in.left() / sizeof(double)) throw DamagedBytes("it ends within a batch");
  tally.f.resize(targets);
  in.fill(std::span<double>(tally.f));
  if (!are_finite(energies) || !are_finite(tally.f))
    throw DamagedBytes("a sum of its walks is not finite");
  tally.energy = std::bit_cast<EnergySums>(energies);
  return tally;
}

}  // namespace

std::string save_walks(const Simulation& simulation, double seconds, bool done) {
  NumberWriter out;
  out.put(static_cast<std::uint32_t>(simulation.estimator()));
  out.put(simulation.walks());
  out.put(seconds);
  out.put(static_cast<std::uint8_t>(done));
  const BatchRange range = simulation.range();
  const auto& batches = simulation.batches();
  out.put(static_cast<std::uint64_t>(batches.front().f.size()));
  out.put(static_cast<std::uint32_t>(range.end - range.first));
  for (int b = range.first; b < range.end; ++b) {
    const BatchTally& tally = batches[b];
    out.put(static_cast<std::uint32_t>(b));
    for (const std::uint64_t count : {tally.walks, tally.collisions, tally.holes}) out.put(count);
    const auto energies = std::bit_cast<std::array<double, kEnergies>>(tally.energy);
    out.put_all(std::span<const double>(energies));
    out.put_all(std::span<const double>(tally.f));
    out.put_text(done ? std::string() : simulation.lane_counts(b));
  }
  return out.take();
}

SavedWalks restore_walks(std::string_view bytes, Simulation& simulation, std::vector<bool>& there) {
  NumberReader in(bytes);
  if (const auto estimator = in.get<std::uint32_t>();
      estimator != static_cast<std::uint32_t>(simulation.estimator()))
    throw DamagedBytes("its walks are counted by another estimator");
  SavedWalks saved;
  saved.walks = in.get<std::uint64_t>();
  saved.seconds = in.get<double>();
  if (!(saved.seconds >= 0 && std::isfinite(saved.seconds)))
    throw DamagedBytes("its walks took no time that could be");
  saved.done = in.get<std::uint8_t>() != 0;
  const std::size_t targets = simulation.batches().front().f.size();
  if (const auto count = in.get<std::uint64_t>(); count != targets)
    throw DamagedBytes(fmt::format("its batches have {} sums, not {}", count, targets));
  const auto count = in.get<std::uint32_t>();
  if (count > kBatches) throw DamagedBytes("it has too many batches");
  there.resize(kBatches);
  for (std::uint32_t k = 0; k < count; ++k) {
    const auto batch = in.get<std::uint32_t>();
    if (batch >= kBatches) throw DamagedBytes("it has a batch that is none");
    if (there[batch]) throw DamagedBytes(fmt::format("it has batch {}, which is there", batch));
    BatchTally tally = read_tally(in, targets);
    if (tally.walks != Simulation::walks_of_batch(static_cast<int>(batch), saved.walks))
      throw DamagedBytes(fmt::format("batch {} has another number of walks", batch));
    simulation.restore(static_cast<int>(batch), std::move(tally), in.get_text());
    there[batch] = true;
    saved.batches.push_back(static_cast<int>(batch));
  }
  in.end();
  simulation.restore_walks(saved.walks);
  return saved;
}

}  // namespace lamella
