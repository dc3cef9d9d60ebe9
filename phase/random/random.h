#pragma once

#include <Random123/philox.h>

#include <array>
#include <cmath>
#include <cstdint>

namespace lamella {

/// What a stream of random numbers is for. Streams of one walk with different purposes are
/// independent of each other.
enum class StreamPurpose : std::uint32_t {
  walk = 0,
  targets = 1,
  test = 2,
  model = 3,
  geometry = 4,
  measure = 5,
  ways = 6,
  // 7: the shifts of lattices (lattice.cpp)
  shadow = 8  // and, in the bits above, which of the walk's shadow rays
};

/// Counter-based random numbers: (seed, index, purpose, position) -> number, so that a walk has the
/// same numbers in whatever thread, batch or shard it runs. Philox 4x32 with 7 rounds, the fewest
/// that its authors found to pass BigCrush (Salmon et al. 2011, "Parallel random numbers: as easy
/// as 1, 2, 3", table 2).
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t index, StreamPurpose purpose)
      : key_{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}},
        counter_{{0, static_cast<std::uint32_t>(purpose), static_cast<std::uint32_t>(index),
                  static_cast<std::uint32_t>(index >> 32)}} {}

  /// 32 random bits.
  [[nodiscard, gnu::always_inline]] std::uint32_t bits() {
    if (used_ == 4) refill();
    return block_.v[used_++];
  }

  /// Uniform in (0, 1), a multiple of 2^-33 that is never 0 and never 1.
  [[nodiscard, gnu::always_inline]] double uniform() { return uniform_of(bits()); }
  [[nodiscard, gnu::always_inline]] static double uniform_of(std::uint32_t word) {
    return (word + 0.5) * 0x1p-32;
  }

  /// Four uniforms at once, a whole block: words left over from the block before are not used. Four
  /// words that were put and of which none is used are a whole block.
  [[nodiscard, gnu::always_inline]] std::array<double, 4> four_uniforms() {
    const auto block = used_ == 0 ? block_ : next_block();
    if (used_ == 0) used_ = 4;
    return {(block.v[0] + 0.5) * 0x1p-32, (block.v[1] + 0.5) * 0x1p-32,
            (block.v[2] + 0.5) * 0x1p-32, (block.v[3] + 0.5) * 0x1p-32};
  }

  /// The next four words, in the place of what is left of the block under way.
  void put(const std::array<std::uint32_t, 4>& words) {
    for (int k = 0; k < 4; ++k) block_.v[k] = words[k];
    used_ = 0;
  }
  /// The next two words, in the same place.
  void put(std::uint32_t first, std::uint32_t second) {
    block_.v[2] = first;
    block_.v[3] = second;
    used_ = 2;
  }

  /// Exponentially distributed with mean 1, in (0, infinity). The smallest cell of the uniform
  /// number is resolved further, so that the tail is not cut at 32 ln 2.
  [[nodiscard]] double exponential() {
    double tail = 0;
    std::uint32_t b = bits();
    while (b == 0) [[unlikely]] {
        tail += 32 * 0.69314718055994530942;
        b = bits();
      }
    return tail - std::log((b + 0.5) * 0x1p-32);
  }

 private:
  [[nodiscard, gnu::always_inline]] r123::Philox4x32::ctr_type next_block() {
    const auto block = r123::Philox4x32_R<7>()(counter_, key_);
    ++counter_.v[0];
    return block;
  }
  // Apart, so that the rest of `bits` is inlined everywhere.
  [[gnu::noinline]] void refill() {
    block_ = next_block();
    used_ = 0;
  }

  r123::Philox4x32::key_type key_;
  r123::Philox4x32::ctr_type counter_;
  r123::Philox4x32::ctr_type block_{};
  int used_ = 4;
};

}  // namespace lamella
