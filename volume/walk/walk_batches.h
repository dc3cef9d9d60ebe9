#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "volume/result/tally.h"

namespace lamella {

/// Runs the walks `from` to `to` (not included) of a batch.
using RunBatch = std::function<void(int batch, std::uint64_t from, std::uint64_t to)>;

/// The index of a batch's i-th walk: batch b has the walks b, b + kBatches, ...
[[nodiscard]] constexpr std::uint64_t walk_of_batch(int batch, std::uint64_t i) {
  return i * kBatches + batch;
}

/// Batches of walks that are followed one by one. make_scorer(batch) gives the scorer that the
/// walks of a batch share, and that may have something left to do when they end (end_batch);
/// follow(index, scorer, tally) follows one walk. `batches` outlives the result.
template <class MakeScorer, class Follow>
[[nodiscard]] RunBatch batches_of_walks(std::uint64_t seed, std::vector<BatchTally>& batches,
                                        MakeScorer make_scorer, Follow follow) {
  return [=, &batches](int batch, std::uint64_t from, std::uint64_t to) {
    auto scorer = make_scorer(batch);
    for (std::uint64_t i = from; i < to; ++i) {
      const std::uint64_t index = walk_of_batch(batch, i);
      scorer.begin_walk(seed, index);
      follow(index, scorer, batches[batch]);
    }
    if constexpr (requires { scorer.end_batch(); }) scorer.end_batch();
  };
}

}  // namespace lamella
