#pragma once

#include <array>
#include <cstdint>

#include "phase/random/lattice.h"
#include "phase/random/random.h"
#include "volume/result/tally.h"

namespace lamella {

/// Lattices (phase/random/lattice.h) for walks that are followed one by one: the place where a walk
/// begins is step 0, its k-th event step k.
class WalkLattice {
 public:
  explicit WalkLattice(std::uint64_t seed) : seed_(seed), numbers_(lattice_of_batches()) {}

  /// What a walk keeps of it.
  class Point {
   public:
    /// None: every number is random.
    Point() = default;
    Point(const LatticeNumbers& numbers, std::uint32_t point, std::uint32_t shift)
        : numbers_(&numbers), point_(point), shift_(shift) {}

    /// Whether the words of that step are a lattice's.
    [[nodiscard]] bool has(std::uint64_t step) const {
      return numbers_ && step < static_cast<std::uint64_t>(kLatticeSteps);
    }
    /// A word of a step that it has.
    [[nodiscard]] std::uint32_t word(std::uint64_t step, int word) const {
      return lattice_word(*numbers_, word, static_cast<std::uint32_t>(step), point_, shift_);
    }
    /// The next numbers of the stream are the words `first` to `first` + 3 of that step, if it has
    /// them.
    void put(std::uint64_t step, int first, RandomStream& stream) const {
      if (!has(step)) return;
      stream.put(
          {word(step, first), word(step, first + 1), word(step, first + 2), word(step, first + 3)});
    }

   private:
    const LatticeNumbers* numbers_ = nullptr;
    std::uint32_t point_ = 0, shift_ = 0;
  };

  /// Of walk j of a batch.
  [[nodiscard]] Point point(int batch, std::uint64_t j) const {
    return {numbers_, reversed_bits(lattice_point(j)),
            lattice_shift(seed_, static_cast<std::uint32_t>(batch), j)};
  }
  /// Of the walk with that index, see walk_of_batch.
  [[nodiscard]] Point point(std::uint64_t index) const {
    return point(static_cast<int>(index % kBatches), index / kBatches);
  }

 private:
  std::uint64_t seed_;
  LatticeNumbers numbers_;
};

}  // namespace lamella
