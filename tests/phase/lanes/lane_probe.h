#pragma once

#include <cstddef>
#include <cstdint>

#include "phase/lanes/isa.h"

namespace lamella {

// The functions of phase/lane_*.h over arrays of any multiple of 16 numbers, for each instruction
// set.
LAMELLA_LANE_FUNCTION(void, probe_math,
                      (const float* x, float* log, float* exp, float* sine, float* cosine,
                       std::size_t count))
LAMELLA_LANE_FUNCTION(void, probe_turns,
                      (const float* y, const float* x, float* turns, std::size_t count))
LAMELLA_LANE_FUNCTION(void, probe_reciprocals,
                      (const float* x, float* reciprocal, float* reciprocal_sqrt, float* cube_root,
                       std::size_t count))
/// phase/lanes/lane_erf.h
LAMELLA_LANE_FUNCTION(void, probe_scaled_erfc, (const float* x, float* value, std::size_t count))
/// phase/lanes/double_lanes.h; log of |x|, exp of x.
LAMELLA_LANE_FUNCTION(void, probe_double_math,
                      (const double* x, double* log, double* exp, double* cos, double* erf,
                       std::size_t count))
LAMELLA_LANE_FUNCTION(void, probe_angles,
                      (const double* sine, const double* cosine, double* angle, std::size_t count))
/// words: four per counter, one after the other.
LAMELLA_LANE_FUNCTION(void, probe_philox,
                      (std::uint64_t seed, const std::uint32_t* c0, const std::uint32_t* c2,
                       std::uint32_t purpose, std::uint32_t* words, std::size_t count))
/// state: four words per walk, one after the other; words: `draws` words per walk, one after the
/// other.
LAMELLA_LANE_FUNCTION(void, probe_walk_numbers,
                      (const std::uint32_t* state, std::uint32_t* words, std::size_t count,
                       std::size_t draws))
/// What is drawn from words.
LAMELLA_LANE_FUNCTION(void, probe_words,
                      (const std::uint32_t* words, float* uniform, float* signed_uniform,
                       float* fine, float* exponential, float* sine, float* cosine,
                       std::size_t count))
/// phase/random/lane_truncated.h: the chance of a collision within tau, and where one is by a word.
LAMELLA_LANE_FUNCTION(void, probe_truncated,
                      (const float* tau, const std::uint32_t* words, float* chance, float* length,
                       std::size_t count))
/// Words below 2^31, floats by their bits: bits 0 and 1 of conditions[i] are is_below(a, b) and
/// is_within(x, limit) of those at i; xors: xor_of(a, b, 0x5A5A1234).
LAMELLA_LANE_FUNCTION(void, probe_conditions,
                      (const std::uint32_t* a, const std::uint32_t* b, const float* x,
                       const float* limit, std::uint32_t* conditions, std::uint32_t* xors,
                       std::size_t count))
/// highest_bit(a), a from 1 to 2^24, and word_with_bit of that.
LAMELLA_LANE_FUNCTION(void, probe_highest_bits,
                      (const std::uint32_t* a, std::uint32_t* places, std::uint32_t* words,
                       std::size_t count))
/// Bit k of masks[i] is the condition of lane k of group i: the chosen lanes of x in order, the
/// ranks, and x permuted by them. Returns the lanes of a group.
LAMELLA_LANE_FUNCTION(int, probe_masks,
                      (const float* x, const std::uint32_t* masks, float* compressed,
                       std::uint32_t* ranks, float* permuted, std::uint32_t* bits,
                       std::size_t groups))

}  // namespace lamella
