#include "phase/random/lattice.h"

#include <Random123/philox.h>

#include <iterator>

#include "phase/random/lattice_generator.h"

namespace lamella {
namespace {

// Beside those of StreamPurpose and of walks on lanes.
constexpr std::uint32_t kLatticeStream = 7;

// Of splitmix64 (Steele, Lea, Flood 2014), made odd: h.
std::uint32_t spread(int row, int word) {
  std::uint64_t z =
      0x9E3779B97F4A7C15u * static_cast<std::uint64_t>(row * kLatticeWords + word + 1);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return static_cast<std::uint32_t>((z ^ (z >> 31)) >> 32) | 1u;
}

static_assert(std::size(kLatticeGenerator) == 1 + kLatticeSteps &&
              std::size(kLatticeGenerator[0]) == kLatticeWords);

LatticeNumbers numbers_with(std::uint32_t factor) {
  LatticeNumbers n{};
  for (int word = 0; word < kLatticeBeginnings; ++word) {
    n.begin_generator[word] = kLatticeGenerator[0][word];
    n.begin_shift[word] = factor * spread(0, word);
  }
  for (int word = 0; word < kLatticeWords; ++word)
    for (int place = 0; place < 16; ++place) {
      const int row = 1 + place % kLatticeSteps;
      n.generator[word][place] = kLatticeGenerator[row][word];
      n.shift[word][place] = factor * spread(row, word);
    }
  return n;
}

}  // namespace

LatticeNumbers lattice_of_batch(std::uint32_t shift) {
  LatticeNumbers n = numbers_with(shift);
  n.by_walk = false;
  return n;
}

LatticeNumbers lattice_of_batches() {
  LatticeNumbers n = numbers_with(1);
  n.by_walk = true;
  return n;
}

std::uint32_t lattice_shift(std::uint64_t seed, std::uint32_t batch, std::uint64_t j) {
  return r123::Philox4x32_R<7>()(
             {{0, kLatticeStream, batch, static_cast<std::uint32_t>(j / kLatticePoints)}},
             {{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}})
      .v[0];
}

}  // namespace lamella
