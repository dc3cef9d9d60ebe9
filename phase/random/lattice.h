#pragma once

#include <cstdint>

#include "phase/math/real.h"

namespace lamella {

// Numbers: 32-bit words, uniform. Domain: walks of one batch, the first kLatticeSteps steps.
// Error: the point sets are unbiased up to the spacing of 2^32 shifts (below 1e-9 of a variance).
//
// The first numbers of a walk as the coordinates of a point of a rank-1 lattice, so that the walks
// of a batch fill the space of these numbers evenly. Walk j of a batch, modulo kLatticePoints, has
// the coordinates
//
//   x_d = r(j) g_d + T h_d   modulo 2^32,
//
// r: the 32 bits of j in reverse order; g: the generating vector, odd numbers; T: a random number
// per batch; h: odd numbers that spread it over the dimensions. The first 2^m walks are a whole
// lattice of 2^m points for every m (Hickernell, Hong, L'Ecuyer, Lemieux 2000, "Extensible lattice
// sequences for quasi-Monte Carlo quadrature"), randomly shifted (Cranley and Patterson 1976). Each
// coordinate alone is uniform, batches are independent of each other.
// phase/random/lattice_generator.h has g, and how it was found.

/// Steps of a walk whose words are those of a lattice.
inline constexpr int kLatticeSteps = 8;
/// After this many walks a batch begins anew with another shift: larger lattices were not looked
/// at, and one that happens to be bad has more variance than random numbers.
inline constexpr std::uint64_t kLatticePoints = 1 << 14;
/// Words of a step: eight of its event, and two of the place that next-event estimation aims at.
inline constexpr int kLatticeWords = 10, kLatticeTargetWord = 8;
/// Words before the first step: flight, roulette, thinning.
inline constexpr int kLatticeBeginnings = 3;

/// What the words of a lattice are made of, as walks on lanes use it.
struct LatticeNumbers {
  /// g by word and step, the steps twice: whole registers of sixteen.
  alignas(64) std::uint32_t generator[kLatticeWords][16];
  /// T h of the batch in the same order, or where `by_walk` h alone.
  alignas(64) std::uint32_t shift[kLatticeWords][16];
  std::uint32_t begin_generator[kLatticeBeginnings], begin_shift[kLatticeBeginnings];
  bool by_walk;  ///< walks of several batches, which carry T
};

/// Numbers of the walks of one batch, T being its shift.
[[nodiscard]] LatticeNumbers lattice_of_batch(std::uint32_t shift);
/// Numbers of walks that carry their batch's T.
[[nodiscard]] LatticeNumbers lattice_of_batches();

/// T of a batch's walk j.
[[nodiscard]] std::uint32_t lattice_shift(std::uint64_t seed, std::uint32_t batch, std::uint64_t j);
/// Its number within the lattice, which r is of.
[[nodiscard]] constexpr std::uint32_t lattice_point(std::uint64_t j) {
  return static_cast<std::uint32_t>(j % kLatticePoints);
}

/// table[step] of 16 words, the last eight of which repeat the first; of the step its last three
/// bits count. phase/random/lane_random.h has that of lanes.
[[nodiscard]] LAMELLA_INLINE std::uint32_t step_entry(const std::uint32_t* table,
                                                      std::uint32_t step) {
  return table[step & 7];
}

/// r(j).
template <class Words>
[[nodiscard]] LAMELLA_INLINE Words reversed_bits(Words j) {
  const auto swapped = [](Words up, Words down, std::uint32_t mask) LAMELLA_INLINE_LAMBDA {
    return (up & Words(~mask)) | (down & Words(mask));
  };
  j = swapped(shift_left<1>(j), shift_right<1>(j), 0x55555555u);
  j = swapped(shift_left<2>(j), shift_right<2>(j), 0x33333333u);
  j = swapped(shift_left<4>(j), shift_right<4>(j), 0x0F0F0F0Fu);
  j = swapped(shift_left<8>(j), shift_right<8>(j), 0x00FF00FFu);
  return shift_left<16>(j) | shift_right<16>(j);
}

/// A word of a step below kLatticeSteps. point: r(j). batch: T, where numbers are by walk.
template <class Words>
[[nodiscard]] LAMELLA_INLINE Words lattice_word(const LatticeNumbers& n, int word, Words step,
                                                Words point, Words batch) {
  Words shift = step_entry(n.shift[word], step);
  if (n.by_walk) shift = shift * batch;
  return point * step_entry(n.generator[word], step) + shift;
}

/// A word before the first step.
template <class Words>
[[nodiscard]] LAMELLA_INLINE Words lattice_beginning(const LatticeNumbers& n, int word, Words point,
                                                     Words batch) {
  Words shift(n.begin_shift[word]);
  if (n.by_walk) shift = shift * batch;
  return point * Words(n.begin_generator[word]) + shift;
}

}  // namespace lamella
