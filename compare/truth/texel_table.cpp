#include "compare/truth/texel_table.h"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <numeric>

#include "compare/truth/solved_texels.h"
#include "compare/truth/texel_mean.h"

namespace lamella {
namespace {

constexpr std::size_t kBlocks = 4;  // along either side of a map

// One of each block's squares, so that columns and rows of squares have one each.
std::vector<std::size_t> sample_of(std::size_t side) {
  std::vector<std::size_t> sample;
  for (std::size_t j = 0; j < kBlocks; ++j)
    for (std::size_t i = 0; i < kBlocks; ++i) {
      const std::size_t column = (kBlocks * i + j) * side / (kBlocks * kBlocks);
      const std::size_t row = (kBlocks * j + i) * side / (kBlocks * kBlocks);
      sample.push_back(row * side + column);
    }
  return sample;
}

std::size_t side_of(std::size_t texels) {
  std::size_t side = 1;
  while ((side + 1) * (side + 1) <= texels) ++side;
  return side;
}

}  // namespace

TexelTable table_of_texels(const TruthRequest& request, const StopFlag* stop,
                           const SolverReport& report) {
  if (request.texels.empty()) return {LobeTable::make(request, stop, report), {}};
  const std::vector<std::size_t> first = first_equals(request.texels);
  const bool all = count_different(first) <= kMostSolvedTexels;
  std::vector<std::size_t> texels(first.size());
  std::iota(texels.begin(), texels.end(), std::size_t{0});
  if (!all) texels = sample_of(side_of(first.size()));
  std::map<std::size_t, std::size_t> counts;
  for (const std::size_t k : texels) ++counts[first[k]];
  std::size_t divisor = 0;
  for (const auto& [k, count] : counts) divisor = std::gcd(divisor, count);
  TexelTable found{};
  std::vector<LobeTable::Share> shares;
  const double part = 1 / static_cast<double>(texels.size());
  for (const auto& [k, count] : counts) {
    const TruthRequest one = request_of_texel(request, k, 1 / static_cast<double>(counts.size()));
    shares.push_back({std::make_shared<const LobeTable>(LobeTable::make(one, stop, report)),
                      static_cast<double>(count) * part});
    for (std::size_t n = 0; n < count / divisor; ++n) found.texels.push_back(one.stack);
    if (is_set(stop)) break;
  }
  const std::string source =
      fmt::format("the mean over {} texels of the map{}; the first by {}", counts.size(),
                  all ? ", which are all that differ" : "", shares.front().table->source());
  found.table = LobeTable::mean(std::move(shares), source);
  return found;
}

}  // namespace lamella
